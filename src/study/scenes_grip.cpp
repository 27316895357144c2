// Friction that holds: what a gripper holds stays, however little more than enough it presses.
#include "study/scene_grip.hpp"

#include "perp/core/errors.hpp"
#include "perp/model/gaps.hpp"
#include "perp/model/timing.hpp"

namespace perp {

Scene grip(Parameters& set) {
  const double mu = set.number("mu", 0.7, "friction coefficient [-]", not_negative);
  const double squeeze = set.number("squeeze", 12, "force on each pad [N]", positive);
  const double mass = 0.045, radius = 0.004, length = 0.03, half_pad = 0.01;
  Scene s;
  s.id = "grip";
  s.what = "A capsule between two pads on slides that press on it: it stays if 2 mu squeeze >= its weight";
  s.t_end = 1000;
  const auto pad = [&](double side, const char* name) {
    const BodyId body = s.model.add_body(Inertia::solid_box(0.1, {2 * half_pad, 0.06, 0.06}),
                                         {.pose = {.p = {side * (radius + half_pad), 0, 0}}, .name = name});
    s.model.add_joint(
        prismatic(ground, body, {.axis = Vector3::UnitX(), .name = std::string(name) + "-slide"}));
    const Vector3 force(-side * squeeze, 0, 0);
    s.model.add_force(body,
                      Timed<Wrench(const Model&, const State&)>(
                          [force](const Model&, const State&) {
                            return Wrench{force, Vector3::Zero()};
                          },
                          Timing{.steady = true}),
                      {"expressions", {0, 0, 0}, {shortest(force.x()), "0", "0", "0", "0", "0"}});
    return body;
  };
  const BodyId left = pad(-1, "left"), right = pad(1, "right");
  const BodyId capsule = s.model.add_body(
      Inertia::solid_cylinder(mass, radius, length),
      {.pose = {.q = Quaternion(Eigen::AngleAxisd(pi / 2, Vector3::UnitX()))}, .name = "capsule"});
  for (const auto& [body, side] : {std::pair{left, 1.0}, std::pair{right, -1.0}})
    s.model.add_contact(body, capsule,
                        capsule_on_plane(radius, length, {side * Vector3::UnitX(), {side * half_pad, 0, 0}}),
                        {.mu = mu, .name = side > 0 ? "left" : "right"});
  s.start = s.model.rest();
  if (2 * mu * squeeze >= mass * g) stays(s);
  return s;
}

}  // namespace perp
