#include "step/events/mode_dynamics.hpp"

#include <algorithm>
#include <cmath>
#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/QR>
#include <numeric>

#include "core/index.hpp"
#include "instant/compliance.hpp"

namespace perp {
namespace {

template <int C>
void fill_column(const WrenchMap<C>& W, int column, double factor, int target, Matrix& out) {
  for (int i = 0; i < W.na; ++i) out(W.va + i, target) += factor * W.A(i, column);
  for (int i = 0; i < W.nb; ++i) out(W.vb + i, target) += factor * W.B(i, column);
}

/// M^-1 of every column.
void solve_mass_columns(const Model& model, const Instant& s, const Matrix& F, Matrix& out) {
  out.resize(F.rows(), F.cols());
  for (Eigen::Index j = 0; j < F.cols(); ++j)
    for (int i = 0; i < static_cast<int>(model.bodies().size()); ++i) {
      const Body& body = model.bodies()[at(i)];
      if (body.nv > 0) solve_mass(model, s, i, F.col(j).data() + body.v0, out.col(j).data() + body.v0);
    }
}

/// z with N z = rhs, N symmetric positive semidefinite: that of least norm after scaling the diagonal to 1.
Vector solve_symmetric(const Matrix& N, const Vector& rhs) {
  const Matrix V = range_basis(N);
  if (V.size() == 0) return N.llt().solve(rhs);
  return V * (V.transpose() * N * V).llt().solve(V.transpose() * rhs);
}

}  // namespace

Matrix range_basis(const Matrix& N) {
  if (N.rows() == 0) return {};
  const Vector scale = N.diagonal().cwiseMax(1e-300).cwiseSqrt().cwiseInverse();
  const Matrix scaled = scale.asDiagonal() * N * scale.asDiagonal();
  const Eigen::LLT<Matrix> llt(scaled);
  // a pivot's square root tells whether rows repeat each other
  if (llt.info() == Eigen::Success && llt.matrixLLT().diagonal().minCoeff() > 1e-6) return {};
  const Eigen::SelfAdjointEigenSolver<Matrix> eigen(scaled);
  std::vector<Eigen::Index> kept;
  for (Eigen::Index i = 0; i < N.rows(); ++i)
    if (eigen.eigenvalues()[i] > 1e-11 * static_cast<double>(N.rows())) kept.push_back(i);
  return scale.asDiagonal() * Matrix(eigen.eigenvectors()(Eigen::all, kept));
}

std::string ModeDynamics::begin(const State& x, const Modes& modes, double small_speed) {
  modes_ = modes;
  small_speed_ = small_speed;
  V_.resize(0, 0);
  V_position_.resize(0, 0);
  const std::size_t n = modes.contacts.size();
  slips_.assign(n, {});
  rolls_.assign(n, {});
  for (std::size_t i = 0; i < n; ++i) {
    slips_[i].direction = modes.contacts[i].direction;
    rolls_[i].direction = modes.contacts[i].rolling;
  }
  if (!rows(x)) return s_.fault.empty() ? "a closed contact's gap is not there any more" : s_.fault;
  for (std::size_t i = 0; i < n; ++i)  // the modes' directions are those of their start
    for (const Moving what : {Moving::Slip, Moving::Roll}) {
      if (!moves(i, what)) continue;
      Sliding& sliding = (what == Moving::Slip ? slips_ : rolls_)[i];
      const Vector3 u_f = velocity_of(x, i, what);
      if (u_f.norm() > small_speed)
        sliding.direction = u_f.normalized();
      else
        sliding.from_rest = true;
    }
  begin_step(x);
  assemble(x);
  find_basis();
  return "";
}

/// Z with R Z = 0 of some rows; (rows, 0) if none repeats another. Bodies count as of 1 kg.
Matrix ModeDynamics::repeated(const std::vector<int>& rows, double threshold) const {
  const auto n = static_cast<Eigen::Index>(rows.size());
  Matrix R = R_(Eigen::all, rows), Y;
  solve_mass_columns(model_, s_, R, Y);
  for (const Body& b : model_.bodies())
    if (b.nv > 0 && b.kind != BodyKind::Generalized) Y.middleRows(b.v0, b.nv) *= b.mass;
  const Matrix N = R.transpose() * Y;
  const Vector scale = N.diagonal().cwiseMax(1e-300).cwiseSqrt().cwiseInverse();
  const Matrix scaled = scale.asDiagonal() * N * scale.asDiagonal();
  const Eigen::LLT<Matrix> llt(scaled);
  // a pivot's square root tells whether rows repeat each other
  if (n == 0 || (llt.info() == Eigen::Success && llt.matrixLLT().diagonal().minCoeff() > 1e-6))
    return Matrix(n, 0);
  const Eigen::SelfAdjointEigenSolver<Matrix> eigen(scaled);
  const Eigen::Index count = (eigen.eigenvalues().array() <= threshold * static_cast<double>(n)).count();
  return scale.asDiagonal() * Matrix(eigen.eigenvectors().leftCols(count));  // eigenvalues ascend
}

void ModeDynamics::find_basis() {
  constexpr double dependent = 1e-11;  // eigenvalue of rows of length 1 a row: directions 3e-6 apart are one
  // an orthonormal basis of what is across C Z
  const auto across = [&](const std::vector<int>& rows, const Matrix& Z) -> Matrix {
    if (Z.cols() == 0) return {};
    const Matrix CZ = compliance_(rows).asDiagonal() * Z;
    const Matrix Q = Eigen::HouseholderQR<Matrix>(CZ).householderQ();
    return Q.rightCols(Z.rows() - Z.cols());
  };
  std::vector<int> all(static_cast<std::size_t>(row_count()));
  std::iota(all.begin(), all.end(), 0);
  Z_ = repeated(all, dependent);
  V_ = across(all, Z_);
  V_position_ = across(position_rows_, repeated(position_rows_, dependent));
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
  for (std::size_t i = 0; i < asked_.size(); ++i) for_rows(i, [&](bool, int) { ++m; });
  for (const int sign : modes_.joints) m += sign == 0 ? 1 : 0;
  R_.setZero(model_.nv(), m);
  compliance_.resize(m);
  L_.setZero(model_.nv(), m);
  velocity_.resize(m);
  gap_.setZero(m);
  load_ = s_.k;
  position_rows_.clear();
  int row = 0;
  for (const JointRowInstant& joint : s_.joint_rows) {
    fill_column(joint.W, 0, 1, row, R_);
    L_.col(row) = R_.col(row);
    velocity_[row] = joint.velocity(x.nu);
    compliance_[row] = compliance_of(model_, joint);
    gap_[row] = joint.psi_b;
    position_rows_.push_back(row++);
  }
  for (std::size_t i = 0; i < asked_.size(); ++i) {
    const ContactInstant& c = contact(i);
    const MomentInstant* m_c = s_.moments_of(c);
    const Vector3 u = c.velocity(x.nu), omega = m_c == nullptr ? u : m_c->velocity(x.nu);
    const int normal = row;
    for_rows(i, [&](bool moments, int column) {
      fill_column(moments ? m_c->W : c.W, column, 1, row, R_);
      L_.col(row) = R_.col(row);
      velocity_[row] = (moments ? omega : u)[column];
      compliance_[row++] = moments ? moments_compliance_of(model_, c) : compliance_of(model_, c);
    });
    gap_[normal] = c.psi_n;
    position_rows_.push_back(normal);
    if ((!modes_.contacts[i].slides && !modes_.contacts[i].rolls) || c.tangents == 0) continue;
    if (m_c == nullptr) {
      const Vector3 d = friction_direction(c, i, Moving::Slip, tangential(c, u));
      for (int t = 1; t <= c.tangents; ++t) fill_column(c.W, t, -c.mu * c.frame.col(t).dot(d), normal, L_);
      continue;
    }
    const FrictionShare share = sliding_share(x, i);
    for (int t = 1; t <= c.tangents; ++t) fill_column(c.W, t, share.force[t - 1], normal, L_);
    for (int k = 0; k < 3; ++k) fill_column(m_c->W, k, share.moment[k], normal, L_);
  }
  for (std::size_t i = 0; i < modes_.joints.size(); ++i) {
    const JointRowInstant& joint = s_.joint_frictions[i];
    if (modes_.joints[i] != 0) {
      joint.W.add_impulse(WrenchMap<1>::Columns(-modes_.joints[i] * joint.friction), load_);
      continue;
    }
    fill_column(joint.W, 0, 1, row, R_);
    L_.col(row) = R_.col(row);
    compliance_[row] = compliance_of(model_, joint);
    velocity_[row++] = joint.velocity(x.nu);
  }
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
    for (std::size_t i = 0; i < asked_.size(); ++i)
      for_rows(i, [&](bool moments, int column) {
        bias_[row++] =
            (moments ? biases_.moments[at(contact(i).moments)] : biases_.contacts[at(asked_[i])])[column];
      });
    for (std::size_t i = 0; i < modes_.joints.size(); ++i)
      if (modes_.joints[i] == 0) bias_[row++] = biases_.joint_frictions[i];
    if (stabilise > 0) {
      bias_ += stabilise * velocity_;
      for (const int i : position_rows_)
        bias_[i] += stabilise * velocity_[i] + stabilise * stabilise * gap_[i];
    }
    solve_mass_columns(model_, s_, L_, Y_);
    N_.noalias() = R_.transpose() * Y_;
    b_ = bias_;
    b_.noalias() += R_.transpose() * free_;
    if (V_.size() > 0 && !modes_.contacts.empty()) {
      // rows turn: whether those that repeated each other do so in the same shares
      constexpr double same = 1e-12;  // of the rows
      if ((R_ * Z_).norm() > same * R_.norm() * Z_.norm()) find_basis();
    }
    if (V_.size() > 0) {
      const Matrix reduced = V_.transpose() * N_ * V_;
      lu_.compute(reduced);
      c_ = -(V_ * lu_.solve(V_.transpose() * b_));
    } else {
      lu_.compute(N_);
      c_ = lu_.solve(b_);
      c_ = -c_;
    }
    if (!c_.allFinite()) return false;
    free_.noalias() += Y_ * c_;
  } else {
    c_.resize(0);
  }
  nu_dot = free_;

  int row = static_cast<int>(s_.joint_rows.size());
  force.assign(asked_.size(), Vector3::Zero());
  moment.assign(s_.moments.empty() ? 0 : asked_.size(), Vector3::Zero());
  for (std::size_t i = 0; i < asked_.size(); ++i) {
    for_rows(i, [&](bool moments, int column) { (moments ? moment : force)[i][column] = c_[row++]; });
    if ((!modes_.contacts[i].slides && !modes_.contacts[i].rolls) || contact(i).tangents == 0) continue;
    const ContactInstant& c = contact(i);
    if (c.moments < 0) {
      const Vector3 d = sliding_direction(x, i);
      for (int t = 1; t <= c.tangents; ++t) force[i][t] = -c.mu * force[i].x() * c.frame.col(t).dot(d);
      continue;
    }
    const FrictionShare share = sliding_share(x, i);
    force[i].tail<2>() += force[i].x() * share.force;
    moment[i] += force[i].x() * share.moment;
  }
  joint_force.resize(static_cast<Eigen::Index>(modes_.joints.size()));
  for (std::size_t i = 0; i < modes_.joints.size(); ++i)
    joint_force[static_cast<Eigen::Index>(i)] =
        modes_.joints[i] == 0 ? c_[row++] : -modes_.joints[i] * s_.joint_frictions[i].friction;
  return true;
}

void ModeDynamics::kick(ModeKick& out) const {
  solve_mass(model_, s_, load_, out.free);
  solve_mass_columns(model_, s_, L_, out.response);
}

bool ModeDynamics::meet(const ModeKick& from, State& x, Vector& z) {
  if (row_count() == 0) {
    z.resize(0);
    return true;
  }
  N_.noalias() = R_.transpose() * from.response;
  if (V_.size() > 0) {
    lu_.compute(V_.transpose() * N_ * V_);
    z = -(V_ * lu_.solve(V_.transpose() * velocity_));
  } else {
    lu_.compute(N_);
    z = -lu_.solve(velocity_);
  }
  x.nu.noalias() += from.response * z;
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
  for (int iteration = 0; iteration < 8 && left > 0; ++iteration) {
    const Matrix R = R_(Eigen::all, position_rows_);
    solve_mass_columns(model_, s_, R, Y_);
    const Vector d = -(Y_ * solve_symmetric(R.transpose() * Y_, gap_(position_rows_)));
    const Vector before = x.q;
    move(model_, d, 1, x.q);
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
    solve_mass_columns(model_, s_, R_, Y_);
    x.nu -= Y_ * solve_symmetric(R_.transpose() * Y_, velocity_);
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
