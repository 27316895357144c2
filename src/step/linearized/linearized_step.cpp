#include "step/linearized/linearized_step.hpp"

#include <algorithm>
#include <cmath>
#include <Eigen/LU>

#include "core/index.hpp"
#include "step/parts/moment_laws.hpp"

namespace perp {
namespace {

// of eps in the factors alone: a smaller one costs them digits, and refinement mends what it misses
constexpr double least_factored = 1e-8;

}  // namespace

/// The blocks' pattern: bodies that share a reaction or a coupling. Kept while it stays the same.
void LinearizedStep::analyze(const Model& model, const std::vector<Coupling>& K,
                             const std::vector<Reaction>& reactions) {
  block_.assign(model.bodies().size(), -1);
  int n = 0;
  for (std::size_t i = 0; i < block_.size(); ++i)
    if (model.bodies()[i].nv > 0) block_[i] = n++;
  pairs_.clear();
  const auto pair = [&](int a, int b) {
    a = block_[at(a)], b = block_[at(b)];
    if (a >= 0 && b >= 0 && a != b) pairs_.push_back({std::min(a, b), std::max(a, b)});
  };
  for (const Reaction& r : reactions) pair(r.W.a, r.W.b);
  for (const Coupling& c : K) pair(c.row, c.column);
  std::sort(pairs_.begin(), pairs_.end());
  pairs_.erase(std::unique(pairs_.begin(), pairs_.end()), pairs_.end());
  if (lu_.analyzed() && pairs_ == analyzed_pairs_ && block_ == analyzed_blocks_) return;
  std::vector<std::vector<int>> rows(at(n));
  for (int i = 0; i < n; ++i) rows[at(i)].push_back(i);
  for (const auto& [a, b] : pairs_) {
    rows[at(a)].push_back(b);
    rows[at(b)].push_back(a);
  }
  pattern_ = make_pattern(rows);
  lu_.analyze(pattern_);
  analyzed_pairs_ = pairs_;
  analyzed_blocks_ = block_;
}

bool LinearizedStep::factor(const Model& model, const std::vector<Coupling>& K,
                            const std::vector<Reaction>& reactions,
                            const std::vector<LinearizedReaction>& rows) {
  const std::size_t n = reactions.size();
  values_.assign(pattern_.column.size(), Matrix6::Zero());
  for (const Coupling& c : K) values_[at(pattern_.find(block_[at(c.row)], block_[at(c.column)]))] += c.value;
  for (std::size_t i = 0; i < model.bodies().size(); ++i) {
    const Body& b = model.bodies()[i];
    if (b.nv == 0) continue;
    Matrix6& diagonal = values_[at(pattern_.find(block_[i], block_[i]))];
    for (int k = b.nv; k < 6; ++k) diagonal(k, k) = 1;
  }
  inverse_.resize(n);
  wholes_.clear();
  for (std::size_t i = 0; i < n; ++i) {
    const Reaction& r = reactions[i];
    const LinearizedReaction& law = rows[i];
    if (law.whole != nullptr) {
      factor_whole(reactions, rows, i++);
      continue;
    }
    const double eps = law.even ? law.eps : std::max(law.eps, least_factored);
    inverse_[i] = (Matrix3::Identity() - (1 - eps) * law.P).inverse();
    const Reaction::Slope SG = inverse_[i] * law.P * (law.rho / r.w) * r.G;
    const std::array<int, 2> block{block_[at(r.W.a)], block_[at(r.W.b)]};
    const auto add = [&](int row, const WrenchMap<3>::Block& W) {
      if (row < 0) return;
      if (block[0] >= 0) values_[at(pattern_.find(row, block[0]))] += W * SG.leftCols<6>();
      if (block[1] >= 0) values_[at(pattern_.find(row, block[1]))] += W * SG.rightCols<6>();
    };
    add(block[0], r.W.A);
    add(block[1], r.W.B);
  }
  lu_.clear();
  for (std::size_t k = 0; k < values_.size(); ++k) lu_.set(static_cast<int>(k), values_[k]);
  return lu_.factor();
}

namespace {

/// The columns of a contact and of its moments.
Matrix6 both(const WrenchMap<3>::Block& contact, const WrenchMap<3>::Block& moments) {
  Matrix6 W;
  W << contact, moments;
  return W;
}

}  // namespace

/// A contact with moments as one reaction of six rows.
void LinearizedStep::factor_whole(const std::vector<Reaction>& reactions,
                                  const std::vector<LinearizedReaction>& rows, std::size_t i) {
  const Reaction &r = reactions[i], &m = reactions[i + 1];
  const auto give = [](const LinearizedReaction& law) {
    return law.even ? law.eps : std::max(law.eps, least_factored);
  };
  Matrix6 P = *rows[i].whole;
  P.leftCols<3>() *= 1 - give(rows[i]);
  P.rightCols<3>() *= 1 - give(rows[i + 1]);
  wholes_.resize(reactions.size());
  wholes_[i] = (Matrix6::Identity() - P).inverse();
  Eigen::Matrix<double, 6, 12> G;
  G << r.G, m.G;
  const Eigen::Matrix<double, 6, 12> SG = wholes_[i] * *rows[i].whole * (rows[i].rho / r.w) * G;
  const std::array<int, 2> block{block_[at(r.W.a)], block_[at(r.W.b)]};
  const auto add = [&](int row, const Matrix6& W) {
    if (row < 0) return;
    if (block[0] >= 0) values_[at(pattern_.find(row, block[0]))] += W * SG.leftCols<6>();
    if (block[1] >= 0) values_[at(pattern_.find(row, block[1]))] += W * SG.rightCols<6>();
  };
  add(block[0], both(r.W.A, m.W.A));
  add(block[1], both(r.W.B, m.W.B));
}

void LinearizedStep::Pair::add(double t, const Pair& other) {
  first += t * other.first;
  for (std::size_t i = 0; i < second.size(); ++i) second[i] += t * other.second[i];
}

/// Where refinement starts, and what it misses there; whether any reactions are even.
bool LinearizedStep::begin(const Model& model, const std::vector<Coupling>& K,
                           const std::vector<Reaction>& reactions,
                           const std::vector<LinearizedReaction>& rows, const Vector& R) {
  const std::size_t n = reactions.size();
  dnu.setZero(R.size());
  dp.assign(n, Vector3::Zero());
  missed_.first = -R;
  missed_.second.resize(n);
  for (std::size_t i = 0; i < n; ++i) missed_.second[i] = -rows[i].F;
  if (std::none_of(rows.begin(), rows.end(), [](const LinearizedReaction& row) { return row.even; }))
    return false;
  Pair &start = directions_[0], &image = images_[0];
  start.first = dnu;
  for (std::size_t i = 0; i < n; ++i)
    if (rows[i].even) dp[i] = -reactions[i].p;
  start.second = dp;
  apply(model, K, reactions, rows, start, image);
  missed_.add(-1, image);
  return true;
}

/// Takes out of dp what rounding brought into the rule: p + dp is pulled as rows that give pull it, and what that moves is made up for.
void LinearizedStep::even_out(const Model& model, const std::vector<Reaction>& reactions,
                              const std::vector<LinearizedReaction>& rows) {
  constexpr int most_returns = 3;
  const std::size_t n = reactions.size();
  Pair& change = directions_[0];
  const auto add = [&] {
    dnu += change.first;
    for (std::size_t i = 0; i < n; ++i) dp[i] += change.second[i];
  };
  const auto precondition_give = [&](double sign) {
    missed_.first.setZero();
    for (std::size_t i = 0; i < n; ++i) {
      missed_.second[i].setZero();
      if (!rows[i].even) continue;
      if (rows[i].whole == nullptr) {
        missed_.second[i] = sign * rows[i].eps * (rows[i].P * (reactions[i].p + dp[i] + change.second[i]));
        continue;
      }
      const auto give = [&](std::size_t k) -> Vector3 {
        return rows[k].eps * (reactions[k].p + dp[k] + change.second[k]);
      };
      const Vector6 missed = sign * (*rows[i].whole * whole(give(i), give(i + 1)));
      missed_.second[i] = missed.head<3>();
      missed_.second[++i] = missed.tail<3>();
    }
    precondition(model, reactions, rows, missed_, change);
  };
  change.second.assign(n, Vector3::Zero());
  precondition_give(-1);
  add();
  change.second.assign(n, Vector3::Zero());
  for (int k = 0; k < most_returns; ++k) precondition_give(1);
  add();
}

bool LinearizedStep::solve(const Model& model, const Instant& instant, const std::vector<Coupling>& K,
                           const std::vector<Reaction>& reactions,
                           const std::vector<LinearizedReaction>& rows, const Vector& R, bool thorough) {
  constexpr std::size_t refined = 4;
  analyze(model, K, reactions);
  if (!factor(model, K, reactions, rows)) return false;
  const std::size_t n = reactions.size();
  const bool even = begin(model, K, reactions, rows, R);
  thorough = thorough || even;
  const double enough = even ? 4e-15 : 1e-13;  // of the misses' norm: what is even starts from none
  const double size = product(model, instant, reactions, missed_, missed_);
  double left = size;
  std::array<double, most_directions> squares{};
  for (std::size_t k = 0; k < (thorough ? most_directions : refined); ++k) {
    Pair &d = directions_[k], &image = images_[k];
    precondition(model, reactions, rows, missed_, d);
    apply(model, K, reactions, rows, d, image);
    for (std::size_t j = 0; thorough && j < k; ++j) {
      const double t = -product(model, instant, reactions, image, images_[j]) / squares[j];
      d.add(t, directions_[j]);
      image.add(t, images_[j]);
    }
    squares[k] = product(model, instant, reactions, image, image);
    if (!std::isfinite(squares[k])) return false;
    if (!(squares[k] > 0)) break;
    const double t = thorough ? product(model, instant, reactions, missed_, image) / squares[k] : 1;
    dnu += t * d.first;
    for (std::size_t i = 0; i < n; ++i) dp[i] += t * d.second[i];
    missed_.add(-t, image);
    const double before = left;
    left = product(model, instant, reactions, missed_, missed_);
    if (left <= enough * enough * size || (even && !(left < 0.1 * before))) break;
  }
  if (even) even_out(model, reactions, rows);
  return true;
}

/// Of two misses [J].
double LinearizedStep::product(const Model& model, const Instant& instant,
                               const std::vector<Reaction>& reactions, const Pair& a, const Pair& b) {
  solve_mass(model, instant, a.first, scratch_);
  double sum = b.first.dot(scratch_);
  for (std::size_t i = 0; i < reactions.size(); ++i) sum += reactions[i].w * a.second[i].dot(b.second[i]);
  return sum;
}

/// What the factors say that makes up for the misses.
void LinearizedStep::precondition(const Model& model, const std::vector<Reaction>& reactions,
                                  const std::vector<LinearizedReaction>& rows, const Pair& misses,
                                  Pair& step) {
  rhs_.setZero(6, pattern_.size());
  for (std::size_t i = 0; i < model.bodies().size(); ++i) {
    const Body& b = model.bodies()[i];
    if (b.nv > 0) rhs_.col(block_[i]).head(b.nv) = misses.first.segment(b.v0, b.nv);
  }
  for (std::size_t i = 0; i < reactions.size(); ++i) {
    const Reaction& r = reactions[i];
    if (rows[i].whole != nullptr) {
      const Reaction& m = reactions[i + 1];
      const Vector6 known = wholes_[i] * whole(misses.second[i], misses.second[i + 1]);
      if (r.W.na > 0) rhs_.col(block_[at(r.W.a)]) += both(r.W.A, m.W.A) * known;
      if (r.W.nb > 0) rhs_.col(block_[at(r.W.b)]) += both(r.W.B, m.W.B) * known;
      ++i;
      continue;
    }
    const Vector3 known = inverse_[i] * misses.second[i];
    if (r.W.na > 0) rhs_.col(block_[at(r.W.a)]) += r.W.A * known;
    if (r.W.nb > 0) rhs_.col(block_[at(r.W.b)]) += r.W.B * known;
  }
  lu_.solve(rhs_);
  step.first.setZero(misses.first.size());
  for (std::size_t i = 0; i < model.bodies().size(); ++i) {
    const Body& b = model.bodies()[i];
    if (b.nv > 0) step.first.segment(b.v0, b.nv) = rhs_.col(block_[i]).head(b.nv);
  }
  step.second.resize(reactions.size());
  const auto change = [&](const Reaction& r) {
    Vector3 du = Vector3::Zero();
    if (r.W.na > 0) du += r.G.leftCols<6>() * rhs_.col(block_[at(r.W.a)]);
    if (r.W.nb > 0) du += r.G.rightCols<6>() * rhs_.col(block_[at(r.W.b)]);
    return du;
  };
  for (std::size_t i = 0; i < reactions.size(); ++i) {
    const Reaction& r = reactions[i];
    const Vector3 du = change(r);
    if (rows[i].whole != nullptr) {
      const Vector6 known = whole(misses.second[i], misses.second[i + 1]);
      const Vector6 both_du = whole(du, change(reactions[i + 1]));
      const Vector6 y = wholes_[i] * (known - *rows[i].whole * both_du * (rows[i].rho / r.w));
      step.second[i] = y.head<3>();
      step.second[++i] = y.tail<3>();
      continue;
    }
    step.second[i] = inverse_[i] * (misses.second[i] - rows[i].P * du * (rows[i].rho / r.w));
  }
}

/// The left sides of the linearised equations.
void LinearizedStep::apply(const Model& model, const std::vector<Coupling>& K,
                           const std::vector<Reaction>& reactions,
                           const std::vector<LinearizedReaction>& rows, const Pair& step, Pair& out) const {
  out.first.setZero(step.first.size());
  for (const Coupling& c : K) {
    const Body &row = model.bodies()[at(c.row)], &column = model.bodies()[at(c.column)];
    out.first.segment(row.v0, row.nv) +=
        c.value.topLeftCorner(row.nv, column.nv) * step.first.segment(column.v0, column.nv);
  }
  out.second.resize(reactions.size());
  const auto change = [&](const Reaction& r) {
    Vector3 du = Vector3::Zero();
    for (int k = 0; k < r.W.na; ++k) du += r.G.col(k) * step.first[r.W.va + k];
    for (int k = 0; k < r.W.nb; ++k) du += r.G.col(6 + k) * step.first[r.W.vb + k];
    return du;
  };
  const auto kept = [&](std::size_t i) -> Vector3 {
    return (1 - (rows[i].even ? 0 : rows[i].eps)) * step.second[i];
  };
  for (std::size_t i = 0; i < reactions.size(); ++i) {
    const Reaction& r = reactions[i];
    const LinearizedReaction& row = rows[i];
    const Vector3& dp_i = step.second[i];
    r.W.add_impulse(-dp_i, out.first);
    const Vector3 du = change(r);
    if (row.whole != nullptr) {
      const Reaction& m = reactions[i + 1];
      const Vector3& dp_m = step.second[i + 1];
      m.W.add_impulse(-dp_m, out.first);
      const Vector6 y = *row.whole * (whole(kept(i), kept(i + 1)) - whole(du, change(m)) * (row.rho / r.w));
      out.second[i] = dp_i - y.head<3>();
      out.second[++i] = dp_m - y.tail<3>();
      continue;
    }
    out.second[i] = dp_i - row.P * ((1 - (row.even ? 0 : row.eps)) * dp_i - du * (row.rho / r.w));
  }
}

}  // namespace perp
