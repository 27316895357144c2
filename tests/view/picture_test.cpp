// What is drawn of bodies: solids, their outlines, parts of bodies without a pose, and glTF's nodes.
#include <catch2/catch.hpp>
#include <cmath>
#include <nlohmann/json.hpp>

#include "core/index.hpp"
#include "perp/view/pictures.hpp"
#include "study/scene_picture.hpp"
#include "study/woodpecker_sizes.hpp"
#include "tests/cli/program.hpp"
#include "view/drawing.hpp"
#include "view/mesh.hpp"

namespace perp {
namespace {

using Kind = Solid::Kind;
using nlohmann::json;

TEST_CASE("a solid's outline holds all of it and no more", "[view]") {
  const Pose place{{1, -2, 0.5}, rotation({0.3, 0.4, -0.2})};
  const double thin = 1e-9;
  const std::vector<Solid> all = {
      {.kind = Kind::Sphere, .place = place, .size = {0.5, 0, 0}},
      {.kind = Kind::Box, .place = place, .size = {1, 2, 3}},
      {.kind = Kind::Capsule, .place = place, .size = {0.3, 1, 0}},
      {.kind = Kind::Cylinder, .size = {0.3, 1, 0}},
      {.kind = Kind::Disc, .size = {0.4, 0, 0}},
      {.kind = Kind::Ellipsoid, .size = {1, 2, 0.5}},
      {.kind = Kind::Ellipse, .size = {1, 0.5, 0}},
      {.kind = Kind::Stick, .place = place, .size = {1, 2, 3}},
      {.kind = Kind::Polygon, .place = place, .vertices = {{-1, -1, 0}, {2, -1, 0}, {0, 2, 0}}}};
  for (const Solid& solid : all) {
    INFO("solid " << name_of(solid.kind));
    Vector3 low = Vector3::Constant(infinity), high = -low, seen_low = low, seen_high = high;
    const Outline outline = outline_of(solid);
    for (const Vector3& p : outline.points) {
      low = low.cwiseMin(p - Vector3::Constant(outline.margin));
      high = high.cwiseMax(p + Vector3::Constant(outline.margin));
    }
    for (const Vector3& p : mesh_of(solid, 1, thin).vertices)
      seen_low = seen_low.cwiseMin(p), seen_high = seen_high.cwiseMax(p);
    const double size = (high - low).norm();  // meshes of round solids are inside them by 2 % at most
    CHECK((seen_low - low).cwiseAbs().maxCoeff() < 0.02 * size);
    CHECK((seen_high - high).cwiseAbs().maxCoeff() < 0.02 * size);
    CHECK((seen_low - low).minCoeff() > -10 * thin);
    CHECK((high - seen_high).minCoeff() > -10 * thin);
  }
  CHECK(outline_of({.kind = Kind::Plane}).points.empty());
}

TEST_CASE("the woodpecker's drawn beak and sleeve are as far from the pole as its gaps say", "[view]") {
  const WoodpeckerSizes size;
  const Scene s = scene("woodpecker");
  const std::vector<ScenePart> parts = picture_of(s);
  REQUIRE(parts.size() == 3);
  const ScenePart &sleeve = parts[1], &bird = parts[2];
  const double r_0 = parts[0].shapes[0].sizes()[0] / 2;
  for (const Vector3& angles : {Vector3(0, 0, 0), Vector3(0, -0.1, -0.28), Vector3(0.3, 0.05, 0.1)}) {
    const Vector q = angles;
    const double tiny = 2 * 0.02 * (q[1] * q[1] + q[2] * q[2]);  // the gaps are linear in the angles
    const Vector3 beak = bird.pose(q) * Vector3(size.l_G - size.l_S, size.h_S, 0);
    CHECK(beak.x() - r_0 ==
          Approx(size.l_M + size.l_G - size.l_S - size.r_0 - size.h_S * q[2]).margin(tiny + 1e-15));
    CHECK(beak.y() ==
          Approx(q[0] + size.h_S + size.l_M * q[1] + (size.l_G - size.l_S) * q[2]).margin(tiny + 1e-15));
    const Vector3 corner = sleeve.pose(q) * Vector3(size.r_M, -size.h_M, 0);
    CHECK(corner.x() - r_0 == Approx(size.r_M - size.r_0 + size.h_M * q[1]).margin(tiny + 1e-15));
  }
}

TEST_CASE("a generalized body whose scene says what it looks like is drawn, and moves by its coordinates",
          "[view]") {
  const Scratch scratch("view-woodpecker");
  REQUIRE(
      run_perp(scratch, "run woodpecker --method event --tolerance 1e-8 --until 0.1 --out " + (scratch / "o"))
          .status == 0);
  const RecordedRun run = read_recorded_run(scratch.path / "o");
  const Drawing drawing = drawing_of(run);
  CHECK(drawing.unseen.empty());
  CHECK(drawing.flat);
  REQUIRE(drawing.bodies.size() == 3);
  CHECK(drawing.bodies[1].name == "woodpecker.bird");
  const DrawnBody& sleeve = drawing.bodies[0];
  for (std::size_t i = 0; i < run.t.size(); i += 7) {
    CHECK(sleeve.moments[i].X.p.y() == run.bodies[0].q[3 * i]);
    CHECK(sleeve.moments[i].V.v.y() == Approx(run.bodies[0].v[3 * i]).margin(1e-8));
    CHECK(sleeve.moments[i].V.w.z() == Approx(run.bodies[0].v[3 * i + 1]).margin(1e-7));
  }
  for (const auto& points : drawing.contact_points)
    for (const Vector3& p : points) CHECK(std::isnan(p.x()));  // only its coordinates know where it touches
}

TEST_CASE("a picture shows where all that moves goes, and what stands around it", "[view]") {
  const Scratch scratch("view-extent");
  REQUIRE(run_perp(scratch, "run bowl --method ncp2 --step 0.01 --until 1 --out " + (scratch / "o")).status ==
          0);
  const Drawing bowl = drawing_of(read_recorded_run(scratch.path / "o"));
  CHECK((bowl.high - bowl.low).minCoeff() >=
        2 * 1.0);  // the bowl's radius is 1 m, of which the marble sees a part
  REQUIRE(run_perp(scratch, "run bead-in-ring --method ncp2 --step 0.01 --until 0.2 --out " + (scratch / "o"))
              .status == 0);
  CHECK(drawing_of(read_recorded_run(scratch.path / "o")).flat);
  REQUIRE(
      run_perp(scratch, "run incline-block --method ncp2 --step 0.01 --until 0.2 --out " + (scratch / "o"))
          .status == 0);
  CHECK_FALSE(drawing_of(read_recorded_run(scratch.path / "o")).flat);
  REQUIRE(run_perp(scratch, "run dzhanibekov --method ncp2 --step 0.01 --until 0.2 --out " + (scratch / "o"))
              .status == 0);
  const Drawing free = drawing_of(read_recorded_run(scratch.path / "o"));
  REQUIRE(free.bodies[0].solids.size() == 1);  // the box with the moments 1, 2, 3 kg m² of 1 kg
  Vector3 edges = free.bodies[0].solids[0].size;
  std::sort(edges.begin(), edges.end());
  CHECK((edges - Vector3(0, std::sqrt(12), std::sqrt(24))).norm() < 1e-12);
}

/// Numbers of an accessor of a glTF whose buffer is inside.
std::vector<float> numbers_of(const json& file, std::size_t accessor, std::size_t width) {
  const std::string uri = file["buffers"][0]["uri"];
  std::vector<unsigned char> bytes;
  unsigned value = 0;
  int bits = 0;
  const std::string all = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  for (const char c : uri.substr(uri.find(',') + 1)) {
    const std::size_t digit = all.find(c);
    if (digit == std::string::npos) break;
    value = value << 6 | static_cast<unsigned>(digit), bits += 6;
    if (bits >= 8) bits -= 8, bytes.push_back(static_cast<unsigned char>(value >> bits & 255));
  }
  const json& described = file["accessors"][accessor];
  const json& view = file["bufferViews"][described["bufferView"].get<std::size_t>()];
  std::vector<float> out(described["count"].get<std::size_t>() * width);
  std::memcpy(out.data(), bytes.data() + view.value("byteOffset", std::size_t{0}),
              out.size() * sizeof(float));
  return out;
}

TEST_CASE("glTF's nodes are at three times where trajectory.csv has the body", "[view]") {
  const Scratch scratch("view-gltf");
  REQUIRE(run_perp(scratch, "run oblique-sphere --method ncp2 --step 0.01 --until 2 --out " + (scratch / "o"))
              .status == 0);
  const RecordedRun run = read_recorded_run(scratch.path / "o");
  const json file = json::parse(gltf_of(run));
  const json& animation = file["animations"][0];
  std::size_t node = 0;
  while (file["nodes"][node]["name"] != run.bodies[0].name) ++node;
  for (const json& channel : animation["channels"]) {
    if (channel["target"]["node"] != node) continue;
    const bool turns = channel["target"]["path"] == "rotation";
    const std::size_t n = turns ? 4 : 3;
    const json& sampler = animation["samplers"][channel["sampler"].get<std::size_t>()];
    const auto times = numbers_of(file, sampler["input"], 1), keys = numbers_of(file, sampler["output"], n);
    for (const std::size_t row : {std::size_t{33}, std::size_t{71}, std::size_t{150}}) {
      const double t = run.t[row];
      std::size_t i = 0;
      while (i + 2 < times.size() && static_cast<double>(times[i + 1]) <= t) ++i;
      const double h = static_cast<double>(times[i + 1] - times[i]),
                   s = (t - static_cast<double>(times[i])) / h;
      Eigen::VectorXd value(n);
      for (std::size_t k = 0; k < n;
           ++k) {  // in-tangent, value, out-tangent of every key [glTF 2.0, appendix C.5]
        const auto key = [&](std::size_t j, std::size_t part) {
          return static_cast<double>(keys[(3 * j + part) * n + k]);
        };
        value[static_cast<Eigen::Index>(k)] =
            (2 * s * s * s - 3 * s * s + 1) * key(i, 1) + (s * s * s - 2 * s * s + s) * h * key(i, 2) +
            (3 * s * s - 2 * s * s * s) * key(i + 1, 1) + (s * s * s - s * s) * h * key(i + 1, 0);
      }
      const Pose& X = run.bodies[0].moments[row].X;
      INFO("t = " << t << (turns ? ", turning" : ", moving"));
      if (turns)
        CHECK(std::abs(value.normalized().dot(Eigen::VectorXd(X.q.coeffs()))) == Approx(1).margin(1e-9));
      else
        CHECK((value - Eigen::VectorXd(X.p)).norm() < 5e-5);
    }
  }
}

TEST_CASE("a folder that is not whole leaves no page behind", "[view]") {
  const Scratch scratch("view-no-half");
  const auto view = [&] {
    return run_perp(scratch, "view " + (scratch / "o") + " --html " + (scratch / "p.html"));
  };
  CHECK(view().status == 2);
  REQUIRE(run_perp(scratch, "run seed-sphere --method lcp --step 0.1 --out " + (scratch / "o")).status == 0);
  std::filesystem::remove(scratch / "o/contacts.csv");
  const Outcome without = view();
  CHECK(without.status == 0);
  CHECK(contents(scratch / "p.html").find("No contact is recorded.") != std::string::npos);
  std::filesystem::remove(scratch / "p.html");
  std::string text = contents(scratch / "o/trajectory.csv");
  const std::size_t row = text.find("\n", text.find("\n") + 1) + 1;
  text.replace(text.find(",", row) + 1, text.find(",", text.find(",", row) + 1) - text.find(",", row) - 1,
               "nan");
  std::ofstream(scratch / "o/trajectory.csv", std::ios::binary) << text;
  const Outcome refused = view();
  CHECK(refused.status == 2);
  CHECK(refused.err.find("trajectory.csv:3:") != std::string::npos);
  CHECK(refused.err.find("a finite number is needed") != std::string::npos);
  CHECK_FALSE(std::filesystem::exists(scratch / "p.html"));
  CHECK_FALSE(std::filesystem::exists(scratch / "p.html.part"));
}

TEST_CASE("perp run --view leaves the page of the run, also of one that was stopped", "[view]") {
  const Scratch scratch("view-of-run");
  const Outcome whole =
      run_perp(scratch, "run seed-sphere --method lcp --step 0.01 --view --out " + (scratch / "o"));
  CHECK(whole.status == 0);
  CHECK(whole.out.find("view.html") != std::string::npos);
  CHECK(contents(scratch / "o/view.html").find("did not reach its end") == std::string::npos);
  const Outcome stopped =
      run_perp(scratch, "run seed-sphere --method lcp --step 0.0001 --budget 0 --quiet --view --out " +
                            (scratch / "s"));
  CHECK(stopped.status == 1);
  CHECK(stopped.out.empty());
  CHECK(contents(scratch / "s/view.html").find("This run did not reach its end: stopped by --budget 0") !=
        std::string::npos);
  const Outcome resumed = run_perp(scratch, "run --resume " + (scratch / "s") + " --view --quiet");
  CHECK(resumed.status == 0);
  CHECK(contents(scratch / "s/view.html").find("did not reach its end") == std::string::npos);
  const Outcome refused = run_perp(
      scratch, "run seed-sphere --method lcp --step 0.01 --format hdf5 --view --out " + (scratch / "h"));
  CHECK(refused.status == 2);
  CHECK(refused.err.find("--view is given beside --format hdf5, needs --format csv") != std::string::npos);
  CHECK_FALSE(std::filesystem::exists(scratch / "h"));
}

TEST_CASE("a study's page links to the motion, or says the command that makes it", "[view]") {
  const Scratch scratch("view-of-study");
  const std::string study =
      "study seed-sphere --methods lcp --steps T/10,T/20,T/40 --set mu=0.3 --out " + (scratch / "s");
  REQUIRE(run_perp(scratch, study).status == 0);
  std::string page = contents(scratch / "s/study.html");
  CHECK(page.find("<a href=\"seed-sphere-motion/view.html\">") == std::string::npos);
  const std::size_t begin = page.find("<code>") + 6;
  const std::string command = page.substr(begin, page.find("</code>", begin) - begin);
  REQUIRE(command.substr(0, 9) == "perp run ");
  CHECK(run_perp(scratch, command.substr(5)).status == 0);  // as it stands there
  CHECK(std::filesystem::exists(scratch / "s/seed-sphere-motion/view.html"));
  std::filesystem::remove_all(scratch / "s");
  REQUIRE(run_perp(scratch, study + " --view").status == 0);
  page = contents(scratch / "s/study.html");
  CHECK(page.find("<a href=\"seed-sphere-motion/view.html\">") != std::string::npos);
  CHECK(contents(scratch / "s/seed-sphere-motion/view.html").find("seed-sphere by lcp") != std::string::npos);
}

TEST_CASE("a picture's size is what was asked for", "[view]") {
  const Scratch scratch("view-size");
  REQUIRE(run_perp(scratch, "run seed-sphere --method lcp --step 0.1 --out " + (scratch / "o")).status == 0);
  for (const char* wrong : {"400", "400x", "x300", "400x300x2", "4e2x300", "0x300", "99999x300"}) {
    const Outcome refused = run_perp(scratch, "view " + (scratch / "o") + " --png 0 --size " + wrong);
    CHECK(refused.status == 2);
    CHECK(refused.err.find("needs to be WxH, each from 100 to 8000 pixels") != std::string::npos);
  }
  CHECK(run_perp(scratch, "view " + (scratch / "o") + " --size 400x300").status == 2);
}

TEST_CASE("every built-in scene is in the gallery: a small picture, what it is, how it was run", "[view]") {
  const std::filesystem::path doc = std::filesystem::path(PERP_TEST_FOLDER) / "../../doc";
  const std::string page = contents(doc / "gallery.md");
  std::size_t sections = 0;
  for (std::size_t i = page.find("\n## "); i != std::string::npos; i = page.find("\n## ", i + 1)) ++sections;
  CHECK(sections == scene_names().size());
  for (const std::string& name : scene_names()) {
    INFO(name);
    const std::size_t begin = page.find("\n## " + name + "\n");
    REQUIRE(begin != std::string::npos);
    const std::string section = page.substr(begin, page.find("\n## ", begin + 1) - begin);
    CHECK(section.find("](images/gallery/" + name + ".png)") != std::string::npos);
    CHECK(section.find(scene(name).what + ".") != std::string::npos);
    CHECK(section.find("`perp run " + name + " --method ") != std::string::npos);
    REQUIRE(std::filesystem::exists(doc / "images/gallery" / (name + ".png")));
    CHECK(std::filesystem::file_size(doc / "images/gallery" / (name + ".png")) < 30000);
  }
}

}  // namespace
}  // namespace perp
