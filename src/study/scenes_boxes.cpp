// Boxes that should stay where they are.
#include <cmath>

#include "perp/model/gaps.hpp"
#include "study/scene_parts.hpp"

namespace perp {
namespace {

/// exact() of a scene that is in equilibrium from the start.
void stays(Scene& s) {
  s.exact = [start = s.start](double t) {
    State state = start;
    state.t = t;
    return state;
  };
}

}  // namespace

Scene stack(Parameters& set) {
  const double mu = set.number("mu", 0.5, "friction coefficient [-]", not_negative);
  const double ratio = set.number("ratio", 1000, "mass of the top box over that of the others [-]", positive);
  const int count = set.count("count", 2, "boxes [-]", 1, 1000);
  const Vector3 size(1, 1, 1);
  Scene s;
  s.id = "C5";
  s.what = "A stack of boxes of 1 kg under a heavier one stands";
  BodyId below = ground;
  for (int i = 0; i < count; ++i) {
    const BodyId box =
        s.model.add_body(Inertia::solid_box(i + 1 < count ? 1 : ratio, size),
                         {.pose = {.p = {0, 0, 0.5 + i}}, .name = "box-" + std::to_string(i + 1)});
    s.model.add_contact(below, box, i == 0 ? box_on_plane(size) : box_on_box(size, size),
                        {.mu = mu, .name = i == 0 ? "floor" : "joint-" + std::to_string(i)});
    below = box;
  }
  s.start = s.model.rest();
  stays(s);
  return s;
}

Scene creep(Parameters& set) {
  const double mu = set.number("mu", 0.5, "friction coefficient [-]", not_negative);
  const double theta = set.number("theta", pi / 9, "slope [rad]", {0, 1.57});
  const Vector3 size(1, 1, 1);
  Scene s;
  s.id = "C17";
  s.what = "A box that friction holds on a slope does not creep";
  s.t_end = 100;
  s.model.set_gravity({g * std::sin(theta), 0, -g * std::cos(theta)});
  const BodyId box =
      s.model.add_body(Inertia::solid_box(1, size), {.pose = {.p = {0, 0, 0.5}}, .name = "box"});
  s.model.add_contact(ground, box, box_on_plane(size), {.mu = mu, .name = "slope"});
  s.start = s.model.rest();
  if (std::tan(theta) <= mu && std::tan(theta) <= 1) stays(s);  // neither slides nor tips
  return s;
}

}  // namespace perp
