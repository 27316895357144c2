// A scene at a time of its exact motion, for the numbers that are known of it.
#pragma once

#include <catch2/catch.hpp>

#include "perp/study/scene.hpp"

namespace perp {

/// A scene, and a body of it by name, at exact(t).
struct At {
  Scene s;
  State x;
  At(std::string_view name, double t, const SceneParameters& set = {}) : s(scene(name, set)), x(s.exact(t)) {}
  Vector3 p(const char* body) const { return s.model.position(x, s.model.find_body(body)); }
  Vector3 v(const char* body) const { return s.model.velocity(x, s.model.find_body(body)); }
  Vector3 w(const char* body) const { return s.model.angular_velocity(x, s.model.find_body(body)); }
  Quaternion q(const char* body) const { return s.model.pose(x, s.model.find_body(body)).q; }
  double angle(const char* body) const { return s.model.angle(x, s.model.find_body(body)); }
};

/// Numbers from a computation of their own, with as many digits as are known.
inline auto near(double value, double digits = 1e-14) {
  return Catch::Detail::Approx(value).epsilon(digits).margin(digits);
}

}  // namespace perp
