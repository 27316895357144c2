// Closed loops with one freedom: a slider-crank with dry friction, four-bars of spatial revolute joints.
#include <algorithm>
#include <boost/math/differentiation/autodiff.hpp>
#include <cmath>

#include "study/scene_parts.hpp"

namespace perp {
namespace {

/// A number that depends on the crank angle, with its first two derivatives.
using Jet = boost::math::differentiation::autodiff_fvar<Real, 2>;

/// A body of a linkage in the xy plane, its place a function of the crank angle.
struct Link {
  Real mass, J;
  Jet x, y, angle;

  PlanarMotion moving(Real rate) const {
    return {x.derivative(0),        y.derivative(0),        angle.derivative(0),
            x.derivative(1) * rate, y.derivative(1) * rate, angle.derivative(1) * rate};
  }
};
using Linkage = std::function<std::vector<Link>(Real crank)>;

Jet variable(Real crank) { return boost::math::differentiation::make_fvar<Real, 2>(crank); }

/// theta'' from Lagrange's equation I theta'' + (1/2) I' theta'^2 = Q - V', the sums over all links
///   I = m (x'^2 + y'^2) + J angle'^2,   V = m gravity y.
Real acceleration(const std::vector<Link>& links, Real rate, Real Q, Real gravity) {
  Real I = 0, half_slope = 0;
  for (const Link& link : links) {
    const auto add = [&](Real weight, const Jet& c) {
      I += weight * c.derivative(1) * c.derivative(1);
      half_slope += weight * c.derivative(1) * c.derivative(2);
    };
    add(link.mass, link.x);
    add(link.mass, link.y);
    add(link.J, link.angle);
    Q -= link.mass * gravity * link.y.derivative(1);
  }
  return (Q - half_slope * rate * rate) / I;
}

Pose pose_of(const PlanarMotion& link) {
  const Real half = link.angle / 2;
  return {{double(link.x), double(link.y), 0}, {double(std::cos(half)), 0, 0, double(std::sin(half))}};
}

}  // namespace

Scene slider_crank(Parameters& set) {
  const double tau = set.number("friction", 0.2, "of the crank's bearing [N m]", not_negative);
  const double F = set.number("guide", 0, "friction of the slider's guide [N]", not_negative);
  const double rate0 = set.number("rate", 20, "initial rate of the crank [rad/s]", positive);
  const Real r = 0.15L, l = 0.4L;
  Scene s;
  s.id = "B15";
  s.what = "A slider-crank runs down by the dry friction of its bearing and its guide";
  s.t_end = 0.3;
  s.model.set_gravity(Vector3::Zero());

  // A massless rod between a crank of J = 0.01 and a slider of 0.5 kg moves them as a rod of 0.2 kg does that has its mass
  // at its two ends, when the crank pin and the slider give theirs up.
  const Real end = 0.1L;
  const Linkage linkage = [=](Real crank) -> std::vector<Link> {
    const Jet theta = variable(crank), beta = asin(r / l * sin(theta));
    const Jet pin_x = r * cos(theta), slider = pin_x + l * cos(beta);
    return {{1, 0.01L - end * r * r, Jet(0), Jet(0), theta},
            {2 * end, end * l * l / 2, (pin_x + slider) / 2, r * sin(theta) / 2, -beta},
            {0.5L - end, 1, slider, Jet(0), Jet(0)}};
  };
  const char* names[] = {"crank", "rod", "slider"};
  std::vector<BodyId> bodies;
  for (const Link& link : linkage(0))
    bodies.push_back(s.model.add_planar_body(
        double(link.mass), double(link.J), {.pose = pose_of(link.moving(0)), .name = names[bodies.size()]}));
  const Vector3 pin(double(r), 0, 0), eye(double(r + l), 0, 0);
  s.model.add_joint(revolute(ground, bodies[0], {.friction = tau, .name = "bearing"}));
  s.model.add_joint(revolute(bodies[0], bodies[1], {.point = pin, .name = "pin"}));
  s.model.add_joint(revolute(bodies[1], bodies[2], {.point = eye, .name = "eye"}));
  s.model.add_joint(
      prismatic(ground, bodies[2], {.point = eye, .axis = Vector3::UnitX(), .friction = F, .name = "guide"}));
  const auto place = [=](const Model& model, State& x, Real crank, Real rate) {
    const std::vector<Link> links = linkage(crank);
    for (std::size_t i = 0; i < links.size(); ++i) links[i].moving(rate).put(model, x, bodies[i]);
  };
  s.start = s.model.rest();
  place(s.model, s.start, 0, rate0);

  // y = (theta, theta'): a stretch for each direction of the slider, until the crank stops for good
  const auto slider_per_crank = [=](const Reals& y) { return linkage(y[0])[2].x.derivative(1); };
  const auto running = [=](int side) {
    Stretch run;
    run.rate = [=](Real, const Reals& y, Reals& dy) {
      const std::vector<Link> links = linkage(y[0]);
      dy = {y[1], acceleration(links, y[1], -tau - side * F * links[2].x.derivative(1), 0)};
    };
    run.guard = [=](Real, const Reals& y) { return std::min(y[1], side * slider_per_crank(y)); };
    run.next = [=](Real, Reals& y) {
      if (y[1] > std::abs(slider_per_crank(y))) return -side;
      y[1] = 0;
      return 0;
    };
    return run;
  };
  const ReferenceMotion motion({{0, still}, {1, running(1)}, {-1, running(-1)}}, {0, rate0}, -1, 0.01L);
  s.exact = exact_by(s.model, [=](const Model& model, State& x, Real t) {
    const Reals y = motion.at(t).y;
    place(model, x, y[0], y[1]);
  });
  return s;
}

namespace {

/// A four-bar of three spatial bodies in the xy plane and four revolute joints about z, 20 equations of rank 17 on 18
/// velocities. Bars of 1 kg; the frame's pivots lie at the origin and at (frame, 0).
Scene bars(double crank, double coupler, double rocker, double frame, double theta0, double rate0,
           const std::function<Jet(const Jet&)>& coupler_angle) {
  Scene s;
  s.t_end = 2;
  s.model.set_gravity(down_y);
  const double lengths[] = {crank, coupler, rocker}, thick = 0.05;
  std::vector<Real> J;
  for (const double length : lengths) J.push_back((Real(length) * length + Real(thick) * thick) / 12);
  const Linkage linkage = [=](Real at) -> std::vector<Link> {
    const Jet theta = variable(at), gamma = coupler_angle(theta);
    const Jet Bx = crank * cos(theta), By = crank * sin(theta);
    const Jet Cx = Bx + coupler * cos(gamma), Cy = By + coupler * sin(gamma);
    return {{1, J[0], Bx / 2, By / 2, theta},
            {1, J[1], (Bx + Cx) / 2, (By + Cy) / 2, gamma},
            {1, J[2], (Cx + frame) / 2, Cy / 2, atan2(Cy, Cx - frame)}};
  };
  const char* names[] = {"crank", "coupler", "rocker"};
  std::vector<BodyId> bodies;
  const std::vector<Link> links = linkage(theta0);
  for (std::size_t i = 0; i < links.size(); ++i)
    bodies.push_back(s.model.add_body(Inertia::solid_box(1, {lengths[i], thick, thick}),
                                      {.pose = pose_of(links[i].moving(0)), .name = names[i]}));
  const Vector3 B = 2 * s.model.body(bodies[0]).rest.p;
  const Vector3 C = 2 * s.model.body(bodies[1]).rest.p - B;
  s.model.add_joint(revolute(ground, bodies[0], {.name = "A"}));
  s.model.add_joint(revolute(bodies[0], bodies[1], {.point = B, .name = "B"}));
  s.model.add_joint(revolute(bodies[1], bodies[2], {.point = C, .name = "C"}));
  s.model.add_joint(revolute(ground, bodies[2], {.point = {frame, 0, 0}, .name = "D"}));
  const auto place = [=](const Model& model, State& x, Real theta, Real rate) {
    const std::vector<Link> now = linkage(theta);
    for (std::size_t i = 0; i < now.size(); ++i) now[i].moving(rate).put(model, x, bodies[i]);
  };
  s.start = s.model.rest();
  place(s.model, s.start, theta0, rate0);

  const auto rate = [=](Real, const Reals& y, Reals& dy) {
    dy = {y[1], acceleration(linkage(y[0]), y[1], 0, g)};
  };
  const ReferenceMotion motion(rate, {theta0, rate0});
  s.exact = exact_by(s.model, [=](const Model& model, State& x, Real t) {
    const Reals y = motion.at(t).y;
    place(model, x, y[0], y[1]);
  });
  return s;
}

}  // namespace

Scene four_bar(Parameters& set) {
  const double rate = set.number("rate", 4, "initial rate of the crank [rad/s]");
  const double crank = 0.4, coupler = 0.9, rocker = 0.8, frame = 1;
  Scene s = bars(crank, coupler, rocker, frame, pi / 3, rate, [=](const Jet& theta) -> Jet {
    // the rocker's end lies where circles about the crank's end and the frame's far pivot meet, on the upper side
    const Jet ex = frame - crank * cos(theta), ey = -crank * sin(theta), d2 = ex * ex + ey * ey, d = sqrt(d2);
    return atan2(ey, ex) + acos((d2 + coupler * coupler - rocker * rocker) / (2 * coupler * d));
  });
  s.id = "C4";
  s.what = "A crank-rocker of spatial revolute joints: three equations more than it has freedoms to take";
  return s;
}

Scene parallelogram(Parameters& set) {
  const double rate = set.number("rate", 4, "initial rate of the crank [rad/s]");
  Scene s = bars(0.5, 1, 0.5, 1, pi / 3, rate, [](const Jet&) { return Jet(0); });
  s.id = "C4";
  s.what = "A parallelogram four-bar, which can fold over where all its bars are in line";
  s.exact = nullptr;  // beyond that place two motions are right
  return s;
}

}  // namespace perp
