// Does a friction polygon lose anything on a motion that is known?
#include <algorithm>
#include <cmath>
#include <numbers>

#include "perp/core/errors.hpp"
#include "perp/instant/instant.hpp"
#include "perp/study/convergence.hpp"

namespace perp {
namespace {

constexpr int samples = 64;         // times at which the motion is looked at
constexpr double closed = 1e-9;     // of the largest coordinate: a contact within it is closed
constexpr double sliding = 1e-6;    // of the largest velocity: slower contacts stick
constexpr double alignment = 1e-6;  // [rad] between the friction and a vertex

}  // namespace

bool polygon_is_exact(const Scene& scene, int edges, double t_end) {
  if (!scene.exact) refuse("polygon_is_exact", "scene", scene.name, "needs an exact motion");
  return polygon_is_exact(scene, scene.exact, edges, t_end);
}

bool polygon_is_exact(const Scene& scene, const std::function<State(double)>& motion, int edges,
                      double t_end) {
  Instant instant;
  for (int i = 0; i < samples; ++i) {
    const State x = motion(scene.start.t + (i + 0.5) / samples * (t_end - scene.start.t));
    if (!x.q.allFinite() || !x.nu.allFinite() || x.nu.size() == 0) continue;
    evaluate(scene.model, x, instant);
    const double length = x.q.lpNorm<Eigen::Infinity>(), speed = x.nu.lpNorm<Eigen::Infinity>();
    for (const ContactInstant& contact : instant.contacts) {
      if (contact.tangents < 2 || contact.mu == 0 || contact.psi_n > closed * length) continue;
      const Vector3 u = contact.velocity(x.nu);
      if (u.tail<2>().norm() <= sliding * speed) continue;
      const double angle = std::atan2(-u.z(), -u.y()), edge = 2 * std::numbers::pi / edges;
      if (std::abs(angle - edge * std::round(angle / edge)) > alignment) return false;
    }
  }
  return true;
}

}  // namespace perp
