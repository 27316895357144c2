#include "io/mesh_file.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <map>
#include <sstream>

#include "core/files.hpp"
#include "core/index.hpp"
#include "io/toml_file.hpp"
#include "perp/core/errors.hpp"

namespace perp {
namespace {

/// Gathers triangles; a point that is there already keeps its number.
class Gatherer {
 public:
  explicit Gatherer(const std::string& file) : file_(file) {}

  int point(const Vector3& x, std::size_t line) {
    if (!x.allFinite()) refuse(line, "a coordinate that is not finite", "needs numbers");
    const auto [place, fresh] =
        number_.emplace(std::array{x.x(), x.y(), x.z()}, static_cast<int>(mesh.points.size()));
    if (fresh) mesh.points.push_back(x);
    return place->second;
  }
  void triangle(int a, int b, int c, std::size_t line) {
    if (mesh.triangles.size() == most_triangles)
      refuse(line, "more than a million triangles", "needs a coarser mesh: a hull has no use for them");
    mesh.triangles.push_back({a, b, c});
  }
  [[noreturn]] void refuse(std::size_t line, const std::string& what, const std::string& need) const {
    refuse_at(file_, line > 0 ? Place{line, 1} : Place{}, what, need);
  }

  TriangleMesh mesh;

 private:
  const std::string& file_;
  std::map<std::array<double, 3>, int> number_;
};

/// Header of 80 bytes, count, then fifty bytes a triangle: a normal, three corners, two bytes of no use.
void read_binary_stl(const std::string& bytes, Gatherer& out) {
  constexpr std::size_t head = 84, each = 50;
  std::uint32_t count = 0;
  if (bytes.size() < head) out.refuse(0, std::to_string(bytes.size()) + " bytes", "needs an STL file");
  std::memcpy(&count, bytes.data() + 80, 4);
  if (count > most_triangles) out.refuse(0, std::to_string(count) + " triangles", "needs a million at most");
  if (bytes.size() < head + each * count)
    out.refuse(0, std::to_string(bytes.size()) + " bytes for " + std::to_string(count) + " triangles",
               "is cut short: needs " + std::to_string(head + each * count));
  for (std::size_t i = 0; i < count; ++i) {
    std::array<float, 9> x{};
    std::memcpy(x.data(), bytes.data() + head + each * i + 12, sizeof x);
    int corner[3];
    for (std::size_t k = 0; k < 3; ++k)
      corner[k] = out.point(Vector3(x[3 * k], x[3 * k + 1], x[3 * k + 2]), 0);
    out.triangle(corner[0], corner[1], corner[2], 0);
  }
}

Vector3 three_numbers(std::istringstream& words, const Gatherer& out, std::size_t line) {
  Vector3 x;
  for (double& value : x) {
    std::string word;
    words >> word;
    std::istringstream number(word);
    number.imbue(std::locale::classic());
    if (!(number >> value) || !number.eof())
      out.refuse(line, word.empty() ? "a line that ends" : "'" + word + "'", "needs three numbers");
  }
  return x;
}

void read_text_stl(const std::string& text, Gatherer& out) {
  std::istringstream lines(text);
  std::string line;
  std::vector<int> corners;
  for (std::size_t n = 1; std::getline(lines, line); ++n) {
    std::istringstream words(line);
    std::string word;
    words >> word;
    if (word == "vertex") corners.push_back(out.point(three_numbers(words, out, n), n));
    if (word != "endfacet") continue;
    if (corners.size() != 3)
      out.refuse(n, "a facet of " + std::to_string(corners.size()) + " corners", "needs three");
    out.triangle(corners[0], corners[1], corners[2], n);
    corners.clear();
  }
}

/// Corners of a face are counted from 1, or from the last one backwards; more than three make a fan.
void read_obj(const std::string& text, Gatherer& out) {
  std::istringstream lines(text);
  std::string line;
  std::vector<int> number;  // of each v
  for (std::size_t n = 1; std::getline(lines, line); ++n) {
    std::istringstream words(line);
    std::string word;
    words >> word;
    if (word == "v") number.push_back(out.point(three_numbers(words, out, n), n));
    if (word != "f") continue;
    std::vector<int> loop;
    while (words >> word) {
      const long i = std::strtol(word.c_str(), nullptr, 10);
      const long place = i < 0 ? static_cast<long>(number.size()) + i : i - 1;
      if (place < 0 || place >= static_cast<long>(number.size()))
        out.refuse(n, "corner '" + word + "'",
                   "needs one of the " + std::to_string(number.size()) + " above");
      loop.push_back(number[static_cast<std::size_t>(place)]);
    }
    if (loop.size() < 3)
      out.refuse(n, "a face of " + std::to_string(loop.size()) + " corners", "needs three");
    for (std::size_t k = 1; k + 1 < loop.size(); ++k) out.triangle(loop[0], loop[k], loop[k + 1], n);
  }
}

}  // namespace

double TriangleMesh::volume() const {
  double six = 0;
  for (const auto& [a, b, c] : triangles) {
    const Vector3 &o = points[0], p = points[at(a)] - o, q = points[at(b)] - o, r = points[at(c)] - o;
    six += p.dot(q.cross(r));
  }
  return six / 6;
}

TriangleMesh read_mesh(const std::filesystem::path& path) {
  const std::string file = path.string();
  std::string ending = path.extension().string();
  std::transform(ending.begin(), ending.end(), ending.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  if (ending != ".stl" && ending != ".obj")
    refuse_at(file, {}, "a mesh file of the ending '" + ending + "'", "needs .stl or .obj");
  const std::string bytes = read_file(path, "needs a mesh file");
  Gatherer out(file);
  if (ending == ".obj")
    read_obj(bytes, out);
  else if (bytes.starts_with("solid") && bytes.find("facet") != std::string::npos)
    read_text_stl(bytes, out);
  else
    read_binary_stl(bytes, out);
  if (out.mesh.points.size() < 4)
    out.refuse(0, std::to_string(out.mesh.points.size()) + " points", "needs at least four");
  if (out.mesh.volume() < 0)
    out.refuse(0, "faces that look inwards", "needs corners counter-clockwise seen from outside");
  return std::move(out.mesh);
}

std::vector<Vector3> outermost(const std::vector<Vector3>& points, int most) {
  if (static_cast<int>(points.size()) <= most) return points;
  std::vector<Vector3> kept;
  std::vector<char> taken(points.size(), 0);
  const int directions = 4 * most;
  for (int k = 0; k < directions && static_cast<int>(kept.size()) < most; ++k) {
    // spread over the sphere so that every first part of them is spread too
    const double z = 1 - 2 * std::fmod(0.5 + 0.7548776662466927 * k, 1.0);
    const double angle = 2 * M_PI * std::fmod(0.5698402909980532 * k, 1.0), r = std::sqrt(1 - z * z);
    const Vector3 d(r * std::cos(angle), r * std::sin(angle), z);
    const auto furthest =
        std::max_element(points.begin(), points.end(),
                         [&](const Vector3& a, const Vector3& b) { return a.dot(d) < b.dot(d); });
    char& there = taken[static_cast<std::size_t>(furthest - points.begin())];
    if (there == 0) kept.push_back(*furthest);
    there = 1;
  }
  return kept;
}

}  // namespace perp
