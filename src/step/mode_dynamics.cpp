#include "step/mode_dynamics.hpp"

#include <algorithm>
#include <cmath>
#include <Eigen/QR>

#include "instant/compliance.hpp"

namespace perp {
namespace {

std::size_t at(Eigen::Index i) { return static_cast<std::size_t>(i); }

// times the error of a velocity [-]
constexpr double uncertain = 300;  // its direction is known to a few thousandths
constexpr double unknown = 30;  // to a few hundredths: friction that turns with it would follow what is noise

/// u_f in world axes.
Vector3 tangential(const ContactInstant& c, const State& x) {
  const Vector3 u = c.velocity(x.nu);
  Vector3 u_f = Vector3::Zero();
  for (int t = 1; t <= c.tangents; ++t) u_f += u[t] * c.frame.col(t);
  return u_f;
}

}  // namespace

std::string ModeDynamics::begin(const State& x, const Modes& modes, double small_speed) {
  modes_ = modes;
  small_speed_ = small_speed;
  const std::size_t n = modes.contacts.size();
  direction_.assign(n, Vector3::Zero());
  speed_.assign(n, 0);
  fastest_.assign(n, 0);
  straight_.assign(n, 0);
  from_rest_.assign(n, 0);
  for (std::size_t i = 0; i < n; ++i) direction_[i] = modes.contacts[i].direction;
  if (!rows(x)) return s_.fault.empty() ? "a closed contact's gap is not there any more" : s_.fault;
  for (std::size_t i = 0; i < n; ++i) {  // the modes' directions are those of their start
    const Vector3 u_f = tangential(s_.contacts[at(asked_[i])], x);
    if (!modes.contacts[i].slides) continue;
    if (u_f.norm() > small_speed)
      direction_[i] = u_f.normalized();
    else
      from_rest_[i] = 1;
  }
  arrange();
  begin_step(x);
  assemble(x);
  find_basis();
  return "";
}

void ModeDynamics::arrange() {
  all_.arrange(rows_);
  std::vector<char> on(static_cast<std::size_t>(rows_.size()), 0);
  for (const int i : position_rows_) on[at(i)] = 1;
  positions_.arrange(rows_, std::move(on));
}

/// How rows repeat each other, and forces that are the rule's. Bodies count as of 1 kg.
void ModeDynamics::find_basis() {
  constexpr double dependent = 1e-11;  // eigenvalue of rows of length 1 a row: directions 3e-6 apart are one
  rows_.respond(model_, s_, false, Y_);
  for (std::size_t k = 0; k < Y_.size(); ++k)
    for (int side = 0; side < 2; ++side) {
      const Body& b = model_.bodies()[at(rows_.groups()[k].body[side])];
      if (b.nv > 0 && b.kind != BodyKind::Generalized) Y_[k][at(side)] *= b.mass;
    }
  redundant_ = false;
  for (RowFactors* factors : {&all_, &positions_}) {
    factors->find_dependent(rows_, Y_, dependent);
    for (RowFactors::Part& part : factors->parts()) {
      if (part.Z.cols() == 0) continue;
      // an orthonormal basis of what is across C Z
      const Matrix CZ = compliance_(part.rows).asDiagonal() * part.Z;
      const Matrix Q = Eigen::HouseholderQR<Matrix>(CZ).householderQ();
      part.V = Q.rightCols(part.Z.rows() - part.Z.cols());
      redundant_ = redundant_ || factors == &all_;
    }
  }
}

/// Whether the rows that repeated each other at find_basis() still do so in the same shares.
bool ModeDynamics::repeats() {
  constexpr double same = 1e-12;  // of the rows
  for (const RowFactors::Part& part : all_.parts()) {
    double squares = 0, miss = 0;
    for (const int k : part.groups)
      for (const RowGroup::Block& R : rows_.groups()[at(k)].R) squares += R.squaredNorm();
    for (Eigen::Index j = 0; j < part.Z.cols(); ++j) {
      b_.setZero(rows_.size());
      b_(part.rows) = part.Z.col(j);
      scratch_.setZero(model_.nv());
      rows_.add(false, b_, scratch_);
      miss += scratch_.squaredNorm();
    }
    if (std::sqrt(miss) > same * std::sqrt(squares) * part.Z.norm()) return false;
  }
  return true;
}

Matrix ModeDynamics::basis_of(const RowFactors& factors) const {
  const bool any = std::any_of(factors.parts().begin(), factors.parts().end(),
                               [](const RowFactors::Part& part) { return part.V.size() > 0; });
  if (!any) return {};
  Matrix V = Matrix::Zero(rows_.size(), rows_.size());
  Eigen::Index column = 0;
  for (const RowFactors::Part& part : factors.parts()) {
    const auto n = static_cast<Eigen::Index>(part.rows.size());
    const Matrix own = part.V.size() > 0 ? part.V : Matrix(Matrix::Identity(n, n));
    for (Eigen::Index i = 0; i < n; ++i) V.row(part.rows[at(i)]).segment(column, own.cols()) = own.row(i);
    column += own.cols();
  }
  return V.leftCols(column);
}

Matrix ModeDynamics::basis() const { return basis_of(all_); }

Matrix ModeDynamics::position_basis() const {
  const Matrix V = basis_of(positions_);
  return V.size() > 0 ? Matrix(V(position_rows_, Eigen::all)) : V;
}

void ModeDynamics::begin_step(const State& x) {
  constexpr double stopped = 1e-7;  // of the largest speed: what direction it then has changes nothing [-]
  for (std::size_t i = 0; i < modes_.contacts.size(); ++i) {
    if (!modes_.contacts[i].slides) continue;
    const ContactInstant& c = s_.contacts[at(asked_[i])];
    if (c.tangents == 0) continue;
    if (c.tangents == 1) {
      direction_[i] = (c.frame.col(1).dot(direction_[i]) > 0 ? 1 : -1) * c.frame.col(1);
      continue;
    }
    const Vector3 u_f = tangential(c, x);
    const double speed = u_f.norm();
    fastest_[i] = std::max(fastest_[i], speed);
    straight_[i] = speed < speed_[i] && speed < std::max(stopped * fastest_[i], uncertain * speed_error);
    speed_[i] = speed;
    if (from_rest_[i] != 0 ? speed > slow() : speed > small_speed_ && u_f.dot(direction_[i]) > 0)
      direction_[i] = u_f / speed;
    if (speed > slow()) from_rest_[i] = 0;
  }
  // of joints alone the motion does not depend on which of their forces are taken, and a loop turns away from those of its start
  if (redundant_ && modes_.contacts.empty()) find_basis();
}

/// What begins to slide keeps its direction up to this speed.
double ModeDynamics::slow() const { return std::max(small_speed_, unknown * speed_error); }

double ModeDynamics::sliding_speed(const State& x, std::size_t i) const {
  const ContactInstant& c = s_.contacts[at(asked_[i])];
  const Vector3 u_f = tangential(c, x);
  return c.tangents == 2 && from_rest_[i] != 0 ? u_f.norm() : u_f.dot(direction_[i]);
}

double ModeDynamics::sliding_acceleration(std::size_t i) const {
  const ContactInstant& c = s_.contacts[at(asked_[i])];
  const Vector3 a = c.W.velocity(nu_dot) + biases_.contacts[at(asked_[i])];
  double along = 0;
  for (int t = 1; t <= c.tangents; ++t) along += a[t] * c.frame.col(t).dot(direction_[i]);
  return along;
}

double ModeDynamics::joint_acceleration(std::size_t i) const {
  return s_.joint_frictions[i].W.velocity(nu_dot)[0] + biases_.joint_frictions[i];
}

bool ModeDynamics::as_good_as_stopped(const State& x, std::size_t i) const {
  return straight_[i] != 0 || tangential(s_.contacts[at(asked_[i])], x).norm() <= uncertain * speed_error;
}

Vector3 ModeDynamics::sliding_direction(const State& x, std::size_t i) const {
  const ContactInstant& c = s_.contacts[at(asked_[i])];
  return friction_direction(c, i, c.velocity(x.nu));
}

/// The direction of u_f, kept as it was at the step's start past the point where u_f goes through zero: so that the right-hand
/// side is smooth there, and what slides straight does so to the last bit.
Vector3 ModeDynamics::friction_direction(const ContactInstant& c, std::size_t i, const Vector3& u) const {
  if (c.tangents == 1) return (c.frame.col(1).dot(direction_[i]) > 0 ? 1 : -1) * c.frame.col(1);
  if (straight_[i] != 0) return direction_[i];
  constexpr double straight = 1e-11;  // a turn of less than this in the step is rounding [-]
  const Vector3 u_f = u[1] * c.frame.col(1) + u[2] * c.frame.col(2);
  const double along = u_f.dot(direction_[i]), size = u_f.norm();
  if (size <= (from_rest_[i] != 0 ? slow() : small_speed_) ||
      (u_f - along * direction_[i]).norm() <= straight * std::max(size, speed_[i]))
    return direction_[i];
  return (along >= 0 || from_rest_[i] != 0 ? 1 : -1) / size * u_f;
}

bool ModeDynamics::rows(const State& x) {
  perp::evaluate(model_, x, s_);
  if (!s_.fault.empty()) return false;
  asked_.clear();
  for (const ClosedContact& c : modes_.contacts) {
    asked_.push_back(s_.contact_of_point[at(c.point)]);
    if (asked_.back() < 0) return false;
  }
  assemble(x);
  return true;
}

void ModeDynamics::assemble(const State& x) {
  int m = static_cast<int>(s_.joint_rows.size());
  for (std::size_t i = 0; i < asked_.size(); ++i)
    m += 1 + (modes_.contacts[i].slides ? 0 : s_.contacts[at(asked_[i])].tangents);
  for (const int sign : modes_.joints) m += sign == 0 ? 1 : 0;
  rows_.start();
  compliance_.resize(m);
  velocity_.resize(m);
  gap_.setZero(m);
  load_ = s_.k;
  position_rows_.clear();
  int row = 0;
  for (const JointRowInstant& joint : s_.joint_rows) {
    rows_.add(joint.W, 0);
    velocity_[row] = joint.velocity(x.nu);
    compliance_[row] = compliance_of(model_, joint);
    gap_[row] = joint.psi_b;
    position_rows_.push_back(row++);
  }
  for (std::size_t i = 0; i < asked_.size(); ++i) {
    const ContactInstant& c = s_.contacts[at(asked_[i])];
    const Vector3 u = c.velocity(x.nu);
    const int rows = 1 + (modes_.contacts[i].slides ? 0 : c.tangents);
    for (int t = 0; t < rows; ++t) {
      rows_.add(c.W, t);
      velocity_[row + t] = u[t];
      compliance_[row + t] = compliance_of(model_, c);
    }
    gap_[row] = c.psi_n;
    position_rows_.push_back(row);
    if (modes_.contacts[i].slides && c.tangents > 0) {
      const Vector3 d = friction_direction(c, i, u);
      for (int t = 1; t <= c.tangents; ++t) rows_.tie(c.W, t, -c.mu * c.frame.col(t).dot(d));
    }
    row += rows;
  }
  for (std::size_t i = 0; i < modes_.joints.size(); ++i) {
    const JointRowInstant& joint = s_.joint_frictions[i];
    if (modes_.joints[i] != 0) {
      joint.W.add_impulse(WrenchMap<1>::Columns(-modes_.joints[i] * joint.friction), load_);
      continue;
    }
    rows_.add(joint.W, 0);
    compliance_[row] = compliance_of(model_, joint);
    velocity_[row++] = joint.velocity(x.nu);
  }
  rows_.finish();
}

bool ModeDynamics::evaluate(const State& x) {
  ++evaluations;
  if (!x.q.allFinite() || !x.nu.allFinite() || !rows(x)) return false;
  biases_.evaluate(model_, x, s_, asked_);
  const int m = row_count();
  solve_mass(model_, s_, load_, free_);
  if (m > 0) {
    bias_.resize(m);
    int row = 0;
    for (const double b : biases_.joint_rows) bias_[row++] = b;
    for (std::size_t i = 0; i < asked_.size(); ++i) {
      const int rows = 1 + (modes_.contacts[i].slides ? 0 : s_.contacts[at(asked_[i])].tangents);
      bias_.segment(row, rows) = biases_.contacts[at(asked_[i])].head(rows);
      row += rows;
    }
    for (std::size_t i = 0; i < modes_.joints.size(); ++i)
      if (modes_.joints[i] == 0) bias_[row++] = biases_.joint_frictions[i];
    if (stabilise > 0) {
      bias_ += stabilise * velocity_;
      for (const int i : position_rows_)
        bias_[i] += stabilise * velocity_[i] + stabilise * stabilise * gap_[i];
    }
    if (redundant_ && !modes_.contacts.empty() && !repeats()) find_basis();  // rows turn
    rows_.respond(model_, s_, true, Y_);
    rows_.velocity(free_, b_);
    b_ = -(b_ + bias_);
    all_.factor(rows_, Y_);
    all_.solve(rows_, Y_, b_, c_);
    if (!c_.allFinite()) return false;
    rows_.add_response(Y_, c_, free_);
  } else {
    c_.resize(0);
  }
  nu_dot = free_;

  force.resize(asked_.size());
  int row = static_cast<int>(s_.joint_rows.size());
  for (std::size_t i = 0; i < asked_.size(); ++i) {
    const ContactInstant& c = s_.contacts[at(asked_[i])];
    force[i].setZero();
    if (modes_.contacts[i].slides && c.tangents > 0) {
      const double c_n = c_[row++];
      const Vector3 d = friction_direction(c, i, c.velocity(x.nu));
      force[i].x() = c_n;
      for (int t = 1; t <= c.tangents; ++t) force[i][t] = -c.mu * c_n * c.frame.col(t).dot(d);
    } else {
      force[i].head(1 + c.tangents) = c_.segment(row, 1 + c.tangents);
      row += 1 + c.tangents;
    }
  }
  joint_force.resize(static_cast<Eigen::Index>(modes_.joints.size()));
  for (std::size_t i = 0; i < modes_.joints.size(); ++i)
    joint_force[static_cast<Eigen::Index>(i)] =
        modes_.joints[i] == 0 ? c_[row++] : -modes_.joints[i] * s_.joint_frictions[i].friction;
  return true;
}

void ModeDynamics::kick(ModeKick& out) const {
  solve_mass(model_, s_, load_, out.free);
  rows_.respond(model_, s_, true, out.response);
}

bool ModeDynamics::meet(const ModeKick& from, State& x, Vector& z) {
  if (row_count() == 0) {
    z.resize(0);
    return true;
  }
  all_.factor(rows_, from.response);
  b_ = -velocity_;
  all_.solve(rows_, from.response, b_, z);
  rows_.add_response(from.response, z, x.nu);
  return x.nu.allFinite();
}

void ModeDynamics::turn(const State& x) {
  evaluate_loads(model_, x, s_);
  assemble(x);
}

double ModeDynamics::project(State& x) {
  for (const Body& b : model_.bodies())
    if (b.kind == BodyKind::Spatial) x.q.segment<4>(b.q0 + 3).normalize();
  const auto violation = [&] {
    double worst = 0;
    for (const int i : position_rows_) worst = std::max(worst, std::abs(gap_[i]));
    return worst;
  };
  if (!rows(x)) return infinity;
  if (row_count() == 0) return 0;
  double left = violation();
  Vector c;
  for (int iteration = 0; iteration < 8 && left > 0; ++iteration) {
    rows_.respond(model_, s_, false, Y_);
    positions_.solve_least(rows_, Y_, gap_, c);
    scratch_.setZero(model_.nv());
    rows_.add_response(Y_, -c, scratch_);
    const Vector before = x.q;
    move(model_, scratch_, 1, x.q);
    if (!rows(x)) return infinity;
    const double now = violation();
    if (!(now < left)) {  // rounding
      x.q = before;
      (void)rows(x);
      break;
    }
    left = now;
  }
  for (int pass = 0; pass < 2; ++pass) {
    rows_.respond(model_, s_, false, Y_);
    all_.solve_least(rows_, Y_, velocity_, c);
    rows_.add_response(Y_, -c, x.nu);
    assemble(x);
  }
  return left;
}

void ModeDynamics::kinematic_map(const State& x, Vector& q_dot) const {
  q_dot.resize(x.q.size());
  for (const Body& b : model_.bodies()) {
    if (b.nv == 0) continue;
    const int n = b.kind == BodyKind::Generalized ? b.nq : 3;
    q_dot.segment(b.q0, n) = x.nu.segment(b.v0, n);
    if (b.kind != BodyKind::Spatial) continue;
    const auto q = x.q.segment<4>(b.q0 + 3);
    const auto w = x.nu.segment<3>(b.v0 + 3);
    q_dot.segment<4>(b.q0 + 3) << 0.5 * (-q[1] * w[0] - q[2] * w[1] - q[3] * w[2]),
        0.5 * (q[0] * w[0] + q[2] * w[2] - q[3] * w[1]), 0.5 * (q[0] * w[1] + q[3] * w[0] - q[1] * w[2]),
        0.5 * (q[0] * w[2] + q[1] * w[1] - q[2] * w[0]);
  }
}

}  // namespace perp
