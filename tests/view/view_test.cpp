// What perp view reads and writes, short of a browser.
#include <catch2/catch.hpp>
#include <cmath>
#include <nlohmann/json.hpp>

#include "perp/io/csv_reader.hpp"
#include "perp/model/gaps.hpp"
#include "perp/study/scene.hpp"
#include "perp/view/page.hpp"
#include "perp/view/pictures.hpp"
#include "perp/view/solids.hpp"
#include "tests/cli/program.hpp"
#include "view/encode.hpp"
#include "view/keyframes.hpp"
#include "view/mesh.hpp"

namespace perp {
namespace {

using nlohmann::json;

void put(const std::string& path, const std::string& text) { std::ofstream(path, std::ios::binary) << text; }

std::string refusal(const std::function<void()>& act) {
  try {
    act();
  } catch (const std::invalid_argument& error) {
    return error.what();
  }
  return "accepted";
}

/// Rows of a body that turns at the rate w about z and moves along a circle, whose pose is known at all times.
Moment on_circle(double t, double w) {
  return {.X = {{std::cos(w * t), std::sin(w * t), 0}, rotation(Vector3(0, 0, w * t))},
          .V = {{-w * std::sin(w * t), w * std::cos(w * t), 0}, {0, 0, w}}};
}

const char* const trajectory_text =
    "t,b.x,b.y,b.z,b.qw,b.qx,b.qy,b.qz,b.vx,b.vy,b.vz,b.wx,b.wy,b.wz\n"
    "0,0,0,0,1,0,0,0,1,0,0,0,0,0\n"
    "1,1,0,0,1,0,0,0,1,0,0,0,0,0\n";
const char* const report_text = "t,h,status,advanced,solver,iterations,energy\n1,1,solved,1,none,0,0.5\n";

/// The JSON of a page.
json data_of(const std::string& page) {
  const std::string begin = "<script id=\"perp-data\" type=\"application/json\">";
  const std::size_t from = page.find(begin) + begin.size();
  return json::parse(page.substr(from, page.find("</script>", from) - from));
}

TEST_CASE("a table is read row by row: quotes, empty cells, both line ends", "[view][csv]") {
  const Scratch scratch("csv-reader");
  put(scratch / "t.csv", "t,\"a,b\",c\r\n1,\"x \"\"y\"\"\nz\",\n-2.5e-3,w,7\n");
  CsvReader file(scratch / "t.csv");
  REQUIRE(file.header() == std::vector<std::string>{"t", "a,b", "c"});
  REQUIRE(file.next());
  CHECK(file.number(0) == 1);
  CHECK(file.text(1) == "x \"y\"\nz");
  CHECK(std::isnan(file.number(2)));
  REQUIRE(file.next());
  CHECK(file.line() == 4);
  CHECK(file.number(0) == -2.5e-3);
  CHECK(file.number(file.need("c")) == 7);
  CHECK_FALSE(file.next());
}

TEST_CASE("a table that does not fit is refused by file, line and column", "[view][csv]") {
  const Scratch scratch("csv-refused");
  const auto refused = [&](const std::string& text) {
    put(scratch / "t.csv", text);
    return refusal([&] {
      CsvReader file(scratch / "t.csv");
      while (file.next()) (void)file.number(file.need("x"));
    });
  };
  CHECK_THAT(refused(""), Catch::Contains("t.csv:1: the file is empty"));
  CHECK_THAT(refused("t,x\n1\n"), Catch::Contains("t.csv:2: the row has 1 cells, the header 2 names"));
  CHECK_THAT(refused("t,x\n1,2m\n"), Catch::Contains("t.csv:2:3: column 'x' is '2m', a number is needed"));
  CHECK_THAT(refused("t,y\n1,2\n"), Catch::Contains("no column 'x'"));
  CHECK_THAT(refused("t,x,x\n"), Catch::Contains("'x' stands twice"));
  CHECK_THAT(refused("t,x\n1,\"2\n"), Catch::Contains("a quoted cell has no end"));
}

TEST_CASE("between rows the pose's error falls with the fourth power of their distance", "[view]") {
  const double w = 3;
  const auto error = [&](double h) {
    const Pose X = between(0, on_circle(0, w), h, on_circle(h, w), 0.37 * h),
               exact = on_circle(0.37 * h, w).X;
    return std::pair((X.p - exact.p).norm(), rotation_vector(X.q.conjugate() * exact.q).norm());
  };
  const auto [p_1, q_1] = error(0.1);
  const auto [p_2, q_2] = error(0.05);
  CHECK(std::log2(p_1 / p_2) == Approx(4).margin(0.15));
  CHECK(std::log2(q_1 / q_2) > 3.8);
  const Moment turned = {.X = {Vector3::Zero(), Quaternion(-1, 0, 0, 0)}, .V = {}}, still = {};
  CHECK(rotation_vector(between(0, still, 1, turned, 0.5).q).norm() < 1e-15);  // q and -q are one orientation
}

TEST_CASE("keys keep every row within what was asked, and both rows of an event", "[view]") {
  std::vector<double> t;
  std::vector<Moment> moments;
  for (int i = 0; i <= 400; ++i) {
    t.push_back(0.01 * i);
    moments.push_back(on_circle(0.01 * i, 2));
    if (i != 200) continue;
    t.push_back(0.01 * i);
    moments.push_back(on_circle(0.01 * i, 2));  // velocities jump: from here it turns the other way
  }
  for (std::size_t i = 201; i < t.size(); ++i) {
    moments[i] = on_circle(4 - t[i], 2);
    moments[i].V.v *= -1, moments[i].V.w *= -1;
  }
  const Keyframes keys = thinned(t, moments, 1e-4, 1e-4);
  CHECK(keys.rows.size() < 80);
  CHECK(keys.rows.front() == 0);
  CHECK(keys.rows.back() == 401);
  CHECK(std::count(keys.rows.begin(), keys.rows.end(), 200) == 1);
  CHECK(std::count(keys.rows.begin(), keys.rows.end(), 201) == 1);
  double worst = 0;
  for (std::size_t k = 0; k + 1 < keys.rows.size(); ++k)
    for (int row = keys.rows[k]; row <= keys.rows[k + 1]; ++row) {
      const auto i = static_cast<std::size_t>(keys.rows[k]), j = static_cast<std::size_t>(keys.rows[k + 1]),
                 r = static_cast<std::size_t>(row);
      if (t[i] < t[j])
        worst =
            std::max(worst, (between(t[i], moments[i], t[j], moments[j], t[r]).p - moments[r].X.p).norm());
    }
  CHECK(worst <= 1e-4);
  CHECK(worst == Approx(keys.position_error).margin(1e-9));
}

TEST_CASE("whole numbers hold a range to half of its 65535th part, and say so", "[view]") {
  std::vector<double> values;
  for (int i = 0; i < 300; ++i) values.push_back(std::sin(0.7 * i)), values.push_back(100 + i);
  double error = 0;
  const json stored = encoded(values, 2, Precision::Whole, error);
  CHECK(error <= 0.51 * 299 / 65535);
  CHECK(error > 0.3 * 299 / 65535);
  CHECK(stored["low"][1].get<double>() == 100);
  CHECK(base64("Man", 3) == "TWFu");
  CHECK(base64("Ma", 2) == "TWE=");
  CHECK(base64("M", 1) == "TQ==");
}

TEST_CASE("bodies look like what their contacts' gaps are between", "[view]") {
  Model model;
  const BodyId ball = model.add_body(Inertia::solid_sphere(1, 0.5), {.name = "ball"});
  const BodyId box = model.add_body(Inertia::solid_box(1, {1, 2, 3}), {.name = "box"});
  const BodyId arm = model.add_body(Inertia::solid_sphere(1, 0.5), {.name = "arm"});
  model.add_contact(ground, ball, sphere_on_plane(0.5, {{0, 1, 0}, {0, 7, 0}}));
  model.add_contact(ground, box, placed(box_on_plane({1, 2, 3}), {}, {{0, 0, 4}, Quaternion::Identity()}));
  model.add_contact(ball, box, sphere_on_sphere(0.5, 0.25));
  model.add_joint(revolute(ball, arm, {.point = {0, 0, 2}}));
  const auto solids = solids_of(model);
  REQUIRE(solids[0].size() == 2);
  CHECK(solids[0][0].kind == Solid::Kind::Plane);
  CHECK((solids[0][0].place * Vector3(1, 0, 0)).y() == 7);
  CHECK((solids[0][0].place.q * Vector3::UnitZ() - Vector3::UnitY()).norm() < 1e-15);
  REQUIRE(solids[1].size() == 2);  // the same sphere twice is one, and a stick reaches from it to the joint
  CHECK(solids[1][1].kind == Solid::Kind::Stick);
  CHECK(solids[1][0].size.x() == 0.5);
  REQUIRE(solids[2].size() == 2);
  CHECK(solids[2][0].size == Vector3(1, 2, 3));
  CHECK(solids[2][0].place.p.z() == 4);
  REQUIRE(solids[3].size() == 2);  // no contact tells of it: the box of its inertia, and a stick to its joint
  CHECK(solids[3][0].kind == Solid::Kind::Box);
  CHECK((solids[3][0].size - Vector3::Constant(std::sqrt(0.6))).norm() < 1e-14);
  CHECK(solids[3][1].kind == Solid::Kind::Stick);
  CHECK(solids[3][1].size == Vector3(0, 0, 2));
}

TEST_CASE("every solid's triangles face outwards", "[view]") {
  using Kind = Solid::Kind;
  const std::vector<Solid> all = {{.kind = Kind::Sphere, .size = {0.5, 0, 0}},
                                  {.kind = Kind::Box, .size = {1, 2, 3}},
                                  {.kind = Kind::Capsule, .size = {0.3, 1, 0}},
                                  {.kind = Kind::Cylinder, .size = {0.3, 1, 0}},
                                  {.kind = Kind::Disc, .size = {0.4, 0, 0}},
                                  {.kind = Kind::Ellipsoid, .size = {1, 2, 0.5}},
                                  {.kind = Kind::Ellipse, .size = {1, 0.5, 0}},
                                  {.kind = Kind::Stick, .size = {1, 2, 3}},
                                  {.kind = Kind::Polygon, .vertices = {{-1, -1, 0}, {2, -1, 0}, {0, 2, 0}}}};
  // by the divergence theorem the volume is a third of the sum of x . n dA
  const double volume[] = {4 * M_PI / 3 * 0.125,
                           6,
                           M_PI * 0.09 * (1 + 0.4),
                           M_PI * 0.09,
                           M_PI * 0.16 * 0.02,
                           4 * M_PI / 3,
                           M_PI * 0.5 * 0.02,
                           std::sqrt(14) * M_PI * 1e-4,
                           4.5 * 0.02};
  for (std::size_t s = 0; s < all.size(); ++s) {
    const Mesh mesh = mesh_of(all[s], 1, 0.01);
    double sum = 0, least = 1;
    for (std::size_t i = 0; i + 2 < mesh.triangles.size(); i += 3) {
      const auto v = [&](std::size_t k) {
        return mesh.vertices[static_cast<std::size_t>(mesh.triangles[i + k])];
      };
      const Vector3 n = (v(1) - v(0)).cross(v(2) - v(0));
      sum += v(0).dot(n) / 6;
      for (std::size_t k = 0; k < 3; ++k)
        if (n.norm() > 1e-12)
          least = std::min(least,
                           n.normalized().dot(mesh.normals[static_cast<std::size_t>(mesh.triangles[i + k])]));
    }
    INFO("solid " << name_of(all[s].kind));
    CHECK(sum == Approx(volume[s]).epsilon(0.05));
    CHECK(least > 0.85);
  }
}

TEST_CASE("a folder that is no run is refused, by what it lacks", "[view]") {
  const Scratch scratch("view-refused");
  const auto refused = [&] { return refusal([&] { (void)read_recorded_run(scratch.path / "run"); }); };
  CHECK_THAT(refused(), Catch::Contains("run is not there"));
  std::filesystem::create_directories(scratch.path / "run");
  CHECK_THAT(refused(), Catch::Contains("without trajectory.csv"));
  put(scratch / "run/trajectory.csv", trajectory_text);
  CHECK_THAT(refused(), Catch::Contains("without report.csv"));
  put(scratch / "run/report.csv", report_text);
  CHECK(refused() == "accepted");
  put(scratch / "run/trajectory.csv", std::string(trajectory_text) + "2,,0,0,1,0,0,0,1,0,0,0,0,0\n");
  CHECK_THAT(refused(), Catch::Contains("column 'b.x' is '', a finite number is needed"));
  put(scratch / "run/trajectory.csv", std::string(trajectory_text) + "0.5,1,0,0,1,0,0,0,1,0,0,0,0,0\n");
  CHECK_THAT(refused(), Catch::Contains("time goes back"));
  put(scratch / "run/trajectory.csv", std::string(trajectory_text) + "2,1,0,0,1,1,0,0,1,0,0,0,0,0\n");
  CHECK_THAT(refused(), Catch::Contains("the quaternion's length is not 1"));
  put(scratch / "run/trajectory.csv", "t,b.x,b.w\n0,1,2\n");
  CHECK_THAT(refused(), Catch::Contains("the columns of 'b' are not those of a body"));
  put(scratch / "run/trajectory.csv", trajectory_text);
  put(scratch / "run/run.json", "{");
  CHECK_THAT(refused(), Catch::Contains("run.json:1:2: this is no JSON"));
}

TEST_CASE("a page says when a run stopped early and what is not drawn, and no name can end its data",
          "[view]") {
  const Scratch scratch("view-page");
  put(scratch / "trajectory.csv", trajectory_text);
  put(scratch / "report.csv", std::string(report_text) + "1.5,0.5,inexact,0,newton,40,\n");
  RecordedRun run = read_recorded_run(scratch.path);
  run.bodies[0].name = "</script><b>\"é";
  run.name = "<i>";
  PageFacts facts;
  const std::string page = page_of({run}, facts);
  const json data = data_of(page);
  CHECK(data["runs"][0]["bodies"][0]["name"] == "</script><b>\"é");
  CHECK(page.find("<title>&lt;i&gt;</title>") != std::string::npos);
  CHECK(data["stopped"] == true);
  CHECK_THAT(data["said"].get<std::string>(),
             Catch::Contains("stopped at t = 1.5 s: the step's status is inexact") &&
                 Catch::Contains("There is no run.json") && Catch::Contains("No contact is recorded"));
  for (const char* mark : {"src=\"http", "href=\"http", "src='http", "@import"})
    CHECK(page.find(mark) == std::string::npos);
  CHECK(facts.bytes == page.size());
}

TEST_CASE("a page without three.js says so and keeps plots and values", "[view]") {
  const Scratch scratch("view-no-three");
  put(scratch / "trajectory.csv", trajectory_text);
  put(scratch / "report.csv", report_text);
  PageFacts facts;
  const std::string page =
      page_of({read_recorded_run(scratch.path)}, facts, {.three = scratch.path / "none.js"});
  CHECK_FALSE(facts.has_three);
  CHECK(page.size() < 100000);
  CHECK(data_of(page)["runs"][0]["series"].size() == 3);
}

TEST_CASE("glTF holds a node a body, and slopes that jump at an event share a key", "[view]") {
  RecordedRun run;
  run.name = "jump";
  run.t = {0, 0.5, 0.5, 1};
  BodyMotion& body = run.bodies.emplace_back();
  body.name = "b";
  for (const double x : {0.0, 0.5, 0.5, 0.0})
    body.moments.push_back({{{x, 0, 0}, Quaternion::Identity()},
                            {{body.moments.size() < 2 ? 1.0 : -1.0, 0, 0}, Vector3::Zero()}});
  const json file = json::parse(gltf_of(run));
  CHECK(file["nodes"].size() == 2);
  CHECK(file["nodes"][1]["name"] == "b");
  const json& times = file["accessors"][file["animations"][0]["samplers"][0]["input"].get<std::size_t>()];
  CHECK(times["count"] == 3);
  CHECK(times["max"][0] == 1);
  const json& keys = file["accessors"][file["animations"][0]["samplers"][0]["output"].get<std::size_t>()];
  CHECK(keys["count"] == 9);
}

}  // namespace
}  // namespace perp
