// Eight scenes that every engine can be given, each with its known end: position of every body's centre.
// SI units, world axes, quaternions w, x, y, z. Needs the standard library alone.
#pragma once

#include <array>
#include <functional>
#include <string>
#include <vector>

namespace peers {

using Vec = std::array<double, 3>;
using Quat = std::array<double, 4>;

inline Vec operator+(const Vec& a, const Vec& b) { return {a[0] + b[0], a[1] + b[1], a[2] + b[2]}; }
inline Vec operator-(const Vec& a, const Vec& b) { return {a[0] - b[0], a[1] - b[1], a[2] - b[2]}; }
inline Vec operator*(double s, const Vec& a) { return {s * a[0], s * a[1], s * a[2]}; }
double norm(const Vec& a);
/// q v q*, and its inverse.
Vec turned(const Quat& q, const Vec& v);
Vec turned_back(const Quat& q, const Vec& v);

struct Body {
  double radius = 0;  ///< of a sphere; 0: a box
  Vec half{};         ///< half the edges of a box
  double mass = 1;
  Vec x{};
  Quat q{1, 0, 0, 0};
  Vec v{}, w{};

  bool sphere() const { return radius > 0; }
  Vec inertia() const;  ///< principal moments of the solid body
};

/// b turns about `axis` on a (-1: the ground), both through `anchor`.
struct Hinge {
  int a, b;
  Vec anchor, axis;
};

struct Scene {
  std::string name;
  std::vector<Body> bodies;
  std::vector<Hinge> hinges;  ///< an open chain; a scene with hinges has no contacts
  bool floor = false;         ///< solid below z = 0; boxes of a stack touch each other too
  double mu = 0;
  Vec gravity{0, 0, -9.81};
  double t_end = 1;
  std::function<std::vector<Vec>()> end;  ///< centres at t_end
};

const std::vector<std::string>& scene_names();
/// Throws std::invalid_argument if there is none.
Scene scene(const std::string& name);

}  // namespace peers
