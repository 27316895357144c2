#include "core/index.hpp"
#include "instant/pair_side.hpp"
#include "instant/scales.hpp"
#include "perp/instant/derivatives.hpp"

namespace perp {
namespace {

using Matrix6 = Eigen::Matrix<double, 6, 6>;
using Columns = ContactDerivative::Columns;

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

/// Slopes of a function of the whole state by the motion and by the velocity of one body, R rows.
template <int R>
struct StateSlopes {
  Eigen::Matrix<double, R, 6> xi = Eigen::Matrix<double, R, 6>::Zero(), nu = xi;
  bool none() const { return xi.isZero(0) && nu.isZero(0); }
};

/// By central differences over a millionth of the system's length, of a radian, and of its speeds: truncation is 1e-12 of a function that
/// bends over them, rounding 1e-10.
template <int R, class Value>
StateSlopes<R> state_slopes(const Model& model, const State& x, const Scales& scales, const Body& body,
                            const Value& value) {
  constexpr double part = 1e-6;
  const double speed =
      scales.speed > 0 ? scales.speed : scales.length;  // where nothing moves or falls: in a second
  const int linear = body.kind == BodyKind::Planar ? 2 : body.kind == BodyKind::Generalized ? 0 : 3;
  StateSlopes<R> slopes;
  Vector unit = Vector::Zero(model.nv());
  for (int i = 0; i < body.nv; ++i) {
    const double step = i < linear ? part * scales.length : part;
    const double rate = body.kind == BodyKind::Generalized ? part
                        : i < linear                       ? part * speed
                                                           : part * speed / scales.length;
    State before = x, after = x;
    unit[body.v0 + i] = 1;
    move(model, unit, -step, before.q);
    move(model, unit, step, after.q);
    unit[body.v0 + i] = 0;
    slopes.xi.col(i).array() = (value(after) - value(before)) / (2 * step);
    before.q = after.q = x.q;
    before.nu[body.v0 + i] -= rate;
    after.nu[body.v0 + i] += rate;
    slopes.nu.col(i).array() = (value(after) - value(before)) / (2 * rate);
  }
  return slopes;
}

void differentiate_force(const Model& model, const BodyForce& load, const State& x, const Scales& scales,
                         std::vector<LoadDerivative>& out) {
  const Body& body = model.body(load.body);
  if (body.nv == 0) return;
  const auto value = [&](const State& y) {
    const Wrench wrench = load.wrench(model, y);
    Eigen::Matrix<double, 6, 1> f;
    f << wrench.force, wrench.moment;
    return Eigen::Array<double, 6, 1>(twist_of(body, model.pose(y, load.body).R()).transpose() * f);
  };
  for (std::size_t j = 0; j < model.bodies().size(); ++j) {
    if (model.bodies()[j].nv == 0) continue;
    const StateSlopes<6> slopes = state_slopes<6>(model, x, scales, model.bodies()[j], value);
    if (!slopes.none()) out.push_back({load.body.index, static_cast<int>(j), slopes.xi, slopes.nu});
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
void differentiate_motor(const Model& model, const JointMotor& motor, const State& x, const Scales& scales,
                         const Instant& s, std::vector<LoadDerivative>& out) {
  const JointRowInstant& c = s.coordinate(motor.joint, motor.coordinate);
  const auto effort = [&](const State& y) {
    return motor.effort(model, y, model.coordinate(y, motor.joint, motor.coordinate),
                        model.coordinate_rate(y, motor.joint, motor.coordinate));
  };
  differentiate_effort(model, s, c, effort(x), 0, 0, out);
  for (std::size_t j = 0; j < model.bodies().size(); ++j) {
    if (model.bodies()[j].nv == 0) continue;
    const StateSlopes<1> slopes = state_slopes<1>(model, x, scales, model.bodies()[j], effort);
    if (slopes.none()) continue;
    const int column = static_cast<int>(j);
    if (c.W.na > 0) out.push_back({c.W.a, column, c.W.A * slopes.xi, c.W.A * slopes.nu});
    if (c.W.nb > 0) out.push_back({c.W.b, column, c.W.B * slopes.xi, c.W.B * slopes.nu});
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
  Scales scales;
  if (!model.forces().empty() || !model.motors().empty()) scales = scales_of(model, x, instant);
  for (const Spring& spring : model.springs()) differentiate_spring(model, spring, instant, out);
  for (const BodyForce& load : model.forces()) differentiate_force(model, load, x, scales, out);
  for (const JointSpring& spring : model.joint_springs()) {
    const JointRowInstant& c = instant.coordinate(spring.joint, spring.coordinate);
    const double effort = -spring.stiffness * (c.psi_b - spring.rest) - spring.damping * c.velocity(x.nu);
    differentiate_effort(model, instant, c, effort, -spring.stiffness, -spring.damping, out);
  }
  for (const JointMotor& motor : model.motors()) differentiate_motor(model, motor, x, scales, instant, out);
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
