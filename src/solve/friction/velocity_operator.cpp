#include "solve/friction/velocity_operator.hpp"

#include <algorithm>
#include <cmath>
#include <Eigen/LU>

namespace perp {

namespace {

constexpr double regularisation = 1e-8;  // delta of the header, beside tr W_ii = rows [-]

/// Rows that go into one 6x6 block: blocks of M that a contact touches, in their order, joined while they fit. A
/// body whose inertia is diagonal falls into six blocks of M; joined they are one again, and joining more costs
/// nothing but zeros.
std::vector<std::vector<int>> bodies_of(const SparseMatrix& M, const SparseMatrix& H) {
  std::vector<char> touched(M.rows(), false);
  for (Eigen::Index c = 0; c < H.cols(); ++c)
    for (SparseMatrix::InnerIterator it(H, c); it; ++it) touched[it.row()] = true;
  std::vector<std::vector<int>> bodies;
  for (const std::vector<int>& rows : connected_blocks(M)) {
    if (std::none_of(rows.begin(), rows.end(), [&](int row) { return touched[row]; })) continue;
    if (bodies.empty() || bodies.back().size() + rows.size() > 6) bodies.emplace_back();
    bodies.back().insert(bodies.back().end(), rows.begin(), rows.end());
  }
  return bodies;
}

}  // namespace

template <int R>
bool VelocityOperator<R>::suits(const FrictionProblem& global) {
  if (!global.is_global() || global.G.cols() > 0) return false;
  const std::vector<std::vector<int>> bodies = bodies_of(global.M.to_sparse(), global.H.to_sparse());
  return static_cast<Eigen::Index>(bodies.size()) <= global.blocks() &&
         std::all_of(bodies.begin(), bodies.end(), [](const auto& rows) { return rows.size() <= 6; });
}

template <int R>
VelocityOperator<R>::VelocityOperator(const FrictionProblem& global,
                                      const std::vector<const BlockLayout*>& layout)
    : contacts_(static_cast<int>(global.blocks())) {
  const SparseMatrix M = global.M.to_sparse(), H = global.H.to_sparse();
  const std::vector<std::vector<int>> rows = bodies_of(M, H);
  bodies_ = static_cast<int>(rows.size());
  std::vector<int> body(M.rows(), -1), slot(M.rows());
  mass_.assign(bodies_, Block6::Identity());  // identity on the rows that a smaller block lacks
  for (int b = 0; b < bodies_; ++b)
    for (int k = 0; k < static_cast<int>(rows[b].size()); ++k) {
      body[rows[b][k]] = b;
      slot[rows[b][k]] = k;
      mass_[b](k, k) = 0;
    }
  for (int c = 0; c < M.cols(); ++c)
    for (SparseMatrix::InnerIterator it(M, c); it; ++it)
      if (body[c] >= 0) mass_[body[c]](slot[it.row()], slot[c]) += it.value();
  for (const Block6& block : mass_) inverse_mass_.push_back(block.partialPivLu().inverse());

  const std::vector<Eigen::Index> offsets = global.offsets();
  arms_of_body_.resize(bodies_);
  arm_start_.push_back(0);
  for (int i = 0; i < contacts_; ++i) {
    for (Eigen::Index c = offsets[i]; c < offsets[i + 1]; ++c)
      for (SparseMatrix::InnerIterator it(H, c); it; ++it) {
        const int b = body[it.row()];
        auto arm = std::find_if(arms_.begin() + arm_start_[i], arms_.end(),
                                [b](const Arm& a) { return a.body == b; });
        if (arm == arms_.end()) {
          arms_of_body_[b].push_back(static_cast<int>(arms_.size()));
          arms_.push_back({i, b, Wrench::Zero()});
          arm = arms_.end() - 1;
        }
        arm->H(slot[it.row()], layout[i]->place[c - offsets[i]]) += it.value();
      }
    arm_start_.push_back(static_cast<int>(arms_.size()));
  }
  find_diagonal();

  std::vector<std::vector<int>> graph(bodies_);
  for (int b = 0; b < bodies_; ++b) graph[b].push_back(b);
  for (int i = 0; i < contacts_; ++i)
    for (int p = arm_start_[i]; p < arm_start_[i + 1]; ++p)
      for (int q = arm_start_[i]; q < arm_start_[i + 1]; ++q) graph[arms_[p].body].push_back(arms_[q].body);
  pattern_ = make_pattern(graph);
  for (int i = 0; i < contacts_; ++i)
    for (int p = arm_start_[i]; p < arm_start_[i + 1]; ++p)
      for (int q = arm_start_[i]; q < arm_start_[i + 1]; ++q)
        place_.push_back(pattern_.find(arms_[p].body, arms_[q].body));
  sum_.resize(pattern_.column.size());
}

template <int R>
void VelocityOperator<R>::scale(const Columns<R>& s) {
  for (Arm& arm : arms_) arm.H.array().rowwise() *= s.col(arm.contact).transpose().array();
  find_diagonal();
}

template <int R>
void VelocityOperator<R>::find_diagonal() {
  diagonal_.assign(contacts_, Square<R>::Zero());
  for (const Arm& arm : arms_)
    diagonal_[arm.contact].noalias() += arm.H.transpose() * (inverse_mass_[arm.body] * arm.H).eval();
}

template <int R>
void VelocityOperator<R>::apply(const Columns<R>& r, Columns<R>& Wr) const {
  v_.setZero(6, bodies_);
  for (const Arm& arm : arms_) v_.col(arm.body).noalias() += arm.H * r.col(arm.contact);
  for (int b = 0; b < bodies_; ++b) v_.col(b) = (inverse_mass_[b] * v_.col(b)).eval();
  Wr.setZero(R, contacts_);
  for (const Arm& arm : arms_) Wr.col(arm.contact).noalias() += arm.H.transpose() * v_.col(arm.body);
}

template <int R>
Column<R> VelocityOperator<R>::row(int i, const Columns<R>& r) const {
  Column<R> u = Column<R>::Zero();
  for (int p = arm_start_[i]; p < arm_start_[i + 1]; ++p) {
    Eigen::Matrix<double, 6, 1> load = Eigen::Matrix<double, 6, 1>::Zero();
    for (const int q : arms_of_body_[arms_[p].body]) load.noalias() += arms_[q].H * r.col(arms_[q].contact);
    u.noalias() += arms_[p].H.transpose() * (inverse_mass_[arms_[p].body] * load).eval();
  }
  return u;
}

template <int R>
void VelocityOperator<R>::hold(const Columns<R>& r) {
  held_v_.setZero(6, bodies_);
  for (const Arm& arm : arms_) held_v_.col(arm.body).noalias() += arm.H * r.col(arm.contact);
  for (int b = 0; b < bodies_; ++b) held_v_.col(b) = (inverse_mass_[b] * held_v_.col(b)).eval();
}

template <int R>
Column<R> VelocityOperator<R>::held(int i) const {
  Column<R> u = Column<R>::Zero();
  for (int p = arm_start_[i]; p < arm_start_[i + 1]; ++p)
    u.noalias() += arms_[p].H.transpose() * held_v_.col(arms_[p].body);
  return u;
}

template <int R>
void VelocityOperator<R>::add(int i, const Column<R>& dr) {
  for (int p = arm_start_[i]; p < arm_start_[i + 1]; ++p)
    held_v_.col(arms_[p].body).noalias() += inverse_mass_[arms_[p].body] * (arms_[p].H * dr).eval();
}

template <int R>
double VelocityOperator<R>::sweep_work() const {
  return (12.0 * R + 36) * static_cast<double>(arms_.size());
}

template <int R>
double VelocityOperator<R>::newton_work() {
  if (!lu_.analyzed()) lu_.analyze(pattern_);
  return lu_.factor_work() + 3 * lu_.solve_work() + 54.0 * R * static_cast<double>(place_.size());
}

template <int R>
bool VelocityOperator<R>::factor(const Squares<R>& A, const Squares<R>& B) {
  if (!lu_.analyzed()) lu_.analyze(pattern_);
  A_ = A;
  B_ = B;
  A_inverse_.resize(contacts_);
  D_.resize(contacts_);
  for (Block6& block : sum_) block.setZero();
  for (int b = 0; b < bodies_; ++b) sum_[pattern_.find(b, b)] = mass_[b];
  int at = 0;
  for (int i = 0; i < contacts_; ++i) {
    const int begin = arm_start_[i], end = arm_start_[i + 1];
    A_inverse_[i] = A[i] + regularisation * B[i];
    if (!invert<R>(A_inverse_[i])) return false;
    D_[i].noalias() = A_inverse_[i] * B[i];
    if (D_[i].isZero(0)) {
      at += (end - begin) * (end - begin);
      continue;
    }
    for (int p = begin; p < end; ++p) {
      const Wrench HD = arms_[p].H * D_[i];
      for (int q = begin; q < end; ++q) sum_[place_[at++]].noalias() += HD * arms_[q].H.transpose();
    }
  }
  lu_.clear();
  for (int e = 0; e < static_cast<int>(sum_.size()); ++e) lu_.set(e, sum_[e]);
  return lu_.factor();
}

template <int R>
void VelocityOperator<R>::solve_once(const Columns<R>& y, Columns<R>& x) {
  x.resize(R, contacts_);
  for (int i = 0; i < contacts_; ++i) x.col(i).noalias() = A_inverse_[i] * y.col(i);
  v_.setZero(6, bodies_);
  for (const Arm& arm : arms_) v_.col(arm.body).noalias() += arm.H * x.col(arm.contact);
  lu_.solve(v_);
  for (const Arm& arm : arms_)
    x.col(arm.contact).noalias() -= D_[arm.contact] * (arm.H.transpose() * v_.col(arm.body)).eval();
}

template <int R>
bool VelocityOperator<R>::solve(const Columns<R>& y, Columns<R>& x, Columns<R>& Wx) {
  solve_once(y, x);
  return this->refine(y, x, Wx, A_, B_,
                      [this](const Columns<R>& rhs, Columns<R>& out) { solve_once(rhs, out); });
}

template <int R>
Matrix VelocityOperator<R>::dense() const {
  Matrix W = Matrix::Zero(R * contacts_, R * contacts_);
  for (const std::vector<int>& arms : arms_of_body_)
    for (const int p : arms)
      for (const int q : arms)
        W.block<R, R>(R * arms_[p].contact, R * arms_[q].contact).noalias() +=
            arms_[p].H.transpose() * (inverse_mass_[arms_[p].body] * arms_[q].H).eval();
  return W;
}

template class VelocityOperator<3>;
template class VelocityOperator<6>;

}  // namespace perp
