// Bodies that friction holds or does not: a leaning card, a block in a V, a peg in a hole.
#include <cmath>

#include "perp/model/gaps.hpp"
#include "study/scene_parts.hpp"

namespace perp {

Scene card(Parameters& set) {
  const double mu = set.number("mu", 0.3, "friction coefficient of the floor [-]", not_negative);
  const double lean = set.number("lean", pi / 6, "from the vertical [rad]", {0, 1.57, true});
  const double length = 0.09;
  Scene s;
  s.id = "C7";
  s.what = "A card leans on a smooth wall: half a house of cards, which stands if mu >= tan(lean)/2";
  s.model.set_gravity(down_y);
  const Vector3 head(length / 2, 0, 0);
  const double width = length * std::sin(lean), height = length * std::cos(lean);
  const BodyId card =
      s.model.add_planar_body(0.002, 0.002 * length * length / 12,
                              {.pose = {.p = {width / 2, height / 2, 0},
                                        .q = Quaternion(Eigen::AngleAxisd(pi / 2 + lean, Vector3::UnitZ()))},
                               .name = "card"});
  s.model.add_contact(ground, card, point_on_plane(-head, horizontal_line), {.mu = mu, .name = "floor"});
  s.model.add_contact(ground, card, point_on_plane(head, {Vector3::UnitX(), Vector3::Zero()}),
                      {.name = "wall"});
  s.start = s.model.rest();
  if (mu >= std::tan(lean) / 2) stays(s);
  return s;
}

Scene wedge(Parameters& set) {
  const double mu = set.number("mu", 0.4, "friction coefficient [-]", not_negative);
  const double angle = set.number("angle", 0.3, "of each side from the vertical [rad]", {0, 1.5, true});
  const double v0 = set.number("v0", 1, "driven in at [m/s]", not_negative);
  const double depth = 1;  // of the centre below the apex
  Scene s;
  s.id = "C13";
  s.what = "A block driven up into a V that opens downwards: it stays if tan(angle) <= mu, or falls out";
  s.t_end = 0.5;
  s.model.set_gravity(down_y);
  const BodyId block = s.model.add_planar_body(1, 0.1, {.name = "block"});
  for (const double side : {-1.0, 1.0})
    for (const double below : {0.8, 1.2}) {
      const Vector3 corner(side * below * std::tan(angle), depth - below, 0);
      const Plane wall{{-side * std::cos(angle), -std::sin(angle), 0}, {0, depth, 0}};
      s.model.add_contact(
          ground, block, point_on_plane(corner, wall),
          {.mu = mu, .name = std::string(side < 0 ? "left" : "right") + (below < 1 ? "-top" : "-bottom")});
    }
  s.start = s.model.rest();
  s.model.set_velocity(s.start, block, {0, v0, 0});

  // What locks could as well fall (no force, no contact): only the one that cannot lock has one motion.
  if (mu >= std::tan(angle)) return s;
  s.exact = [=, model = s.model, start = s.start](double t) {
    State x = start;
    x.t = t;
    if (t < 0) return x;
    if (t > 0 || v0 == 0) PlanarMotion{0, -Real(g) * t * t / 2, 0, 0, -Real(g) * t, 0}.put(model, x, block);
    return x;
  };
  return s;
}

Scene peg(Parameters& set) {
  const double mu = set.number("mu", 0.5, "friction coefficient [-]", not_negative);
  const double spacing = set.number("spacing", 0.04, "of the two contacts along the peg [m]", positive);
  const double w0 = set.number("w0", 1, "turned against both contacts at [rad/s]", not_negative);
  const double width = 0.1, length = 0.2, tilt = 1e-4;
  Scene s;
  s.id = "C13";
  s.what =
      "A tilted peg in a hole touches the mouth on one side and the wall on the other: it jams if "
      "spacing <= mu width";
  s.t_end = 0.5;
  s.model.set_gravity(down_y);
  const Quaternion turn(Eigen::AngleAxisd(tilt, Vector3::UnitZ()));
  // the mouth's edge at the world's origin on the peg's left side, its right lower corner on the hole's right wall
  const Vector3 touched(-width / 2, -length / 2 + spacing, 0), corner(width / 2, -length / 2, 0);
  const Vector3 place = turn * Vector3(-touched);
  const BodyId peg = s.model.add_planar_body(1, (width * width + length * length) / 12,
                                             {.pose = {.p = place, .q = turn}, .name = "peg"});
  s.model.add_contact(peg, ground, point_on_plane(Vector3::Zero(), {-Vector3::UnitX(), touched}),
                      {.mu = mu, .name = "mouth"});
  s.model.add_contact(ground, peg, point_on_plane(corner, {-Vector3::UnitX(), place + turn * corner}),
                      {.mu = mu, .name = "wall"});
  s.start = s.model.rest();
  const Vector3 middle = turn * (touched + corner) / 2;  // of the two contacts, which stays where it is
  s.model.set_velocity(s.start, peg, -w0 * Vector3::UnitZ().cross(middle), {0, 0, w0});
  return s;
}

}  // namespace perp
