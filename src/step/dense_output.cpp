#include "step/dense_output.hpp"

#include <algorithm>
#include <cmath>

namespace perp {
namespace {

/// Hermite's cubic on [0, h] at s h, and its rate.
struct Cubic {
  double a, b, a_rate, b_rate;      // what the value takes of both ends and of their rates
  double da, db, da_rate, db_rate;  // and the rate
  Cubic(double s, double h)
      : a((1 + 2 * s) * (1 - s) * (1 - s)),
        b(s * s * (3 - 2 * s)),
        a_rate(h * s * (1 - s) * (1 - s)),
        b_rate(h * s * s * (s - 1)),
        da(6 * s * (s - 1) / h),
        db(-da),
        da_rate((1 - s) * (1 - 3 * s)),
        db_rate(s * (3 * s - 2)) {}
};

/// Quaternions as w x y z: of a body that turns at w (its axes) q' = q w / 2.
Eigen::Vector4d quaternion_rate(const Eigen::Vector4d& q, const Vector3& w) {
  Eigen::Vector4d rate;
  rate << -q.tail<3>().dot(w), q[0] * w + q.tail<3>().cross(w);
  return 0.5 * rate;
}

}  // namespace

State between_states(const Model& model, const State& a, const State& b, double t) {
  const double h = b.t - a.t;
  if (!(h > 0)) return t < b.t ? a : b;
  const Cubic c((t - a.t) / h, h);
  State x = a;
  x.t = t;
  for (const Body& body : model.bodies()) {
    if (body.nv == 0) continue;
    const int n = body.kind == BodyKind::Generalized || body.kind == BodyKind::Planar ? body.nv : 3;
    const auto qa = a.q.segment(body.q0, n), qb = b.q.segment(body.q0, n);
    const auto va = a.nu.segment(body.v0, n), vb = b.nu.segment(body.v0, n);
    x.q.segment(body.q0, n) = c.a * qa + c.b * qb + c.a_rate * va + c.b_rate * vb;
    x.nu.segment(body.v0, n) = c.da * qa + c.db * qb + c.da_rate * va + c.db_rate * vb;
    if (body.kind != BodyKind::Spatial) continue;
    const Eigen::Vector4d from = a.q.segment<4>(body.q0 + 3);
    Eigen::Vector4d to = b.q.segment<4>(body.q0 + 3);
    if (from.dot(to) < 0) to = -to;
    const Eigen::Vector4d from_rate = quaternion_rate(from, a.nu.segment<3>(body.v0 + 3));
    const Eigen::Vector4d to_rate = quaternion_rate(to, b.nu.segment<3>(body.v0 + 3));
    const Eigen::Vector4d q = c.a * from + c.b * to + c.a_rate * from_rate + c.b_rate * to_rate;
    const Eigen::Vector4d rate = c.da * from + c.db * to + c.da_rate * from_rate + c.db_rate * to_rate;
    x.q.segment<4>(body.q0 + 3) = q.normalized();
    // w of q' = q w / 2, what stretches q left out
    x.nu.segment<3>(body.v0 + 3) =
        2 / q.squaredNorm() *
        (q[0] * rate.tail<3>() - rate[0] * q.tail<3>() - q.tail<3>().cross(rate.tail<3>()));
  }
  model.follow_turns(x);
  return x;
}

std::vector<FoundEvent> find_events(const Model& model, const std::vector<UserEvent>& events, const State& a,
                                    const State& b) {
  constexpr int looks = 8;
  std::vector<FoundEvent> found;
  for (std::size_t i = 0; i < events.size(); ++i) {
    const auto value = [&](double t) {
      return events[i].when(model, t == b.t ? b : between_states(model, a, b, t));
    };
    double low = a.t, before = events[i].when(model, a);
    for (int k = 1; k <= looks; ++k) {
      const double time = k == looks ? b.t : a.t + (b.t - a.t) * k / looks;
      const double now = value(time);
      if (events[i].passes(before, now)) {
        double high = time;
        for (double middle = 0.5 * (low + high); middle > low && middle < high; middle = 0.5 * (low + high))
          (events[i].passes(before, value(middle)) ? high : low) = middle;
        found.push_back({high, i});
      }
      low = time;
      before = now;
    }
  }
  std::stable_sort(found.begin(), found.end(),
                   [](const FoundEvent& x, const FoundEvent& y) { return x.t < y.t; });
  return found;
}

}  // namespace perp
