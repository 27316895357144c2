// d/dt (Wᵀ nu + explicit part) at fixed nu, along the motion: the rates of directions and points, no derivatives by coordinates.
//
// A row's velocity is u = l . (v_B(c) - v_A(c)) + a_B . w_B - a_A . w_A, v_i(c) = v_i + w_i x (c - p_i) of body i's material at the point
// c, so at fixed twists
//   u' = sum over both bodies, b counted +, a counted -, of  l' . v_i(c) + l . (w_i x (c' - v_i)) + a_i' . w_i,
// and prescribed bodies add l . (acceleration of their material at c) + a_i . w_i'.
#include "instant/pair_slopes.hpp"
#include "perp/instant/derivatives.hpp"

namespace perp {
namespace {

std::size_t at(int i) { return static_cast<std::size_t>(i); }

/// A body of the pair: what the rates need of it.
struct Mover {
  const Body& body;
  const Twist& V;
  Vector3 r;           // from its origin to the point
  Twist acceleration;  // prescribed; zero of other bodies

  Vector3 velocity() const { return V.at(r); }
  /// What row (linear, angular) gains by the body's own prescribed acceleration.
  double prescribed(const Vector3& linear, const Vector3& angular) const {
    if (body.kind != BodyKind::Prescribed) return 0;
    return linear.dot(acceleration.at(r)) + angular.dot(acceleration.w);
  }
};

Mover mover(const Model& model, const Instant& s, int body, const Vector3& point) {
  const Body& b = model.bodies()[at(body)];
  return {b, s.V[at(body)], point - s.X[at(body)].p,
          b.kind == BodyKind::Prescribed ? b.motion.acceleration_at(s.t) : Twist{}};
}

/// How fast the directions of a joint's row turn.
struct RowRate {
  Vector3 linear = Vector3::Zero(), angular_a = Vector3::Zero(), angular_b = Vector3::Zero();
};

RowRate rate_of(const JointRow& row, const JointGeometry& joint, const Instant& s, int a, int b) {
  using Kind = JointRow::Kind;
  const Twist &V_A = s.V[at(a)], &V_B = s.V[at(b)];
  RowRate rate;
  switch (row.kind) {
    case Kind::Point:
      rate.linear = V_A.w.cross(s.R[at(a)] * row.in_a);
      return rate;
    case Kind::Perpendicular: {  // of w x u
      const Vector3 u = s.R[at(a)] * row.in_a, w = s.R[at(b)] * row.in_b;
      rate.angular_a = rate.angular_b = V_B.w.cross(w).cross(u) + w.cross(V_A.w.cross(u));
      return rate;
    }
    case Kind::Distance: {  // of e = (c_B - c_A)/length
      const Vector3 r_A = s.R[at(a)] * joint.anchor_a, r_B = s.R[at(b)] * joint.anchor_b;
      const Vector3 apart = s.X[at(b)].p + r_B - s.X[at(a)].p - r_A;
      const double length = apart.norm();
      const Vector3 e = apart / length, apart_t = V_B.at(r_B) - V_A.at(r_A);
      rate.linear = (apart_t - e.dot(apart_t) * e) / length;
      return rate;
    }
    default: {  // angles
      const JointRowDerivative slope = differentiate(row, joint, s.X[at(a)], s.X[at(b)]);
      Eigen::Matrix<double, 12, 1> twists;
      twists << V_A.v, V_A.w, V_B.v, V_B.w;
      rate.linear = slope.linear * twists;
      rate.angular_a = slope.angular_a * twists;
      rate.angular_b = slope.angular_b * twists;
      return rate;
    }
  }
}

}  // namespace

double acceleration_bias(const Model& model, const State& /*x*/, const Instant& s,
                         const JointRowInstant& row) {
  const JointGeometry& joint = model.joint({row.joint});
  const JointRow& geometry =
      row.row >= 0 ? joint.rows[at(row.row)] : joint.coordinates[at(row.coordinate)].row;
  const RowRate rate = rate_of(geometry, joint, s, row.W.a, row.W.b);
  const Mover a = mover(model, s, row.W.a, row.point), b = mover(model, s, row.W.b, row.point);
  const Vector3 point_t = b.velocity();  // c is fixed to B
  const Vector3& l = row.world.linear;
  double bias = rate.linear.dot(b.velocity() - a.velocity()) + rate.angular_b.dot(b.V.w) -
                rate.angular_a.dot(a.V.w) +
                l.dot(b.V.w.cross(point_t - b.V.v) - a.V.w.cross(point_t - a.V.v));
  bias += b.prescribed(l, row.world.angular_b) - a.prescribed(l, row.world.angular_a);
  if (row.prescribed) bias -= joint.motions[at(row.coordinate)]->acceleration_at(s.t);
  return bias;
}

Vector3 acceleration_bias(const Model& model, const State& x, const Instant& s, const ContactInstant& c,
                          const ContactDerivative& geometry) {
  const Contact& contact = model.contacts()[at(c.contact)];
  if (contact.own) return own_bias(model, x, c);
  if (const Contact::Stop& stop = contact.stop; stop.joint >= 0)
    return {stop.side * acceleration_bias(model, x, s, s.coordinate({stop.joint}, stop.coordinate)), 0, 0};
  const Mover sides[] = {mover(model, s, c.W.a, c.position), mover(model, s, c.W.b, c.position)};
  Eigen::Matrix<double, 12, 1> twists;
  twists << sides[0].V.v, sides[0].V.w, sides[1].V.v, sides[1].V.w;
  Vector3 linear_t[3] = {geometry.normal * twists + geometry.normal_t, Vector3::Zero(), Vector3::Zero()};
  if (c.tangents > 0) turn_frame(c, linear_t[0], linear_t[1], linear_t[2]);
  const Vector3 point_t = geometry.point * twists + geometry.point_t;

  Vector3 bias(geometry.gap_tt, 0, 0);
  for (int i = 0; i < 2; ++i) {
    const Mover& m = sides[i];
    const double sign = i == 0 ? -1 : 1;
    const Vector3 velocity = m.velocity(), turning = m.V.w.cross(point_t - m.V.v);
    for (int j = 0; j <= c.tangents; ++j) {
      const Vector3& l = c.frame.col(j);
      bias[j] += sign * (linear_t[j].dot(velocity) + l.dot(turning) + m.prescribed(l, Vector3::Zero()));
    }
    // the explicit rate of the gap changes with the poses as W_n does with time
    bias[0] += sign * (geometry.normal_t.dot(velocity) + c.frame.col(0).dot(m.V.w.cross(geometry.point_t)));
    if (c.tangents == 0 || m.body.kind != BodyKind::Prescribed || !m.body.motion.surface) continue;
    const SurfaceSlope slope = surface_slope(model, s, c, m.body.motion, x.t);
    const Vector3 value_t = slope.by_t + slope.by_point * point_t;
    for (int j = 1; j <= c.tangents; ++j)
      bias[j] += sign * (slope.value.dot(linear_t[j]) + value_t.dot(c.frame.col(j)));
  }
  return bias;
}

}  // namespace perp
