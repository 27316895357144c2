#include "random_scene.hpp"

#include <cmath>
#include <numbers>

#include "maker.hpp"

namespace checker {

std::uint64_t Random::next() {  // splitmix64
  std::uint64_t z = (state_ += 0x9e3779b97f4a7c15ULL);
  z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9ULL;
  z = (z ^ (z >> 27)) * 0x94d049bb133111ebULL;
  return z ^ (z >> 31);
}
double Random::uniform(double from, double to) {
  return from + (to - from) * static_cast<double>(next() >> 11) * 0x1p-53;
}
double Random::decades(double from, double to) { return std::pow(10, uniform(from, to)); }
Vector3d Random::direction() {
  for (;;) {
    const Vector3d v(uniform(-1, 1), uniform(-1, 1), uniform(-1, 1));
    if (v.norm() > 0.1 && v.norm() < 1) return v.normalized();
  }
}
Quaterniond Random::turn() {
  return Quaterniond(Eigen::AngleAxisd(uniform(-std::numbers::pi, std::numbers::pi), direction()));
}

Maker::Maker(std::uint64_t seed, bool plane_) : random(seed), plane(plane_) {
  constexpr double g = 9.81;
  L = random.decades(-4 + 0.4, 3 - 0.6);
  T = std::sqrt(L / g);
  V = std::sqrt(L * g);
  h = T * random.decades(-2.5, -1);
  steps = 3 + random.below(4);
  middle_ = random.decades(-5.5, 5.5);
  scene.gravity = random.chance(0.95) ? Vector3d(-g * up()) : Vector3d::Zero();
}

RandomScene Maker::take() { return {scene, h, steps}; }

double Maker::mass() {
  return random.chance(0.75) ? middle_ * random.decades(-0.5, 0.5) : random.decades(-6, 6);
}
double Maker::mu() { return random.chance(0.15) ? 0 : random.uniform(0, random.chance(0.6) ? 0.8 : 3); }
double Maker::e() { return random.chance(0.55) ? 0 : random.chance(0.2) ? 1 : random.uniform(0, 1); }
Vector3d Maker::any(double scale) {
  Vector3d v = scale * random.uniform(0.2, 1) * random.direction();
  if (plane) v.z() = 0;
  return v;
}

int Maker::body(const std::string& shape, const std::vector<double>& sizes, const Vector3d& p,
                const Quaterniond& q) {
  Body b;
  b.name = "b" + std::to_string(scene.bodies.size());
  b.kind = Kind::Spatial;
  b.mass = mass();
  b.shape = shape;
  b.size = sizes;
  if (random.chance(0.1)) {  // other moments about the same axes
    const Vector3d J = b.inertia().diagonal();
    b.shape = "moments";
    b.size = {J.x(), J.y(), 0.9 * std::min(J.z(), J.x() + J.y()) + 0.1 * std::abs(J.x() - J.y())};
  }
  b.rest = {p, q.normalized()};
  scene.bodies.push_back(b);
  return static_cast<int>(scene.bodies.size()) - 1;
}

int Maker::planar_body(double about, const Vector3d& p, double angle) {
  Body b;
  b.name = "b" + std::to_string(scene.bodies.size());
  b.kind = Kind::Planar;
  b.mass = mass();
  b.size = {b.mass * about * about};
  b.rest.p = {p.x(), p.y(), 0};
  b.rest_angle = angle;
  b.rest.q = Quaterniond(Eigen::AngleAxisd(angle, Vector3d::UnitZ()));
  scene.bodies.push_back(b);
  return static_cast<int>(scene.bodies.size()) - 1;
}

int Maker::particle(const Vector3d& p) {
  Body b;
  b.name = "b" + std::to_string(scene.bodies.size());
  b.kind = Kind::Particle;
  b.mass = mass();
  b.rest.p = p;
  scene.bodies.push_back(b);
  return static_cast<int>(scene.bodies.size()) - 1;
}

int Maker::prescribed(const Vector3d& p) {
  Body b;
  b.name = "b" + std::to_string(scene.bodies.size());
  b.kind = Kind::Prescribed;
  b.rest.p = p;
  const int kind = random.below(4);
  if (kind == 0) b.motion = {"shaker", any(0.3 * L), random.uniform(0.3, 3) / T, 0};
  if (kind == 1)
    b.motion = {"turntable", plane ? Vector3d(Vector3d::UnitZ()) : up(), random.uniform(-1, 1) / T, 0};
  if (kind == 2) {
    b.motion = {"belt", any(V), 0, 0};
    b.motion.vector -= b.motion.vector.dot(up()) * up();
  }
  scene.bodies.push_back(b);
  return static_cast<int>(scene.bodies.size()) - 1;
}

int Maker::floor() { return random.chance(0.75) ? 0 : prescribed(any(0.2 * L)); }

Contact& Maker::contact(const std::string& gap, int a, int b) {
  Contact c;
  c.name = "c" + std::to_string(scene.contacts.size() + 1);
  c.a = a;
  c.b = b;
  c.gap = gap;
  c.mu = mu();
  c.e = e();
  if (c.mu > 0 && !plane && random.chance(0.2)) c.tangent = random.direction();
  scene.contacts.push_back(c);
  return scene.contacts.back();
}

Touch Maker::nearest() const {
  Touch best;
  best.gap = std::numeric_limits<double>::infinity();
  std::size_t count = 0;
  for (const Joint& j : scene.joints) count += coordinate_names(j.kind).size();
  for (const Touch& t : touches(scene, first_state(scene), std::vector<double>(count, 0)))
    if (t.contact == static_cast<int>(scene.contacts.size()) - 1 && t.gap < best.gap) best = t;
  return best;
}

void Maker::settle(double gap) {
  for (int i = 0; i < 4; ++i) {
    const Touch t = nearest();
    at(t.b).rest.p += (gap - t.gap) * t.normal;
  }
}

void Maker::raise_plane(double gap) {
  Contact& c = scene.contacts.back();
  for (int i = 0; i < 3; ++i) {
    const Touch t = nearest();
    auto& point = c.size["point"];
    if (point.empty()) point = {0, 0, 0};
    const Vector3d in_a = at(c.a).rest.q.conjugate() * ((t.gap - gap) * t.normal);
    for (std::size_t k = 0; k < 3; ++k) point[k] += in_a[static_cast<Eigen::Index>(k)];
  }
}

void Maker::launch(bool rolls) {
  settle(0);
  const State x = first_state(scene);
  const Touch t = nearest();
  Body& b = at(t.b);
  Vector3d slip = random.chance(0.3) ? Vector3d::Zero() : any(V * random.decades(-3, 0.3));
  slip -= slip.dot(t.normal) * t.normal;
  const Vector3d surface =
      relative_velocity(scene, x, t) - x.bodies[static_cast<std::size_t>(t.b)].velocity_at(t.point);
  Vector3d w = Vector3d::Zero();
  if (b.turns() && random.chance(0.6))
    w = (plane ? Vector3d(random.uniform(-1, 1) * Vector3d::UnitZ()) : random.direction()) *
        random.decades(-2, 0) * 2 / T;
  if (!rolls && !plane) w = w.dot(t.normal) * t.normal;
  if (!rolls && plane) w.setZero();
  const bool falls = random.chance(0.62);
  const double approach = falls ? V * random.decades(-1.3, 0.2) : 0;
  const Vector3d carried = -surface - w.cross(t.point - b.rest.p);
  b.v = carried + slip - approach * t.normal;
  if (b.turns()) b.w = w;
  if (plane) b.v.z() = 0;
  // along the normal the contact point has just the approach
  const double extra = t.normal.dot(b.v + w.cross(t.point - b.rest.p) + surface) + approach;
  b.v -= extra * t.normal;
  if (falls && random.chance(0.8)) settle(approach * h * random.uniform(0, 0.8 * steps));
}

RandomScene random_scene(std::uint64_t seed) {
  Random choice(~seed);
  const double share = choice.uniform();
  const bool plane = share > 0.8;
  Maker m(seed, plane);
  const auto recipe = [&](double s) {
    if (s < 0.26) return make_on_plane;
    if (s < 0.36) return make_pile;
    if (s < 0.44) return make_inside;
    if (s < 0.54) return make_boxes;
    if (s <= 0.8) return make_linkage;
    return make_planar;
  };
  recipe(share)(m);
  return m.take();
}

}  // namespace checker
