#include "io/mesh_file.hpp"

#include <catch2/catch.hpp>
#include <cstring>
#include <fstream>

#include "perp/model/shape.hpp"

using namespace perp;
using Catch::Contains;

namespace {

const std::filesystem::path folder = std::filesystem::temp_directory_path() / "perp-mesh-file-test";

std::filesystem::path file(const std::string& name, const std::string& text) {
  std::filesystem::create_directories(folder);
  std::ofstream(folder / name, std::ios::binary) << text;
  return folder / name;
}

const std::string tetrahedron_obj =
    "# a comment\nv 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1/1/1 2//2 4\nf 1 4 3\nf 2 3 -1\n";

std::string stl_of(const TriangleMesh& mesh, bool binary) {
  std::string text = binary ? std::string(80, ' ') : "solid t\n";
  const auto append = [&](auto value) { text.append(reinterpret_cast<const char*>(&value), sizeof value); };
  if (binary) append(static_cast<std::uint32_t>(mesh.triangles.size()));
  for (const auto& triangle : mesh.triangles) {
    if (!binary) text += "facet normal 0 0 0\n outer loop\n";
    for (int k = 0; binary && k < 3; ++k) append(0.0F);
    for (const int i : triangle) {
      const Vector3& x = mesh.points[static_cast<std::size_t>(i)];
      if (!binary) text += "  vertex";
      for (const double value : x) {
        if (binary) append(static_cast<float>(value));
        if (!binary) text += " " + std::to_string(value);
      }
      if (!binary) text += "\n";
    }
    if (binary) append(std::uint16_t{0});
    if (!binary) text += " endloop\nendfacet\n";
  }
  return binary ? text : text + "endsolid t\n";
}

}  // namespace

TEST_CASE("meshes of OBJ and both kinds of STL are read alike", "[mesh]") {
  const TriangleMesh obj = read_mesh(file("t.obj", tetrahedron_obj));
  CHECK(obj.points.size() == 4);
  CHECK(obj.triangles.size() == 4);
  CHECK(obj.volume() == Approx(1.0 / 6));
  for (const bool binary : {true, false}) {
    const TriangleMesh stl = read_mesh(file("t.STL", stl_of(obj, binary)));
    CHECK(stl.points.size() == 4);
    CHECK(stl.volume() == Approx(1.0 / 6));
  }
}

TEST_CASE("a mesh that is no solid is refused by its file and line", "[mesh]") {
  const auto refusal = [](const std::string& name, const std::string& text) {
    try {
      (void)read_mesh(file(name, text));
    } catch (const std::invalid_argument& error) {
      return std::string(error.what());
    }
    return std::string("read");
  };
  const TriangleMesh good = read_mesh(file("t.obj", tetrahedron_obj));
  CHECK_THROWS_WITH(read_mesh(folder / "none.stl"), Contains("none.stl"));
  CHECK_THAT(refusal("t.dae", ""), Contains("'.dae'") && Contains(".stl or .obj"));
  CHECK_THAT(refusal("t.obj", "v 0 0 nan\n"), Contains("t.obj:1:1") && Contains("needs three numbers"));
  CHECK_THAT(refusal("t.obj", "v 0 0 0\nv 1 zwei 3\n"), Contains("t.obj:2:1") && Contains("zwei"));
  CHECK_THAT(refusal("t.obj", "v 0 0 0\nf 1 2 3\n"), Contains("t.obj:2:1") && Contains("corner '2'"));
  CHECK_THAT(refusal("t.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"), Contains("3 points"));
  CHECK_THAT(refusal("t.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 2 3\nf 1 4 2\nf 1 3 4\nf 2 4 3\n"),
             Contains("inwards"));
  CHECK_THAT(refusal("t.stl", stl_of(good, true).substr(0, 200)), Contains("cut short"));
  std::string many(84, ' ');
  const std::uint32_t count = 2'000'000;
  std::memcpy(many.data() + 80, &count, 4);
  CHECK_THAT(refusal("t.stl", many), Contains("2000000 triangles"));
}

TEST_CASE("the outermost points of a mesh have nearly its hull", "[mesh]") {
  std::vector<Vector3> points;
  for (int i = 0; i < 60; ++i)
    for (int k = 0; k < 30; ++k) {
      const double v = 0.1 * i, u = 0.1 * k;
      points.emplace_back(std::sin(u) * std::cos(v), 0.7 * std::sin(u) * std::sin(v), 0.5 * std::cos(u));
    }
  const std::vector<Vector3> few = outermost(points, 100);
  CHECK(few.size() == 100);
  const double all = Shape::polyhedron(points).volume(), part = Shape::polyhedron(few).volume();
  CHECK(part < all);
  CHECK(part > 0.9 * all);
  CHECK(outermost(few, 100).size() == 100);
}
