// Planar bodies that stand on a corner: one that rocks, one that jams.
#include <cmath>

#include "perp/model/gaps.hpp"
#include "study/scene_parts.hpp"

namespace perp {

Scene rocking_block(Parameters& set) {
  const double b = 0.25, h = 1, alpha = std::atan2(b, h);
  const double mu = set.number("mu", 1, "friction coefficient [-]", not_negative);
  const double theta = set.number("theta", alpha / 2,
                                  "initial tilt, anticlockwise; it falls over past 0.244 [rad]", {0, 0.24});
  Scene s;
  s.id = "B19";
  s.what = "A block rocks from corner to corner, losing a fixed share of its rate at each impact";
  s.t_end = 0.6;
  s.model.set_gravity(down_y);
  // the left or right corner stays where it is, and with it the centre's place follows from the tilt
  const auto place = [=](const Model& model, State& x, BodyId block, Real angle, Real omega) {
    const Real foot = angle >= 0 ? -b : b, c = std::cos(angle), sn = std::sin(angle);
    const Real dx = -foot * c - h * sn, dy = -foot * sn + h * c;
    PlanarMotion{foot + dx, dy, angle, -omega * dy, omega * dx, omega}.put(model, x, block);
  };
  const BodyId block =
      s.model.add_planar_body(1, (b * b + h * h) / 3, {.pose = {.p = {0, h, 0}}, .name = "block"});
  s.model.add_contact(ground, block, box_on_line(2 * b, 2 * h), {.mu = mu, .name = "floor"});
  s.start = s.model.rest();
  place(s.model, s.start, block, theta, 0);
  if (mu < 1) return s;  // it could slip

  // about the left corner (sign 1) and the right (-1): angle'' = -+ 3 g/(4 R) sin(alpha -+ angle); at the impact the moment
  // of momentum about the new corner is kept, and the rocking that dies out is at rest below double's rounding
  const Real R = std::hypot(Real(b), Real(h)), lean = std::atan2(Real(b), Real(h));
  const Real kept = 1 - 3 * std::pow(std::sin(lean), 2) / 2;
  const auto rocking = [=](int sign) {
    Stretch rock;
    rock.rate = [=](Real, const Reals& y, Reals& dy) {
      dy[0] = y[1];
      dy[1] = -sign * 3 * g / (4 * R) * std::sin(lean - sign * y[0]);
    };
    rock.guard = [=](Real, const Reals& y) { return sign * y[0]; };
    rock.next = [=](Real, Reals& y) {
      y = {0, kept * y[1]};
      if (std::abs(y[1]) > 1e-15L) return -sign;
      y[1] = 0;
      return 0;
    };
    return rock;
  };
  const ReferenceMotion motion({{0, still}, {1, rocking(1)}, {-1, rocking(-1)}}, {theta, 0},
                               theta > 0 ? 1 : 0);
  s.exact = exact_by(s.model, [=](const Model& model, State& x, Real t) {
    const Reals y = motion.at(t).y;
    place(model, x, block, y[0], y[1]);
  });
  return s;
}

Scene painleve_rod(Parameters& set) {
  const double mu = set.number("mu", 2, "friction coefficient [-]", not_negative);
  const double theta =
      set.number("theta", std::atan(2.0), "lean of the rod above the floor [rad]", {0, pi / 2, true});
  const double v0 = set.number("v0", 1, "initial velocity along x, towards the tip [m/s]");
  Scene s;
  s.id = "C1";
  s.what =
      "A rod slides on its leading tip where no finite force keeps it on the floor: it jams without a "
      "collision";
  s.t_end = 0.3;
  s.model.set_gravity(down_y);
  // half length 1; the tip is at (1, 0) of its axes
  const BodyId rod = s.model.add_planar_body(1, 1.0 / 3, {.name = "rod"});
  const Gap tip_on_floor = point_on_plane(Vector3::UnitX(), horizontal_line);
  s.model.add_contact(ground, rod, tip_on_floor, {.mu = mu, .name = "tip"});
  s.start = s.model.rest();
  PlanarMotion{0, std::sin(Real(theta)), -theta, v0, 0, 0}.put(s.model, s.start, rod);

  // While the tip slides its normal acceleration is A N - g. With A < 0 only an impact helps; it stops the tip, if friction
  // suffices, and keeps the moment of momentum about it: (4/3) theta' = v0 sin(theta).
  const Real sn = std::sin(Real(theta)), c = std::cos(Real(theta)), A = 1 + 3 * c * (c - mu * sn);
  const bool jams = v0 > 0 && A < 0 && 1 + 3 * c * c <= mu * 3 * c * sn;
  if (!jams) return s;
  // then the rod turns about its tip, y = (theta, theta'), as long as the tip's force (f, N) stays in the cone
  enum { Turns, Unknown };
  Stretch turns;
  turns.rate = [](Real, const Reals& y, Reals& dy) { dy = {y[1], -3 * g / 4 * std::cos(y[0])}; };
  turns.guard = [=](Real, const Reals& y) {
    const Real sine = std::sin(y[0]), cosine = std::cos(y[0]), faster = -3 * g / 4 * cosine;
    const Real N = g + cosine * faster - sine * y[1] * y[1], f = sine * faster + cosine * y[1] * y[1];
    return mu * N - std::abs(f);
  };
  turns.next = [](Real, Reals&) { return Unknown; };
  const ReferenceMotion motion({{Turns, turns}, {Unknown, still}}, {theta, 3 * v0 * sn / 4}, Turns);
  s.exact = [=, model = s.model, start = s.start](double t) {
    State x = start;
    x.t = t;
    const auto [time, y, stretch] = motion.at(t);
    const Real sine = std::sin(y[0]), cosine = std::cos(y[0]);
    if (stretch == Unknown) {
      x.q.setConstant(not_set);
      x.nu.setConstant(not_set);
    } else if (t > 0) {
      PlanarMotion{c - cosine, sine, -y[0], sine * y[1], cosine * y[1], -y[1]}.put(model, x, rod);
    }
    return x;
  };
  return s;
}

}  // namespace perp
