#include "perp/instant/derivatives.hpp"

#include <cmath>
#include <numeric>

namespace perp {
namespace {

using Matrix6 = Eigen::Matrix<double, 6, 6>;
using Columns = ContactDerivative::Columns;  // 3 rows; columns (v_a, w_a, v_b, w_b), world axes

std::size_t at(int i) { return static_cast<std::size_t>(i); }

/// World twist of a body for each of its velocities.
Matrix6 twist_of(const Body& body, const Matrix3& R) {
  Matrix6 T = Matrix6::Zero();
  switch (body.kind) {
    case BodyKind::Spatial:
      T.topLeftCorner<3, 3>().setIdentity();
      T.bottomRightCorner<3, 3>() = R;
      break;
    case BodyKind::Planar:
      T(0, 0) = T(1, 1) = T(5, 2) = 1;
      break;
    case BodyKind::Particle:
      T.topLeftCorner<3, 3>().setIdentity();
      break;
    default:
      break;
  }
  return T;
}

/// One of the two bodies of a pair.
struct Side {
  const Body& body;
  const Twist& V;
  Vector3 r;    // from its origin to the point
  double sign;  // -1 for a, +1 for b
  int v, w;     // its first columns of velocity and turning
  Matrix6 T;
};

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
    out.setZero();
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

Side side_of(const Model& model, const Instant& s, int body, double sign, const Vector3& point) {
  const Body& b = model.bodies()[at(body)];
  const int first = sign < 0 ? 0 : 6;
  return {b, s.V[at(body)], point - s.X[at(body)].p, sign, first, first + 3, twist_of(b, s.R[at(body)])};
}

/// d(t) and d(o) from d(n), t the projection of a fixed `wish` across n (in the plane t = n x z).
template <class Derived>
void turn_frame(const ContactInstant& c, const Eigen::MatrixBase<Derived>& dn, Derived& dt, Derived& d_o) {
  const Vector3 n = c.frame.col(0), t = c.frame.col(1);
  if (c.tangents == 1) {
    dt = -skew(Vector3::UnitZ()) * dn;
  } else {
    const double along = n.dot(c.wish);
    const Matrix3 across = (Matrix3::Identity() - t * t.transpose()) / (c.wish - along * n).norm();
    dt = -across * (along * Matrix3::Identity() + n * c.wish.transpose()) * dn;
  }
  d_o = -skew(t) * dn + skew(n) * dt;
}

/// s.motion.surface's derivatives, by central differences: it is a velocity field that its maker gave as values alone.
struct SurfaceSlope {
  Vector3 value, by_t;
  Matrix3 by_point;
};
SurfaceSlope surface_slope(const PrescribedMotion& motion, double t, const Vector3& point) {
  constexpr double step = 1e-5;  // [s], [m]
  SurfaceSlope slope{motion.surface(t, point),
                     (motion.surface(t + step, point) - motion.surface(t - step, point)) / (2 * step),
                     {}};
  for (int k = 0; k < 3; ++k) {
    const Vector3 d = step * Vector3::Unit(k);
    slope.by_point.col(k) = (motion.surface(t, point + d) - motion.surface(t, point - d)) / (2 * step);
  }
  return slope;
}

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

template <int C>
Eigen::Matrix<double, 12, 1> velocities(const WrenchMap<C>& W, const Vector& nu) {
  Eigen::Matrix<double, 12, 1> local = Eigen::Matrix<double, 12, 1>::Zero();
  for (int i = 0; i < W.na; ++i) local[i] = nu[W.va + i];
  for (int i = 0; i < W.nb; ++i) local[6 + i] = nu[W.vb + i];
  return local;
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

}  // namespace

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
        const SurfaceSlope slope = surface_slope(s.body.motion, x.t, c.position);
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

Vector3 acceleration_bias(const Model& model, const State& x, const Instant& instant, const ContactInstant& c,
                          const ContactDerivative& geometry) {
  if (model.contacts()[at(c.contact)].own) return own_bias(model, x, c);
  PairDerivative<3> d;
  differentiate(model, x, instant, c, geometry, Vector3::Zero(), d);
  return d.velocity * velocities(c.W, x.nu) + d.velocity_t;
}

double acceleration_bias(const Model& model, const State& x, const Instant& instant,
                         const JointRowInstant& row) {
  PairDerivative<1> d;
  differentiate(model, instant, row, 0, d);
  return (d.velocity * velocities(row.W, x.nu) + d.velocity_t)[0];
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

namespace {

void differentiate_spring(const Model& model, const Spring& spring, const Instant& s,
                          std::vector<LoadDerivative>& out) {
  const std::size_t a = at(spring.a.index), b = at(spring.b.index);
  const Vector3 x_a = s.X[a] * spring.point_a, x_b = s.X[b] * spring.point_b;
  const Side sides[2] = {side_of(model, s, spring.a.index, -1, x_a),
                         side_of(model, s, spring.b.index, +1, x_b)};
  // of d = x_b - x_a and of its rate, by the motion (xi) and by the velocities (nu)
  Columns d_xi = Columns::Zero(), rate_xi = Columns::Zero();
  for (const Side& side : sides) {
    d_xi.middleCols<3>(side.v) = side.sign * Matrix3::Identity();
    d_xi.middleCols<3>(side.w) = -side.sign * skew(side.r);
    if (side.body.nv > 0)  // w x (dtheta x r) + (dtheta x w) x r
      rate_xi.middleCols<3>(side.w) =
          -side.sign * (skew(side.V.w) * skew(side.r) - skew(side.r) * skew(side.V.w));
  }
  const Vector3 d = x_b - x_a, rate = sides[1].V.at(sides[1].r) - sides[0].V.at(sides[0].r);
  const double l = d.norm();
  Vector3 F = -spring.stiffness * d;  // on B
  Columns F_xi = -spring.stiffness * d_xi, F_nu = Columns::Zero();
  if (l > 0) {
    const Vector3 e = d / l;
    const Columns e_xi = (Matrix3::Identity() - e * e.transpose()) / l * d_xi;
    const double pull = spring.stiffness * spring.length - spring.damping * e.dot(rate);
    F += pull * e;
    F_xi += pull * e_xi - spring.damping * e * (rate.transpose() * e_xi + e.transpose() * rate_xi);
    F_nu = -spring.damping * e * (e.transpose() * d_xi);  // the rate's slope by the twists is that of d
  }
  for (const Side& row : sides) {
    if (row.body.nv == 0) continue;
    Eigen::Matrix<double, 6, 12> xi, nu;
    xi << F_xi, skew(row.r) * F_xi;
    nu << F_nu, skew(row.r) * F_nu;
    xi.bottomRows<3>().middleCols<3>(row.w) += skew(F) * skew(row.r) + skew(row.r.cross(F));
    for (const Side& column : sides) {
      if (column.body.nv == 0) continue;
      out.push_back({&row == &sides[0] ? spring.a.index : spring.b.index,
                     &column == &sides[0] ? spring.a.index : spring.b.index,
                     row.T.transpose() * (row.sign * xi.middleCols<6>(column.v)) * column.T,
                     row.T.transpose() * (row.sign * nu.middleCols<6>(column.v)) * column.T});
    }
  }
}

void differentiate_force(const Model& model, const BodyForce& load, const State& x,
                         std::vector<LoadDerivative>& out) {
  constexpr double step = 1e-6;  // [m, rad], [m/s, rad/s]
  const Body& body = model.body(load.body);
  if (body.nv == 0) return;
  const auto value = [&](const State& y) {
    const Wrench wrench = load.wrench(model, y);
    Eigen::Matrix<double, 6, 1> f;
    f << wrench.force, wrench.moment;
    return Eigen::Matrix<double, 6, 1>(twist_of(body, model.pose(y, load.body).R()).transpose() * f);
  };
  Vector unit = Vector::Zero(model.nv());
  for (std::size_t j = 0; j < model.bodies().size(); ++j) {
    const Body& other = model.bodies()[j];
    if (other.nv == 0) continue;
    LoadDerivative block{load.body.index, static_cast<int>(j), Matrix6::Zero(), Matrix6::Zero()};
    for (int i = 0; i < other.nv; ++i) {
      State before = x, after = x;
      unit[other.v0 + i] = 1;
      move(model, unit, -step, before.q);
      move(model, unit, step, after.q);
      unit[other.v0 + i] = 0;
      block.xi.col(i) = (value(after) - value(before)) / (2 * step);
      before.q = after.q = x.q;
      before.nu[other.v0 + i] -= step;
      after.nu[other.v0 + i] += step;
      block.nu.col(i) = (value(after) - value(before)) / (2 * step);
    }
    if (!block.xi.isZero(0) || !block.nu.isZero(0)) out.push_back(block);
  }
}

/// By columns, value(x + step along coordinate i) - value(x - step ...), divided: of a function of a generalized body's q or nu.
template <class Value>
Matrix6 own_differences(const Vector& x, const Value& value) {
  constexpr double step = 1e-6;  // [the coordinates' own units]
  Matrix6 slopes = Matrix6::Zero();
  for (Eigen::Index i = 0; i < x.size(); ++i) {
    const Vector d = step * Vector::Unit(x.size(), i);
    slopes.col(i).head(x.size()) = (value(x + d) - value(x - d)) / (2 * step);
  }
  return slopes;
}

/// W f of a coordinate's row, f = f(coordinate, rate) with these slopes.
void differentiate_effort(const Model& model, const Instant& s, const JointRowInstant& c, double f,
                          double by_coordinate, double by_rate, std::vector<LoadDerivative>& out) {
  PairDerivative<1> d;
  differentiate(model, s, c, f, d);
  Eigen::Matrix<double, 12, 1> W;
  W << c.W.A, c.W.B;
  const Eigen::Matrix<double, 12, 12> xi =
      d.force + W * (by_coordinate * W.transpose() + by_rate * d.velocity);
  const Eigen::Matrix<double, 12, 12> nu = by_rate * W * W.transpose();
  const int bodies[] = {c.W.a, c.W.b}, sizes[] = {c.W.na, c.W.nb};
  for (int i = 0; i < 2; ++i)
    for (int j = 0; j < 2; ++j)
      if (sizes[i] > 0 && sizes[j] > 0)
        out.push_back({bodies[i], bodies[j], xi.block<6, 6>(6 * i, 6 * j), nu.block<6, 6>(6 * i, 6 * j)});
}

/// W f with f a function of the whole state: its own slopes by central differences.
void differentiate_motor(const Model& model, const JointMotor& motor, const State& x, const Instant& s,
                         std::vector<LoadDerivative>& out) {
  constexpr double step = 1e-6;  // [m, rad], [m/s, rad/s]
  const JointRowInstant& c = s.coordinate(motor.joint, motor.coordinate);
  const auto effort = [&](const State& y) {
    return motor.effort(model, y, model.coordinate(y, motor.joint, motor.coordinate),
                        model.coordinate_rate(y, motor.joint, motor.coordinate));
  };
  differentiate_effort(model, s, c, effort(x), 0, 0, out);
  Vector unit = Vector::Zero(model.nv());
  for (std::size_t j = 0; j < model.bodies().size(); ++j) {
    const Body& other = model.bodies()[j];
    if (other.nv == 0) continue;
    Eigen::Matrix<double, 1, 6> xi = Eigen::Matrix<double, 1, 6>::Zero(), nu = xi;
    for (int i = 0; i < other.nv; ++i) {
      State before = x, after = x;
      unit[other.v0 + i] = 1;
      move(model, unit, -step, before.q);
      move(model, unit, step, after.q);
      unit[other.v0 + i] = 0;
      xi[i] = (effort(after) - effort(before)) / (2 * step);
      before.q = after.q = x.q;
      before.nu[other.v0 + i] -= step;
      after.nu[other.v0 + i] += step;
      nu[i] = (effort(after) - effort(before)) / (2 * step);
    }
    if (xi.isZero(0) && nu.isZero(0)) continue;
    if (c.W.na > 0) out.push_back({c.W.a, static_cast<int>(j), c.W.A * xi, c.W.A * nu});
    if (c.W.nb > 0) out.push_back({c.W.b, static_cast<int>(j), c.W.B * xi, c.W.B * nu});
  }
}

}  // namespace

void differentiate_loads(const Model& model, const State& x, const Instant& instant,
                         std::vector<LoadDerivative>& out) {
  out.clear();
  for (std::size_t i = 0; i < model.bodies().size(); ++i) {
    const Body& body = model.bodies()[i];
    if (body.kind == BodyKind::Generalized) {
      const Vector q = x.q.segment(body.q0, body.nq), nu = x.nu.segment(body.v0, body.nv);
      const auto& force = body.system.force;
      out.push_back({static_cast<int>(i), static_cast<int>(i),
                     own_differences(q, [&](const Vector& y) { return force(y, nu, x.t); }),
                     own_differences(nu, [&](const Vector& y) { return force(q, y, x.t); })});
    }
    if (body.kind != BodyKind::Spatial) continue;  // -w x J w
    const Vector3 w = x.nu.segment<3>(body.v0 + 3);
    LoadDerivative block{static_cast<int>(i), static_cast<int>(i), Matrix6::Zero(), Matrix6::Zero(), true};
    block.nu.bottomRightCorner<3, 3>() = skew(body.J * w) - skew(w) * body.J;
    out.push_back(block);
  }
  for (const Spring& spring : model.springs()) differentiate_spring(model, spring, instant, out);
  for (const BodyForce& load : model.forces()) differentiate_force(model, load, x, out);
  for (const JointSpring& spring : model.joint_springs()) {
    const JointRowInstant& c = instant.coordinate(spring.joint, spring.coordinate);
    const double effort = -spring.stiffness * (c.psi_b - spring.rest) - spring.damping * c.velocity(x.nu);
    differentiate_effort(model, instant, c, effort, -spring.stiffness, -spring.damping, out);
  }
  for (const JointMotor& motor : model.motors()) differentiate_motor(model, motor, x, instant, out);
}

void differentiate_mass(const Model& model, const State& x, const Vector& y,
                        std::vector<LoadDerivative>& out) {
  out.clear();
  for (std::size_t i = 0; i < model.bodies().size(); ++i) {
    const Body& body = model.bodies()[i];
    if (body.kind != BodyKind::Generalized) continue;
    const Vector q = x.q.segment(body.q0, body.nq), part = y.segment(body.v0, body.nv);
    const auto momentum = [&](const Vector& at) -> Vector { return body.system.mass(at) * part; };
    out.push_back({static_cast<int>(i), static_cast<int>(i), own_differences(q, momentum), Matrix6::Zero()});
  }
}

}  // namespace perp
