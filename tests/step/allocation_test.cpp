// What a step costs on the heap: nothing, once its workspaces have their sizes.
#include <catch2/catch.hpp>
#include <cstddef>
#include <cstdlib>

#include "perp/model/gaps.hpp"
#include "perp/step/lcp_stepper.hpp"
#include "perp/step/simulate.hpp"

// Eigen asks malloc, the rest asks operator new, which asks malloc: counting malloc counts both. Under the sanitizers malloc is
// theirs, and nothing is counted.
#if defined(__SANITIZE_ADDRESS__)
namespace {
constexpr bool counted = false;
std::size_t calls() { return 0; }
}  // namespace
#else
extern "C" void* __libc_malloc(std::size_t size);
namespace {
constexpr bool counted = true;
std::size_t count = 0;
std::size_t calls() { return count; }
}  // namespace
extern "C" void* malloc(std::size_t size) {
  ++count;
  return __libc_malloc(size);
}
#endif

using namespace perp;

TEST_CASE("after its first step a run with a closed, sliding contact allocates nothing", "[allocation]") {
  Model model;
  const BodyId ball = model.add_body(Inertia::solid_sphere(1, 1));
  model.add_contact(ground, ball, sphere_on_plane(1), {.mu = 0.2, .name = "floor"});
  State x = model.rest();
  model.set_position(x, ball, {0, 0, 1});
  model.set_velocity(x, ball, {2, 0, 0});
  LcpStepper stepper;
  std::size_t after_first = 0, at_last = 0;
  const Trajectory run = simulate(model, stepper, x, {.t_end = 0.2, .h = 1e-4, .progress = [&](double) {
                                                        at_last = calls();
                                                        if (after_first == 0) after_first = at_last;
                                                        return true;
                                                      }});
  REQUIRE(run.steps() == 2000);
  CHECK(at_last - after_first <=
        2);  // room for the rows of all steps, made when the first has shown how many a step has
  CHECK(run.report(1999).contact("floor").mode == ContactMode::Slip);
  CHECK(run.report(1999).contacts.size() == 1);
  if (counted) {
    const std::size_t before = calls();
    const Vector v = Vector::Zero(100);
    CHECK(calls() > before);  // the count counts
  }
}

TEST_CASE("after its first step an arm with joints, friction and contacts allocates nothing",
          "[allocation]") {
  Model model;
  model.set_gravity({0, -9.81, 0});
  BodyId below = ground;
  for (int i = 0; i < 3; ++i) {
    const BodyId link = model.add_planar_body(1, 0.1, {.pose = {{i + 0.5, 0, 0}, Quaternion::Identity()}});
    model.add_joint(revolute(below, link, {.point = {1.0 * i, 0, 0}, .friction = 0.1}));
    model.add_contact(ground, link, disc_on_line(0.1, {Vector3::UnitY(), {0, -0.1, 0}}), {.mu = 0.4});
    below = link;
  }
  LcpStepper stepper;
  State x = model.rest();
  StepReport report;
  for (int k = 0; k < 3; ++k) stepper.step(model, x, {.h = 1e-3}, report);
  const std::size_t before = calls();
  for (int k = 0; k < 100; ++k) {
    stepper.step(model, x, {.h = 1e-3}, report);
    REQUIRE(report.advanced());
  }
  CHECK(calls() - before < 10);  // Catch's own bookkeeping aside
}

TEST_CASE("after its first steps a box on four redundant corners allocates nothing, at rest and sliding",
          "[allocation][redundant]") {
  const bool slides = GENERATE(false, true);
  Model model;
  const BodyId box = model.add_body(Inertia::solid_box(2, {1, 0.8, 0.5}), {.pose = {.p = {0, 0, 0.25}}});
  for (const Vector3& corner : {Vector3(0.5, 0.4, -0.25), Vector3(-0.5, 0.4, -0.25),
                                Vector3(-0.5, -0.4, -0.25), Vector3(0.5, -0.4, -0.25)})
    model.add_contact(ground, box, point_on_plane(corner), {.mu = 0.3});
  State x = model.rest();
  if (slides) model.set_velocity(x, box, {2, 0.3, 0}, {0, 0, 1.5});
  LcpStepper stepper;
  StepReport report;
  for (int k = 0; k < 3; ++k) stepper.step(model, x, {.h = 1e-3}, report);
  const std::size_t before = calls();
  for (int k = 0; k < 300; ++k) {
    stepper.step(model, x, {.h = 1e-3}, report);
    REQUIRE(report.advanced());
  }
  CHECK(calls() - before < 10);  // Catch's own bookkeeping aside
  CHECK((x.nu.norm() > 0.1) == slides);
}
