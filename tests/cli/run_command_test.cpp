#include <catch2/catch.hpp>
#include <cmath>

#include "perp/study/scene.hpp"
#include "tests/cli/program.hpp"

namespace perp {
namespace {

TEST_CASE("perp run writes the seed's sphere with the paper's velocities and positions", "[run]") {
  const Scratch scratch("run-seed");
  const Outcome done =
      run_perp(scratch, "run seed-sphere --method lcp --step 0.12 --until 0.6 --out " + (scratch / "o"));
  CHECK(done.status == 0);
  CHECK(done.err.empty());
  CHECK(done.out.find("5 steps to t = 0.6 s") != std::string::npos);
  auto table = columns(scratch / "o/trajectory.csv");
  REQUIRE(table["t"] == std::vector<std::string>{"0", "0.12", "0.24", "0.36", "0.48", "0.6"});
  CHECK(std::stod(table["ball.vx"][1]) == Approx(1.76456).epsilon(1e-14));
  CHECK(std::stod(table["ball.vx"][5]) == Approx(10.0 / 7).epsilon(1e-14));
  CHECK(std::stod(table["ball.wy"][5]) == Approx(10.0 / 7).epsilon(1e-14));
  CHECK(std::stod(table["ball.x"][5]) == Approx(0.909527314285714286).epsilon(1e-14));
}

TEST_CASE("contacts.csv says who pushes whom, how hard and in which mode", "[run]") {
  const Scratch scratch("run-contacts");
  REQUIRE(run_perp(scratch, "run seed-sphere --method lcp --step 0.12 --out " + (scratch / "o")).status == 0);
  const std::string text = contents(scratch / "o/contacts.csv");
  CHECK(text.substr(0, text.find('\n')) == "t,contact,a,b,gap,nx,ny,nz,pn,px,py,pz,fx,fy,fz,mode");
  auto table = columns(scratch / "o/contacts.csv");
  REQUIRE(table["t"].size() == 5);
  CHECK(table["a"][0] == "ground");
  CHECK(table["b"][0] == "ball");
  CHECK(table["nz"][0] == "1");
  CHECK(std::stod(table["pn"][0]) == Approx(9.81 * 0.12));
  CHECK(std::stod(table["px"][0]) == Approx(-0.2 * 9.81 * 0.12));
  CHECK(std::stod(table["fx"][0]) == Approx(-0.2 * 9.81));
  CHECK(std::stod(table["fz"][0]) == Approx(9.81));
  CHECK(table["mode"] == std::vector<std::string>{"slip", "slip", "stick", "stick", "stick"});
}

TEST_CASE("report.csv has every column of the certificate", "[run]") {
  const Scratch scratch("run-report");
  REQUIRE(run_perp(scratch, "run seed-sphere --method lcp --step 0.12 --out " + (scratch / "o")).status == 0);
  const std::string text = contents(scratch / "o/report.csv");
  CHECK(text.substr(0, text.find('\n')) ==
        "t,h,status,advanced,solver,iterations,res_newton_euler,res_kinematic,res_joints,res_normal,res_"
        "friction,"
        "gap_min,joint_error,energy,energy_friction,energy_impact,energy_load,energy_motor,energy_surface,"
        "energy_"
        "overlap,energy_left,projection");
  auto table = columns(scratch / "o/report.csv");
  CHECK(table["h"] == std::vector<std::string>(5, "0.12"));
  CHECK(table["status"] == std::vector<std::string>(5, "solved"));
  CHECK(table["advanced"] == std::vector<std::string>(5, "1"));
  CHECK(std::stod(table["energy"][4]) == Approx(9.81 + 10.0 / 7));  // m g R + 7/10 m v^2
}

TEST_CASE("perp run --every keeps each K-th step and the last, --set reaches the scene", "[run]") {
  const Scratch scratch("run-options");
  const std::string run = "run seed-sphere --method lcp-ap --step 0.06 --until 0.42 --out " + (scratch / "o");
  REQUIRE(run_perp(scratch, run + " --every 3 --edges 4 --set mu=0 --set v0=3").status == 0);
  auto table = columns(scratch / "o/trajectory.csv");
  REQUIRE(table["t"].size() == 4);  // the start, steps 3 and 6, and 7
  CHECK(std::stod(table["t"][1]) == Approx(0.18));
  CHECK(std::stod(table["t"][2]) == Approx(0.36));
  CHECK(table["t"][3] == "0.42");
  CHECK(table["ball.vx"][3] == "3");
  CHECK(columns(scratch / "o/report.csv")["t"].size() == 3);
}

TEST_CASE("perp run --edges sets how many directions friction has", "[run]") {
  const Scratch scratch("run-edges");
  const std::string run =
      "run oblique-sphere --method lcp --step 0.01 --until 2 --out " + (scratch / "o") + " --edges ";
  const auto error = [&](int edges) {  // from the exact place at t = 2
    CHECK(run_perp(scratch, run + std::to_string(edges)).status == 0);
    auto table = columns(scratch / "o/trajectory.csv");
    return std::hypot(std::stod(table["ball.x"].back()) - 3.12964313237216244,
                      std::stod(table["ball.y"].back()) - 0.56482156618608122);
  };
  CHECK(error(4) == Approx(0.229822).epsilon(0.1));
  CHECK(error(8) == Approx(0.0613122).epsilon(0.3));
}

TEST_CASE("each kind of body has its own columns, a prescribed one those of a spatial one", "[run]") {
  const Scratch scratch("run-columns");
  const auto header = [&](const std::string& scene) {
    CHECK(run_perp(scratch, "run " + scene + " --method lcp --step 0.1 --until 0.1 --out " + (scratch / "o"))
              .status == 0);
    const std::string text = contents(scratch / "o/trajectory.csv");
    return text.substr(0, text.find('\n'));
  };
  CHECK(header("seed-sphere") ==
        "t,ball.x,ball.y,ball.z,ball.qw,ball.qx,ball.qy,ball.qz,ball.vx,ball.vy,ball.vz,ball.wx,ball.wy,ball."
        "wz");
  CHECK(header("roller-in-cylinder").find(".x,roller.y,roller.angle,roller.vx,roller.vy,roller.omega") !=
        std::string::npos);
  CHECK(header("shaker") ==
        "t,plate.x,plate.y,plate.z,plate.qw,plate.qx,plate.qy,plate.qz,plate.vx,plate.vy,plate.vz,plate.wx,"
        "plate."
        "wy,plate.wz,particle.x,particle.y,particle.z,particle.vx,particle.vy,particle.vz");
  auto table = columns(scratch / "o/trajectory.csv");
  CHECK(table["plate.qw"] == std::vector<std::string>{"1", "1"});
  const Scene scene = perp::scene("shaker");
  State x = scene.start;
  x.t = 0.1;
  const BodyId plate = scene.model.find_body("plate");
  CHECK(std::stod(table["plate.z"][1]) == scene.model.position(x, plate).z());
  CHECK(std::stod(table["plate.vz"][1]) == scene.model.velocity(x, plate).z());
}

TEST_CASE("the angular velocity in trajectory.csv is in world axes", "[run]") {
  const Scratch scratch("run-world");
  const std::string run =
      "run dzhanibekov --set tilt=3 --method lcp --step 1e-3 --until 1 --out " + (scratch / "o");
  REQUIRE(run_perp(scratch, run).status == 0);
  auto table = columns(scratch / "o/trajectory.csv");
  std::string body;
  for (const auto& [name, cells] : table) {
    if (name.size() > 3 && name.substr(name.size() - 3) == ".qw") body = name.substr(0, name.size() - 3);
  }
  // q' = w q / 2 with w in world axes: central differences of q between the rows around t = 0.5
  const auto at = [&](const char* part, std::size_t row) { return std::stod(table[body + part][row]); };
  const std::size_t k = 500;
  const double dq = (at(".qw", k + 1) - at(".qw", k - 1)) / 2e-3;
  const double expected =
      -0.5 * (at(".wx", k) * at(".qx", k) + at(".wy", k) * at(".qy", k) + at(".wz", k) * at(".qz", k));
  CHECK(dq == Approx(expected).margin(5e-2));
  const double dqx = (at(".qx", k + 1) - at(".qx", k - 1)) / 2e-3;
  const double expected_x =
      0.5 * (at(".wx", k) * at(".qw", k) + at(".wy", k) * at(".qz", k) - at(".wz", k) * at(".qy", k));
  CHECK(dqx == Approx(expected_x).margin(5e-2));
}

TEST_CASE("the same run twice gives the same bytes, under another locale too", "[run]") {
  const Scratch scratch("run-twice");
  const std::string run = "run oblique-sphere --method lcp --step 0.01 --out ";
  REQUIRE(run_perp(scratch, run + (scratch / "a")).status == 0);
  REQUIRE(run_perp(scratch, run + (scratch / "b"), "LC_ALL=de_DE.UTF-8 LANG=de_DE.UTF-8").status == 0);
  for (const std::string file : {"/trajectory.csv", "/contacts.csv", "/report.csv"}) {
    const std::string a = contents(scratch / ("a" + file));
    CHECK(a.size() > 1000);
    CHECK(a == contents(scratch / ("b" + file)));
  }
}

TEST_CASE("perp run refuses what it cannot take with status 2 and a sentence that names it", "[run]") {
  const Scratch scratch("run-refuses");
  const std::string out = " --out " + (scratch / "o");
  const auto refused = [&](const std::string& arguments, const std::string& named) {
    const Outcome done = run_perp(scratch, arguments);
    CAPTURE(arguments, done.err);
    CHECK(done.status == 2);
    CHECK(done.err.substr(0, 6) == "perp: ");
    CHECK(done.err.find(named) != std::string::npos);
    CHECK_FALSE(std::filesystem::exists(scratch / "o"));
  };
  const std::string sphere = "run seed-sphere --method lcp --step 0.1" + out;
  refused("run nosuch --method lcp --step 0.1" + out, "nosuch");
  refused("run seed-sphere --method nosuch --step 0.1" + out, "nosuch");
  refused("run seed-sphere --method lcp --step -1" + out, "-1");
  refused("run seed-sphere --method lcp --step nan" + out, "nan");
  refused("run seed-sphere --method lcp --step soon" + out, "soon");
  refused("run seed-sphere --method lcp" + out, "--step");
  refused(sphere + " --until -2", "-2");
  refused(sphere + " --edges 2", "2");
  refused(sphere + " --every 0", "0");
  refused(sphere + " --set mu", "mu");
  refused(sphere + " --set mu=0.1x", "0.1x");
  refused(sphere + " --set mu=0.1 --set mu=0.2", "mu=0.2");
  refused(sphere + " --set nosuch=1", "nosuch");
  refused(sphere + " --set mu=-1", "-1");
  refused(sphere + " --nosuch", "--nosuch");
  refused("run seed-sphere --method lcp --step 0.1 --out /dev/null/o", "/dev/null/o");
  refused("nosuch", "nosuch");
  refused("", "command");
}

TEST_CASE("joints.csv has a row a joint and step, whatever the method", "[run]") {
  const Scratch scratch("joints");
  for (const std::string method : {"lcp", "ncp", "ncp2", "event"}) {
    CAPTURE(method);
    const Outcome run = run_perp(scratch, "run friction-pendulum --method " + method +
                                              " --step 0.01 --until 0.2 --out " + (scratch / method));
    REQUIRE(run.status == 0);
    auto rows = columns((scratch / method) + "/joints.csv");
    CHECK(rows["t"].size() == columns((scratch / method) + "/report.csv")["t"].size());
    CHECK(std::abs(std::stod(rows["coordinate"].back())) > 0.01);
    CHECK(std::abs(std::stod(rows["friction"].back())) > 0);
  }
}

TEST_CASE("Impacts in sequence send the last of three balls away, and are refused where none are located",
          "[run]") {
  const Scratch scratch("run-sequential");
  for (const std::string method : {"event", "extrapolated"}) {
    const std::string out = scratch / method;
    const Outcome done = run_perp(
        scratch, "run three-balls --method " + method + " --until 0.5 --impacts sequential --out " + out);
    if (done.err.find("SUNDIALS") != std::string::npos) continue;
    REQUIRE(done.status == 0);
    CHECK(done.out.find("not unique") == std::string::npos);
    auto table = columns(out + "/trajectory.csv");
    CHECK(std::stod(table["first.vx"].back()) == Approx(0).margin(1e-12));
    CHECK(std::stod(table["second.vx"].back()) == Approx(0).margin(1e-12));
    CHECK(std::stod(table["third.vx"].back()) == Approx(1).epsilon(1e-12));
    CHECK(contents(out + "/run.json").find("\"impacts\": \"sequential\"") != std::string::npos);
  }
  const Outcome refused = run_perp(
      scratch, "run three-balls --method ncp2 --step 0.01 --impacts sequential --out " + (scratch / "no"));
  CHECK(refused.status == 2);
  CHECK(refused.err.find("--impacts") != std::string::npos);
}

}  // namespace
}  // namespace perp
