#include "perp/instant/reduced_system.hpp"

#include <algorithm>
#include <Eigen/QR>

#include "core/index.hpp"
#include "instant/compliance.hpp"

namespace perp {
namespace {

/// Smallest Cholesky pivot of N, relative to its row, that is taken as full rank [-]; below it the rank is found.
constexpr double full_rank = 1e-6;
/// Singular values of N, its diagonal scaled to 1, below this count as zero [-]: those of W_b below its root, 3e-7.
constexpr double dependent = 1e-13;

/// Y = M^-1 W, block by block.
template <int C>
void solve_mass(const Model& model, const Instant& s, const WrenchMap<C>& W, WrenchMap<C>& Y) {
  Y = W;
  for (int c = 0; c < C; ++c) {
    if (W.na > 0) solve_mass(model, s, W.a, W.A.col(c).data(), Y.A.col(c).data());
    if (W.nb > 0) solve_mass(model, s, W.b, W.B.col(c).data(), Y.B.col(c).data());
  }
}

/// W^T Y over the bodies that both touch (the others' velocities do not matter to each other).
template <int C, int D>
Eigen::Matrix<double, C, D> couple(const WrenchMap<C>& W, const WrenchMap<D>& Y) {
  Eigen::Matrix<double, C, D> sum = Eigen::Matrix<double, C, D>::Zero();
  if (W.na > 0 && W.a == Y.a) sum.noalias() += W.A.transpose() * Y.A;
  if (W.na > 0 && W.a == Y.b) sum.noalias() += W.A.transpose() * Y.B;
  if (W.nb > 0 && W.b == Y.a) sum.noalias() += W.B.transpose() * Y.A;
  if (W.nb > 0 && W.b == Y.b) sum.noalias() += W.B.transpose() * Y.B;
  return sum;
}

}  // namespace

void ReducedSystem::find_parts(const Instant& instant, const Island& island) {
  const std::size_t contacts = island.contacts.size();
  offset_.resize(contacts);
  parts_.resize(std::max(contacts, parts_.size()));
  std::size_t count = 0;
  int rows = 0;
  const auto add = [&](int contact, bool moments, int size, const std::array<int, 3>& column) {
    if (count == parts_.size()) parts_.emplace_back();
    Part& part = parts_[count++];
    part.contact = contact;
    part.moments = moments;
    part.row = rows;
    part.count = size;
    part.column = column;
    rows += size;
  };
  for (std::size_t i = 0; i < contacts; ++i) {
    const ContactInstant& c = instant.contacts[at(island.contacts[i])];
    offset_[i] = rows;
    add(island.contacts[i], false, 1 + c.tangents, {0, 1, 2});
    const MomentInstant* m = instant.moments_of(c);
    if (m != nullptr && m->rows(c.tangents) > 0)
      add(island.contacts[i], true, m->rows(c.tangents), m->columns(c.tangents));
  }
  parts_.resize(count);
  frictions_ = rows;
}

void ReducedSystem::assemble(const Model& model, const Instant& instant, const Island& island,
                             const Vector& nu_free, const Vector& joint_bias) {
  const std::size_t frictions = island.joint_frictions.size();
  const auto friction = [&](std::size_t i) -> const JointRowInstant& {
    return instant.joint_frictions[at(island.joint_frictions[i])];
  };
  find_parts(instant, island);
  for (Part& part : parts_) solve_mass(model, instant, part.W(instant), part.Y);
  const int rows = frictions_ + static_cast<int>(frictions);
  friction_Y_.resize(frictions);
  for (std::size_t i = 0; i < frictions; ++i) solve_mass(model, instant, friction(i).W, friction_Y_[i]);

  W.resize(rows, rows);
  q.resize(rows);
  for (std::size_t i = 0; i < parts_.size(); ++i) {
    const Part& part = parts_[i];
    const ContactInstant& c = instant.contacts[at(part.contact)];
    const Vector3 u = part.moments ? instant.moments_of(c)->velocity(nu_free) : c.velocity(nu_free);
    for (int k = 0; k < part.count; ++k) q[part.row + k] = u[part.column[at(k)]];
    for (std::size_t j = 0; j <= i; ++j) {
      const Part& other = parts_[j];
      const int n = part.count, m = other.count;
      Matrix3 S = couple(part.W(instant), other.Y);
      if (part.moments || other.moments) S = S(part.column, other.column).eval();
      W.block(part.row, other.row, n, m) = S.topLeftCorner(n, m);
      if (j < i) W.block(other.row, part.row, m, n) = S.topLeftCorner(n, m).transpose();
    }
  }
  for (std::size_t i = 0; i < frictions; ++i) {
    const int row = frictions_ + static_cast<int>(i);
    q[row] = friction(i).velocity(nu_free);
    for (const Part& part : parts_) {
      const Eigen::RowVector3d S = couple(friction(i).W, part.Y);
      for (int k = 0; k < part.count; ++k)
        W(row, part.row + k) = W(part.row + k, row) = S[part.column[at(k)]];
    }
    for (std::size_t j = 0; j <= i; ++j)
      W(row, frictions_ + static_cast<int>(j)) = W(frictions_ + static_cast<int>(j), row) =
          couple(friction(i).W, friction_Y_[j])(0, 0);
  }
  diagonal = W.diagonal();
  eliminate_joints(model, instant, island, nu_free, joint_bias);
}

void ReducedSystem::eliminate_joints(const Model& model, const Instant& instant, const Island& island,
                                     const Vector& nu_free, const Vector& joint_bias) {
  const int rows = size(), equations = static_cast<int>(island.joint_rows.size());
  const auto row = [&](int i) -> const JointRowInstant& {
    return instant.joint_rows[at(island.joint_rows[at(i)])];
  };
  N_.resize(equations, equations);
  C_.resize(equations, rows);
  p0_.resize(equations);
  rank_ = 0;
  if (equations == 0) return;

  joint_Y_.resize(at(equations));
  for (int i = 0; i < equations; ++i) solve_mass(model, instant, row(i).W, joint_Y_[at(i)]);
  for (int i = 0; i < equations; ++i) {
    for (int j = 0; j <= i; ++j) N_(i, j) = N_(j, i) = couple(row(i).W, joint_Y_[at(j)])(0, 0);
    for (const Part& part : parts_) {
      const Eigen::RowVector3d S = couple(row(i).W, part.Y);
      for (int k = 0; k < part.count; ++k) C_(i, part.row + k) = S[part.column[at(k)]];
    }
    for (std::size_t j = 0; j < island.joint_frictions.size(); ++j)
      C_(i, frictions_ + static_cast<int>(j)) = couple(row(i).W, friction_Y_[j])(0, 0);
    p0_[i] = -row(i).W.velocity(nu_free)[0] - joint_bias[island.joint_rows[at(i)]];
  }

  // N is positive definite unless rows repeat each other; a pivot's square root tells
  llt_.compute(N_);
  const auto pivots = llt_.matrixLLT().diagonal();
  NC_ = C_;
  rank_ = equations;
  if (llt_.info() == Eigen::Success && (pivots.array() > full_rank * N_.diagonal().array().sqrt()).all()) {
    if (rows > 0) llt_.solveInPlace(NC_);
    llt_.solveInPlace(p0_);
  } else {
    eliminate_redundant(model, instant, island);
  }
  W.noalias() -= C_.transpose() * NC_;
  q.noalias() += C_.transpose() * p0_;
}

/// NC = N^+ C and p0 = N^+ p0 where rows of joints repeat each other.
void ReducedSystem::eliminate_redundant(const Model& model, const Instant& instant, const Island& island) {
  const Eigen::Index equations = N_.rows();
  const Vector scale = N_.diagonal().cwiseSqrt().cwiseInverse();  // so that rows in m and in rad compare
  Eigen::CompleteOrthogonalDecomposition<Matrix> qr(equations, equations);
  qr.setThreshold(dependent);
  qr.compute(scale.asDiagonal() * N_ * scale.asDiagonal());
  if (NC_.cols() > 0) NC_ = scale.asDiagonal() * qr.solve(scale.asDiagonal() * C_);
  p0_ = scale.asDiagonal() * Vector(qr.solve(scale.asDiagonal() * p0_));
  rank_ = static_cast<int>(qr.rank());
  if (rank_ == equations) return;
  // N is symmetric: what is across its range it does not see. No part along it, as compliances weigh
  const Matrix Q = qr.householderQ();
  const Matrix unseen = scale.asDiagonal() * Q.rightCols(equations - rank_);
  Matrix weighed = unseen;
  for (Eigen::Index i = 0; i < equations; ++i)
    weighed.row(i) *=
        compliance_of(model, instant.joint_rows[at(island.joint_rows[at(static_cast<int>(i))])]);
  const Eigen::LLT<Matrix> llt(unseen.transpose() * weighed);
  if (NC_.cols() > 0) NC_ -= unseen * llt.solve(weighed.transpose() * NC_);
  p0_ -= unseen * llt.solve(weighed.transpose() * p0_);
}

void ReducedSystem::compliance(const Model& model, const Instant& instant, const Island& island, Matrix& C,
                               Vector& k) const {
  C.setZero(size(), size());
  k.setZero(size());
  for (std::size_t b = 0; b < island.joint_rows.size(); ++b) {
    const auto row = static_cast<Eigen::Index>(b);
    const double c = compliance_of(model, instant.joint_rows[at(island.joint_rows[b])]);
    C.noalias() += c * NC_.row(row).transpose() * NC_.row(row);
    k.noalias() -= c * p0_[row] * NC_.row(row).transpose();
  }
  for (const Part& part : parts_) {
    const ContactInstant& c = instant.contacts[at(part.contact)];
    C.diagonal().segment(part.row, part.count).array() +=
        part.moments ? moments_compliance_of(model, c) : compliance_of(model, c);
  }
  for (std::size_t i = 0; i < island.joint_frictions.size(); ++i)
    C.diagonal()[frictions_ + static_cast<int>(i)] +=
        compliance_of(model, instant.joint_frictions[at(island.joint_frictions[i])]);
}

void ReducedSystem::add_impulses(const Instant& instant, const Island& island, const Vector& r,
                                 Vector& impulse, Vector& reactions) const {
  for (const Part& part : parts_) {
    Vector3 p = Vector3::Zero();
    for (int k = 0; k < part.count; ++k) p[part.column[at(k)]] = r[part.row + k];
    part.W(instant).add_impulse(p, impulse);
  }
  for (std::size_t i = 0; i < island.joint_frictions.size(); ++i)
    instant.joint_frictions[at(island.joint_frictions[i])].W.add_impulse(
        WrenchMap<1>::Columns(r[frictions_ + static_cast<int>(i)]), impulse);
  for (std::size_t i = 0; i < island.joint_rows.size(); ++i) {
    double& p_b = reactions[island.joint_rows[i]];
    p_b = p0_[static_cast<int>(i)] - NC_.row(static_cast<int>(i)).dot(r);
    instant.joint_rows[at(island.joint_rows[i])].W.add_impulse(WrenchMap<1>::Columns(p_b), impulse);
  }
}

int joint_rank(const Model& model, const Instant& instant) {
  if (instant.joint_rows.empty()) return 0;
  Matrix W = Matrix::Zero(model.nv(), static_cast<Eigen::Index>(instant.joint_rows.size()));
  Vector column(model.nv());
  for (std::size_t i = 0; i < instant.joint_rows.size(); ++i) {
    column.setZero();
    instant.joint_rows[i].W.add_impulse(WrenchMap<1>::Columns(1.0), column);
    W.col(static_cast<Eigen::Index>(i)) = column;
  }
  return static_cast<int>(Eigen::ColPivHouseholderQR<Matrix>(W).rank());
}

}  // namespace perp
