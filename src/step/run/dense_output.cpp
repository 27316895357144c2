#include "step/run/dense_output.hpp"

namespace perp {
namespace {

/// Hermite's cubic on [0, h] at s h, and its rate: what they take of the difference of both ends and of the rates there.
struct Cubic {
  double step, a_rate, b_rate;     // of the value, besides that at the beginning
  double slope, da_rate, db_rate;  // of the rate
  Cubic(double s, double h)
      : step(s * s * (3 - 2 * s)),
        a_rate(h * s * (1 - s) * (1 - s)),
        b_rate(h * s * s * (s - 1)),
        slope(6 * s * (1 - s) / h),
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
    x.q.segment(body.q0, n) = qa + c.step * (qb - qa) + c.a_rate * va + c.b_rate * vb;
    x.nu.segment(body.v0, n) = c.slope * (qb - qa) + c.da_rate * va + c.db_rate * vb;
    if (body.kind != BodyKind::Spatial) continue;
    const Eigen::Vector4d from = a.q.segment<4>(body.q0 + 3);
    Eigen::Vector4d to = b.q.segment<4>(body.q0 + 3);
    if (from.dot(to) < 0) to = -to;
    const Eigen::Vector4d from_rate = quaternion_rate(from, a.nu.segment<3>(body.v0 + 3));
    const Eigen::Vector4d to_rate = quaternion_rate(to, b.nu.segment<3>(body.v0 + 3));
    const Eigen::Vector4d q = from + c.step * (to - from) + c.a_rate * from_rate + c.b_rate * to_rate;
    const Eigen::Vector4d rate = c.slope * (to - from) + c.da_rate * from_rate + c.db_rate * to_rate;
    x.q.segment<4>(body.q0 + 3) = q.normalized();
    // w of q' = q w / 2, what stretches q left out
    x.nu.segment<3>(body.v0 + 3) =
        2 / q.squaredNorm() *
        (q[0] * rate.tail<3>() - rate[0] * q.tail<3>() - q.tail<3>().cross(rate.tail<3>()));
  }
  model.follow_turns(x);
  return x;
}

std::function<State(const Trajectory&, std::size_t, double)> cubics(const Model& model) {
  return [kept = std::make_shared<const Model>(model)](const Trajectory& run, std::size_t i, double t) {
    return between_states(*kept, run.state(i), run.state(i + 1), t);
  };
}

}  // namespace perp
