#include "perp/io/run_files.hpp"

#include <unistd.h>
#include <catch2/catch.hpp>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <stdexcept>
#include <string>
#include <vector>

#include "perp/model/gaps.hpp"
#include "perp/step/lcp_stepper.hpp"
#include "perp/step/ncp2_stepper.hpp"
#include "perp/step/simulate.hpp"

namespace perp {
namespace {

namespace fs = std::filesystem;

std::vector<std::string> lines(const fs::path& path) {
  std::ifstream in(path);
  std::vector<std::string> all;
  for (std::string line; std::getline(in, line);) all.push_back(line);
  return all;
}

TEST_CASE("a run that failed is written as far as it came, its last report row the step that failed",
          "[run_files]") {
  const fs::path folder = fs::temp_directory_path() / "perp-run-files-failed";
  fs::remove_all(folder);
  Model model;
  const BodyId ball = model.add_body(Inertia::solid_sphere(1, 1), {.name = "ball"});
  const Gap plane_until_half = [](const Pose&, const Pose& X, double) {
    const double gap = X.p.x() > 0.5 ? std::nan("") : X.p.z() - 1;
    return ContactPoint{.gap = gap, .normal = Vector3::UnitZ(), .point = X.p - Vector3::UnitZ()};
  };
  model.add_contact(ground, ball, plane_until_half, {.mu = 0.2, .name = "floor"});
  State x = model.rest();
  model.set_position(x, ball, {0, 0, 1});
  model.set_velocity(x, ball, {2, 0, 0});
  LcpStepper stepper;
  bool failed = false;
  try {
    const Trajectory run = simulate(model, stepper, x, {.t_end = 1, .h = 0.1});
  } catch (const StepFailure& failure) {
    failed = true;
    write_run(folder, model, failure.trajectory, {.failed = &failure.report});
  }
  REQUIRE(failed);
  const auto trajectory = lines(folder / "trajectory.csv"), report = lines(folder / "report.csv");
  const auto contacts = lines(folder / "contacts.csv");
  REQUIRE(trajectory.size() > 2);
  CHECK(report.size() == trajectory.size());        // the steps taken and the one that failed; a header each
  CHECK(contacts.size() == trajectory.size() - 1);  // one contact in each step taken
  CHECK(report.back().find(",not-finite,0,") != std::string::npos);
  CHECK(report[report.size() - 2].find(",solved,1,") != std::string::npos);
  fs::remove_all(folder);
}

TEST_CASE("contacts.csv has the halves of a step only beside the column that tells them from their sum",
          "[run_files]") {
  const auto halves = GENERATE(false, true);
  const fs::path folder = fs::temp_directory_path() / ("perp-run-files-halves-" + std::to_string(getpid()));
  fs::remove_all(folder);
  Model model;
  const BodyId ball = model.add_body(Inertia::solid_sphere(1, 1), {.name = "ball"});
  model.add_contact(ground, ball, sphere_on_plane(1), {.mu = 0.2, .name = "floor"});
  State x = model.rest();
  model.set_position(x, ball, {0, 0, 1});
  model.set_velocity(x, ball, {2, 0, 0});
  Ncp2Stepper stepper;
  write_run(folder, model, simulate(model, stepper, x, {.t_end = 0.3, .h = 0.1}), {.halves = halves});
  const auto contacts = lines(folder / "contacts.csv");
  CHECK(contacts.size() == (halves ? 10 : 4));  // the header; three steps of one contact
  CHECK(contacts[0].ends_with(",half") == halves);
  fs::remove_all(folder);
}

TEST_CASE("write_run refuses to keep every 0-th step", "[run_files]") {
  const Model model;
  const Trajectory run(model.rest(), 0);
  CHECK_THROWS_AS(write_run(fs::temp_directory_path() / "perp-run-files-none", model, run, {.every = 0}),
                  std::invalid_argument);
}

}  // namespace
}  // namespace perp
