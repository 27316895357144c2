#include "perp/instant/derivatives.hpp"

#include <cmath>
#include <numeric>

#include "instant/pair_slopes.hpp"

namespace perp {
namespace {

using Columns = ContactDerivative::Columns;

std::size_t at(int i) { return static_cast<std::size_t>(i); }

/// Directions fixed to a pair at one point, and how they turn: rows psi' = linear . (relative velocity at the point) +
/// angular[1] . w_b - angular[0] . w_a.
template <int C>
struct Directions {
  Vector3 linear[C], angular[2][C];  // angular on a and on b
  Columns d_linear[C], d_angular[2][C];
  Columns d_point;
  Side side[2];

  /// (W p)' by the twists of both bodies, in their coordinates: of the wrench s (F, r x F + A) on each, seen from the body.
  void force(const Eigen::Matrix<double, C, 1>& p, Eigen::Matrix<double, 12, 12>& out) const {
    out.setZero();
    if (p.isZero(0)) return;
    Vector3 F = Vector3::Zero(), A[2] = {F, F};
    Columns dF = Columns::Zero(), dA[2] = {dF, dF};
    for (int j = 0; j < C; ++j) {
      F += p[j] * linear[j];
      dF += p[j] * d_linear[j];
      for (int i = 0; i < 2; ++i) {
        A[i] += p[j] * angular[i][j];
        dA[i] += p[j] * d_angular[i][j];
      }
    }
    for (int i = 0; i < 2; ++i) {
      const Side& s = side[i];
      if (s.body.nv == 0) continue;
      Eigen::Matrix<double, 6, 12> wrench;
      Columns dr = d_point;
      dr.middleCols<3>(s.v) -= Matrix3::Identity();
      wrench.topRows<3>() = dF;
      wrench.bottomRows<3>() = skew(s.r) * dF - skew(F) * dr + dA[i];
      wrench.bottomRows<3>().middleCols<3>(s.w) += skew(s.r.cross(F) + A[i]);
      const Eigen::Matrix<double, 6, 12> own = s.T.transpose() * (s.sign * wrench);
      out.middleRows<6>(s.v).leftCols<6>() = own.leftCols<6>() * side[0].T;
      out.middleRows<6>(s.v).rightCols<6>() = own.rightCols<6>() * side[1].T;
    }
  }

  /// Derivative of row j's velocity by the twists, world axes; a body's own w keeps its body components if it is free.
  Eigen::Matrix<double, 1, 12> velocity(int j) const {
    Eigen::Matrix<double, 1, 12> du = Eigen::Matrix<double, 1, 12>::Zero();
    for (int i = 0; i < 2; ++i) {
      const Side& s = side[i];
      const Vector3 w = s.V.w, v = s.V.at(s.r);
      const Matrix3 W = skew(w);
      du += s.sign * (v.transpose() * d_linear[j] + w.transpose() * d_angular[i][j] +
                      linear[j].transpose() * W * d_point);
      du.middleCols<3>(s.v) -= s.sign * linear[j].transpose() * W;
      if (s.body.nv > 0)
        du.middleCols<3>(s.w) +=
            s.sign * (linear[j].transpose() * skew(s.r) * W - angular[i][j].transpose() * W);
    }
    return du;
  }

  /// What prescribed bodies add to row j's explicit time derivative.
  double prescribed(int j, double t, const Eigen::Matrix<double, 1, 12>& du) const {
    double rate = 0;
    for (int i = 0; i < 2; ++i) {
      const Side& s = side[i];
      if (s.body.kind != BodyKind::Prescribed) continue;
      const Twist a = s.body.motion.acceleration_at(t);
      rate += s.sign * (linear[j].dot(a.at(s.r)) + angular[i][j].dot(a.w));
      rate += du.middleCols<3>(s.v).dot(s.V.v) + du.middleCols<3>(s.w).dot(s.V.w);
    }
    return rate;
  }

  Eigen::Matrix<double, 1, 12> in_coordinates(const Eigen::Matrix<double, 1, 12>& du) const {
    Eigen::Matrix<double, 1, 12> out;
    out << du.leftCols<6>() * side[0].T, du.rightCols<6>() * side[1].T;
    return out;
  }
};

Directions<1> directions(const Model& model, const Instant& s, const JointRowInstant& row) {
  const JointGeometry& joint = model.joint({row.joint});
  const JointRow& geometry =
      row.row >= 0 ? joint.rows[at(row.row)] : joint.coordinates[at(row.coordinate)].row;
  const JointRowDerivative slope = differentiate(geometry, joint, s.X[at(row.W.a)], s.X[at(row.W.b)]);
  Directions<1> d{{row.world.linear},
                  {{row.world.angular_a}, {row.world.angular_b}},
                  {slope.linear},
                  {{slope.angular_a}, {slope.angular_b}},
                  Columns::Zero(),
                  {side_of(model, s, row.W.a, -1, row.point), side_of(model, s, row.W.b, +1, row.point)}};
  d.d_point.middleCols<3>(6).setIdentity();
  d.d_point.middleCols<3>(9) = -skew(row.point - s.X[at(row.W.b)].p);
  return d;
}

/// How a gap of one's own changes along the direction (dq, dt) at (q, t): columns and explicit rates.
struct OwnSlope {
  Vector normal, tangent;
  double gap_t = 0, tangent_t = 0;

  /// Of the velocities along n, t, at fixed nu.
  Vector2 velocity(const Vector& nu) const {
    return {normal.dot(nu) + gap_t, tangent.size() > 0 ? tangent.dot(nu) + tangent_t : 0.0};
  }
};

/// Sum of weights (f(ks) - f(-ks))/s, k = 1 ... 4: for what bends over a hundredth of a unit, truncation is 1e-11 of the derivative,
/// rounding less. Zero where the point is not there all around.
OwnSlope own_slope(const Contact& contact, const Vector& q, double t, const Vector& dq, double dt) {
  constexpr double s = 1e-3, weights[] = {4.0 / 5, -1.0 / 5, 4.0 / 105, -1.0 / 280};
  OwnSlope none{.normal = Vector::Zero(q.size()), .tangent = {}};
  if (contact.tangents > 0) none.tangent.setZero(q.size());
  OwnSlope slope = none;
  for (int k = 1; k <= 4; ++k) {
    const double weight = weights[k - 1] / s;
    const GeneralizedPoint after = contact.own(q + k * s * dq, t + k * s * dt),
                           before = contact.own(q - k * s * dq, t - k * s * dt);
    if (after.gap == infinity || before.gap == infinity) return none;
    slope.normal += weight * (after.normal - before.normal);
    slope.gap_t += weight * (after.gap_t - before.gap_t);
    if (contact.tangents == 0) continue;
    slope.tangent += weight * (after.tangent - before.tangent);
    slope.tangent_t += weight * (after.tangent_t - before.tangent_t);
  }
  return slope;
}

void differentiate_own(const Model& model, const State& x, const ContactInstant& c, const Vector3& p,
                       PairDerivative<3>& out) {
  const Contact& contact = model.contacts()[at(c.contact)];
  const Body& body = model.body(contact.b);
  const Vector q = x.q.segment(body.q0, body.nq), nu = x.nu.segment(body.v0, body.nv);
  out.force.setZero();
  out.velocity.setZero();
  for (int k = 0; k < body.nv; ++k) {
    const OwnSlope slope = own_slope(contact, q, x.t, Vector::Unit(body.nv, k), 0);
    auto force = out.force.col(6 + k).segment(6, body.nv);
    force = p.x() * slope.normal;
    if (c.tangents > 0) force += p.y() * slope.tangent;
    out.velocity.col(6 + k).head<2>() = slope.velocity(nu);
  }
  out.velocity_t << own_slope(contact, q, x.t, Vector::Zero(body.nv), 1).velocity(nu), 0;
}

}  // namespace

/// Over 1e-5 of the distance from the bodies' origins, and of the time in which something runs or falls that far: truncation and rounding
/// are both 1e-10 of a field that bends over them.
SurfaceSlope surface_slope(const Model& model, const Instant& s, const ContactInstant& c,
                           const PrescribedMotion& motion, double t) {
  constexpr double part = 1e-5;
  const Vector3& point = c.position;
  SurfaceSlope slope{motion.surface(t, point), {}, {}};
  double length = point.norm();
  for (const int body : {c.W.a, c.W.b}) length = std::max(length, (point - s.X[at(body)].p).norm());
  if (length == 0) length = 1;  // a point on both origins: nothing else is there to measure by
  const double speed =
      std::max({slope.value.norm(), c.velocity(s.nu).norm(), std::sqrt(model.gravity().norm() * length)});
  const double step = part * length, dt = speed > 0 ? part * length / speed : part;
  slope.by_t = (motion.surface(t + dt, point) - motion.surface(t - dt, point)) / (2 * dt);
  for (int k = 0; k < 3; ++k) {
    const Vector3 d = step * Vector3::Unit(k);
    slope.by_point.col(k) = (motion.surface(t, point + d) - motion.surface(t, point - d)) / (2 * step);
  }
  return slope;
}

/// Along the motion at once.
Vector3 own_bias(const Model& model, const State& x, const ContactInstant& c) {
  const Contact& contact = model.contacts()[at(c.contact)];
  const Body& body = model.body(contact.b);
  const Vector q = x.q.segment(body.q0, body.nq), nu = x.nu.segment(body.v0, body.nv);
  const double speed = std::max(1.0, nu.cwiseAbs().maxCoeff());
  Vector3 bias = Vector3::Zero();
  bias.head<2>() = speed * own_slope(contact, q, x.t, nu / speed, 1 / speed).velocity(nu);
  return bias;
}

void differentiate(const Model& model, const State& x, const Instant& instant, const ContactInstant& c,
                   const ContactDerivative& geometry, const Vector3& p, PairDerivative<3>& out) {
  if (model.contacts()[at(c.contact)].own) return differentiate_own(model, x, c, p, out);
  if (const Contact::Stop& stop = model.contacts()[at(c.contact)].stop; stop.joint >= 0) {
    PairDerivative<1> row;
    differentiate(model, instant, instant.coordinate({stop.joint}, stop.coordinate), stop.side * p.x(), row);
    out.force = row.force;
    out.velocity.setZero();
    out.velocity.row(0) = stop.side * row.velocity;
    out.velocity_t = {stop.side * row.velocity_t[0], 0, 0};
    return;
  }
  const Vector3 zero = Vector3::Zero();
  Directions<3> d{
      {c.frame.col(0), c.frame.col(1), c.frame.col(2)},
      {{zero, zero, zero}, {zero, zero, zero}},
      {geometry.normal, Columns::Zero(), Columns::Zero()},
      {{Columns::Zero(), Columns::Zero(), Columns::Zero()},
       {Columns::Zero(), Columns::Zero(), Columns::Zero()}},
      geometry.point,
      {side_of(model, instant, c.W.a, -1, c.position), side_of(model, instant, c.W.b, +1, c.position)}};
  Vector3 linear_t[3] = {geometry.normal_t, zero, zero};
  if (c.tangents > 0) {
    turn_frame(c, geometry.normal, d.d_linear[1], d.d_linear[2]);
    turn_frame(c, geometry.normal_t, linear_t[1], linear_t[2]);
  }
  d.force(p, out.force);
  out.velocity.setZero();
  out.velocity_t.setZero();
  for (int j = 0; j <= c.tangents; ++j) {
    Eigen::Matrix<double, 1, 12> du = d.velocity(j);
    for (const Side& s : d.side) {
      out.velocity_t[j] +=
          s.sign * (linear_t[j].dot(s.V.at(s.r)) + d.linear[j].dot(s.V.w.cross(geometry.point_t)));
      if (j == 0) {  // gap_t: its slopes are the rates of W_n
        du.middleCols<3>(s.v) += s.sign * geometry.normal_t.transpose();
        du.middleCols<3>(s.w) +=
            s.sign * (s.r.cross(geometry.normal_t) + geometry.point_t.cross(d.linear[0])).transpose();
      } else if (s.body.kind == BodyKind::Prescribed && s.body.motion.surface) {
        const SurfaceSlope slope = surface_slope(model, instant, c, s.body.motion, x.t);
        du += s.sign * (slope.value.transpose() * d.d_linear[j] +
                        d.linear[j].transpose() * slope.by_point * d.d_point);
        out.velocity_t[j] += s.sign * (linear_t[j].dot(slope.value) + d.linear[j].dot(slope.by_t) +
                                       d.linear[j].dot(slope.by_point * geometry.point_t));
      }
    }
    out.velocity_t[j] += d.prescribed(j, x.t, du) + (j == 0 ? geometry.gap_tt : 0);
    out.velocity.row(j) = d.in_coordinates(du);
  }
}

void differentiate(const Model& model, const Instant& instant, const JointRowInstant& row, double p,
                   PairDerivative<1>& out) {
  const Directions<1> d = directions(model, instant, row);
  d.force(Eigen::Matrix<double, 1, 1>(p), out.force);
  const Eigen::Matrix<double, 1, 12> du = d.velocity(0);
  out.velocity = d.in_coordinates(du);
  out.velocity_t[0] = d.prescribed(0, instant.t, du);
  if (row.prescribed)
    out.velocity_t[0] -= model.joint({row.joint}).motions[at(row.coordinate)]->acceleration_at(instant.t);
}

void ContactDerivatives::evaluate(const Model& model, const Instant& instant, std::span<const int> which) {
  all_.resize(instant.contacts.size());
  int last = -1;
  for (const int i : which) {
    const ContactInstant& c = instant.contacts[at(i)];
    const Contact& contact = model.contacts()[at(c.contact)];
    if (contact.stop.joint >= 0 || contact.own) continue;  // its coordinate's row, or its body, has them
    if (c.contact != last) {
      points_.resize(at(contact.gap.points()));
      contact.gap.differentiate(instant.X[at(contact.a.index)], instant.X[at(contact.b.index)], instant.t,
                                points_);
      last = c.contact;
    }
    all_[at(i)] = points_[at(c.point - contact.first_point)];
  }
}

void ContactDerivatives::evaluate(const Model& model, const Instant& instant) {
  std::vector<int> which(instant.contacts.size());
  std::iota(which.begin(), which.end(), 0);
  evaluate(model, instant, which);
}

}  // namespace perp
