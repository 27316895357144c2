// Random starts of five small scenes, the same from the same seed everywhere.
#pragma once

#include <cmath>
#include <random>
#include <vector>

#include "perp/model/gaps.hpp"
#include "perp/model/model.hpp"

namespace perp {

struct Start {
  Model model;
  State x;
};

/// Numbers in an interval, from a seed.
class Draw {
 public:
  explicit Draw(unsigned seed) : random_(seed) {}
  double operator()(double a, double b) {
    return a + (b - a) * (static_cast<double>(random_()) / 4294967296.0);
  }
  bool coin() { return random_() % 2 == 0; }
  Vector3 vector(double size) {
    const double x = (*this)(-size, size), y = (*this)(-size, size), z = (*this)(-size, size);
    return {x, y, z};
  }
  /// Of a contact: mu up to `most`; half of them without restitution.
  ContactOptions contact(double most) {
    const double mu = (*this)(0, most);
    return {.mu = mu, .e = coin() ? 0 : (*this)(0, 0.9)};
  }

 private:
  std::mt19937 random_;
};

/// A rod in a plane, half of the starts on one tip.
inline Start rod_start(Draw& draw) {
  Start s;
  s.model.set_gravity({0, -9.81, 0});
  const BodyId b = s.model.add_planar_body(1, 1.0 / 3);
  const ContactOptions contact = draw.contact(2);
  for (const double end : {-1.0, 1.0})
    s.model.add_contact(ground, b, point_on_plane({end, 0, 0}, horizontal_line), contact);
  s.x = s.model.rest();
  const double angle = draw(-3.1, 3.1);
  s.x.q << 0, std::abs(std::sin(angle)) + (draw.coin() ? draw(0, 0.3) : 0), angle;
  s.x.nu << draw(-3, 3), draw(-3, 1), draw(-5, 5);
  return s;
}

/// A brick above the floor, in every third start flat on it.
inline Start box_start(Draw& draw) {
  Start s;
  const Vector3 size(0.3, 0.2, 0.1);
  const BodyId b = s.model.add_body(Inertia::solid_box(1, size));
  s.model.add_contact(ground, b, box_on_plane(size), draw.contact(1));
  s.x = s.model.rest();
  const bool flat = draw(0, 3) < 1;
  s.model.set_orientation(s.x, b, rotation(flat ? Vector3(0, 0, draw(-3, 3)) : draw.vector(3)));
  s.model.set_position(s.x, b, {0, 0, flat ? 0.05 : draw(0.19, 0.4)});
  s.model.set_velocity(s.x, b, draw.vector(2), draw.vector(8));
  return s;
}

/// Two balls above the floor, one of them on it in half of the starts, that may meet.
inline Start two_spheres_start(Draw& draw) {
  Start s;
  const ContactOptions contact = draw.contact(1);
  const BodyId a = s.model.add_body(Inertia::solid_sphere(1, 0.1));
  const BodyId b = s.model.add_body(Inertia::solid_sphere(draw(0.2, 5), 0.15));
  s.model.add_contact(ground, a, sphere_on_plane(0.1), contact);
  s.model.add_contact(ground, b, sphere_on_plane(0.15), contact);
  s.model.add_contact(a, b, sphere_on_sphere(0.1, 0.15), contact);
  s.x = s.model.rest();
  s.model.set_position(s.x, a, {0, 0, 0.1 + (draw.coin() ? draw(0, 0.2) : 0)});
  const double x = draw(0.26, 0.5), y = draw(-0.2, 0.2);
  s.model.set_position(s.x, b, {x, y, 0.15 + draw(0, 0.2)});
  for (const BodyId body : {a, b}) {
    const Vector3 v = draw.vector(2);
    s.model.set_velocity(s.x, body, v, draw.vector(8));
  }
  return s;
}

/// Four bars hinged to a loop, free above the floor, whose corners touch it; lengths of which no choice of signs adds up to zero.
inline Start four_bar_start(Draw& draw) {
  Start s;
  s.model.set_gravity({0, -9.81, 0});
  const double lengths[] = {0.5, 0.4, 0.45, 0.2};
  // corners of a quadrangle with these sides
  const double corner = draw(0.9, 1.6);
  Vector3 p[4] = {Vector3::Zero(),
                  {lengths[0], 0, 0},
                  Vector3::Zero(),
                  lengths[3] * Vector3(std::cos(corner), std::sin(corner), 0)};
  const Vector3 d = p[3] - p[1];
  const double along = (d.squaredNorm() + lengths[1] * lengths[1] - lengths[2] * lengths[2]) / (2 * d.norm());
  const double across = std::sqrt(lengths[1] * lengths[1] - along * along);
  p[2] = p[1] + along * d.normalized() + across * Vector3(d.y(), -d.x(), 0).normalized();
  const Quaternion turn = rotation({0, 0, draw(-3.1, 3.1)});
  double lowest = 0;
  for (Vector3& corner_at : p) lowest = std::min(lowest, (corner_at = turn * corner_at).y());
  const double raise = (draw.coin() ? draw(0, 0.2) : 0) - lowest;
  for (Vector3& corner_at : p) corner_at.y() += raise;
  BodyId bar[4];
  for (int i = 0; i < 4; ++i) {
    const Vector3 from = p[i], to = p[(i + 1) % 4], along_bar = to - from;
    const double length = along_bar.norm(), angle = std::atan2(along_bar.y(), along_bar.x());
    bar[i] = s.model.add_planar_body(2 * length, 2 * length * length * length / 12,
                                     {.pose = {0.5 * (from + to), rotation({0, 0, angle})}});
  }
  const ContactOptions contact = draw.contact(1);
  for (int i = 0; i < 4; ++i) {
    s.model.add_joint(revolute(bar[i], bar[(i + 1) % 4], {.point = p[(i + 1) % 4]}));
    s.model.add_contact(ground, bar[i],
                        point_on_plane({0.5 * (p[(i + 1) % 4] - p[i]).norm(), 0, 0}, horizontal_line),
                        contact);
  }
  s.x = s.model.rest();
  const Vector3 v = draw.vector(2);
  const double rate = draw(-4, 4);  // of the whole as one body: no joint is jerked
  for (int i = 0; i < 4; ++i) {
    const Vector3 r = 0.5 * (p[i] + p[(i + 1) % 4]);
    s.x.nu.segment<3>(3 * i) << v.x() - rate * r.y(), v.y() + rate * r.x(), rate;
  }
  return s;
}

/// An ellipsoid of three different axes above the floor.
inline Start ellipsoid_start(Draw& draw) {
  Start s;
  const Vector3 axes(0.2, 0.15, 0.1);
  const BodyId b = s.model.add_body(Inertia::solid_ellipsoid(1, axes));
  s.model.add_contact(ground, b, ellipsoid_on_plane(axes), draw.contact(1));
  s.x = s.model.rest();
  s.model.set_orientation(s.x, b, rotation(draw.vector(3)));
  s.model.set_position(s.x, b, {0, 0, 0.2 + draw(0, 0.2)});
  const Vector3 v = draw.vector(2);
  s.model.set_velocity(s.x, b, v, draw.vector(8));
  return s;
}

/// A chain of 3 to 12 links that falls on the floor, tips that touch without restitution.
inline Start chain_start(Draw& draw) {
  Start s;
  s.model.set_gravity({0, -9.81, 0});
  const int links = 3 + static_cast<int>(draw(0, 10));
  const double half = 0.075, mu = draw(0, 0.8);
  std::vector<double> angle;
  for (int i = 0; i < links; ++i) angle.push_back(draw(-0.6, 0.6));
  std::vector<Vector3> end{Vector3::Zero()};
  double lowest = 0;
  for (const double a : angle) {
    end.push_back(end.back() + 2 * half * Vector3(std::cos(a), std::sin(a), 0));
    lowest = std::min(lowest, end.back().y());
  }
  const double raise = draw(0.02, 0.3) - lowest;
  for (int i = 0; i < links; ++i) {
    const auto k = static_cast<std::size_t>(i);
    const Vector3 centre = 0.5 * (end[k] + end[k + 1]) + Vector3(0, raise, 0);
    const BodyId link =
        s.model.add_planar_body(0.1, 0.1 * half * half / 3, {.pose = {centre, rotation({0, 0, angle[k]})}});
    s.model.add_contact(ground, link, point_on_plane({half, 0, 0}, horizontal_line), {.mu = mu});
    if (i == 0)
      s.model.add_contact(ground, link, point_on_plane({-half, 0, 0}, horizontal_line), {.mu = mu});
    else
      s.model.add_joint(revolute({link.index - 1}, link, {.point = end[k] + Vector3(0, raise, 0)}));
  }
  s.x = s.model.rest();
  return s;
}

/// A frame on two to six wheels whose brakes hold or slip, on a slope, at rest or rolling; the ground is rough enough for all of them.
inline Start braked_cart_start(Draw& draw) {
  Start s;
  const double slope = draw(0, 0.5), r = 0.1, speed = draw.coin() ? 0 : draw(-2, 2), mu = draw(0.9, 1.2);
  s.model.set_gravity(9.81 * Vector3(std::sin(slope), -std::cos(slope), 0));
  const int wheels = 2 + static_cast<int>(draw(0, 5));
  const BodyId frame = s.model.add_planar_body(draw(1, 5), 0.1, {.pose = {{0, r, 0}}});
  std::vector<BodyId> wheel;
  for (int i = 0; i < wheels; ++i) {
    const Vector3 hub(0.6 * i / (wheels - 1) - 0.3, r, 0);
    wheel.push_back(s.model.add_planar_body(0.5, 0.0025, {.pose = {hub}}));
    s.model.add_joint(revolute(frame, wheel.back(), {.point = hub, .friction = draw(0, 0.4)}));
    s.model.add_contact(ground, wheel.back(), disc_on_line(r, horizontal_line), {.mu = mu});
  }
  s.x = s.model.rest();
  s.model.set_velocity(s.x, frame, {speed, 0, 0});
  for (const BodyId w : wheel) s.model.set_velocity(s.x, w, {speed, 0, 0}, {0, 0, -speed / r});
  return s;
}

/// A coin that rolls on its edge and spins, not yet near to lying flat.
inline Start coin_start(Draw& draw) {
  Start s;
  const double r = 0.012, tilt = draw(0.3, 1.2);
  const BodyId b = s.model.add_body(Inertia::solid_cylinder(0.008, r, 0.002));
  s.model.add_contact(ground, b, disc_on_plane(r), {.mu = draw(0.05, 0.6)});
  s.x = s.model.rest();
  s.model.set_orientation(s.x, b, rotation({0, tilt, 0}));
  s.model.set_position(s.x, b, {0, 0, r * std::sin(tilt) + (draw.coin() ? 0 : draw(0, 0.005))});
  s.model.set_velocity(s.x, b, {0, 0, 0}, {draw(-3, 3), 0, draw(30, 60)});
  return s;
}

/// Three boxes on each other, in line or not, the lowest or the highest of which may be pushed.
inline Start stack_start(Draw& draw) {
  Start s;
  const ContactOptions contact{.mu = draw(0, 1)};
  const bool aligned = draw.coin();
  std::vector<BodyId> box;
  double z = 0;
  for (int i = 0; i < 3; ++i) {
    const Vector3 size = aligned ? Vector3(0.2, 0.2, 0.1) : Vector3(draw(0.1, 0.2), draw(0.1, 0.2), 0.1);
    box.push_back(s.model.add_body(Inertia::solid_box(draw(0.5, 2), size),
                                   {.pose = {{aligned || i == 0 ? 0 : draw(-0.02, 0.02),
                                              aligned || i == 0 ? 0 : draw(-0.02, 0.02), z + 0.05}}}));
    if (i == 0)
      s.model.add_contact(ground, box[0], box_on_plane(size), contact);
    else
      s.model.add_contact(box[static_cast<std::size_t>(i) - 1], box.back(), box_on_box({0.2, 0.2, 0.1}, size),
                          contact);
    z += 0.1;
  }
  s.x = s.model.rest();
  if (draw.coin()) {
    const BodyId pushed = box[draw.coin() ? 0 : 2];
    s.model.set_velocity(s.x, pushed, {draw(-0.3, 0.3), 0, 0});
  }
  return s;
}

/// A rod that slides on its tip so that CP1's A falls to zero and below: Painleve's region, entered or begun in.
inline Start painleve_start(Draw& draw) {
  Start s;
  s.model.set_gravity({0, -9.81, 0});
  const BodyId b = s.model.add_planar_body(1, draw(0.2, 0.6) / 3);
  const ContactOptions contact{.mu = draw(1, 3)};
  for (const double end : {-1.0, 1.0})
    s.model.add_contact(ground, b, point_on_plane({end, 0, 0}, horizontal_line), contact);
  s.x = s.model.rest();
  const double angle = draw(0.3, 1.5), rate = draw(-2, 2);
  s.x.q << 0, std::sin(angle), angle;
  s.x.nu << draw(-5, 5), rate * std::cos(angle), rate;
  return s;
}

/// What comes of the first `count` starts of a family, by `run_one`.
template <class Outcomes, class Make, class RunOne>
Outcomes run_all(const char* name, Make make, RunOne run_one, int count) {
  Outcomes outcomes;
  for (int i = 0; i < count; ++i) {
    Draw draw(static_cast<unsigned>(i + 1));
    CAPTURE(name, i);
    run_one(make(draw), outcomes);
  }
  return outcomes;
}

}  // namespace perp
