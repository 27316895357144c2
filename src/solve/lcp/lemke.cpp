#include "perp/solve/lemke.hpp"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include "core/index.hpp"
#include "perp/core/errors.hpp"

namespace perp {
namespace {

using ConstMatrix = Eigen::Ref<const Matrix>;
using ConstVector = Eigen::Ref<const Vector>;

constexpr int check_every = 20;        // pivots between two looks at the rounding that has grown
constexpr double drift_limit = 1e-11;  // of w - A z - d z0 - b relative to its terms, before setting up again
constexpr double residual_settled = 4e-16;  // relative residual not worth a refinement
constexpr int max_repairs = 6;              // set-ups from the data at the path's end
constexpr double good_enough = 0.01;        // of the tolerance: no repair
constexpr double z0_is_zero = 1e-7;  // of max|b|: z0 leaves rather than another; what this costs is repaired

void check_sizes(const ConstMatrix& A, const ConstVector& b) {
  if (A.rows() == b.size() && A.cols() == b.size()) return;
  const std::string n = std::to_string(b.size());
  refuse("lcp", "A", "(" + std::to_string(A.rows()) + ", " + std::to_string(A.cols()) + ")",
         "(" + n + ", " + n + ") is needed for b of size " + n);
}

}  // namespace

LemkeSolver::LemkeSolver(LemkeOptions options) : options_(std::move(options)) {
  if (options_.covering.size() > 0 && !(options_.covering.array() > 0).all())
    refuse("LemkeSolver", "covering", options_.covering.minCoeff(), "every d_i > 0 is needed");
}

// The dictionary of the basis w: w = b + A z + d z0.
void LemkeSolver::load(const ConstMatrix& A, const ConstVector& b) {
  for (int i = 0; i < n_; ++i) {
    double* r = row(i);
    r[0] = b[i];
    for (int j = 0; j < n_; ++j) r[1 + j] = A(i, j);
    r[1 + n_] = cover_[at(i)];
    for (size_t j = at(n_) + 2; j < stride_; ++j) r[j] = 0;
    basic_[at(i)] = i;
    nonbasic_[at(i)] = n_ + i;
    place_[at(i)] = -1 - i;
    place_[at(n_ + i)] = i;
  }
  nonbasic_[at(n_)] = 2 * n_;
  place_[at(2 * n_)] = n_;
}

// Jordan exchange: the basic variable of row r and the nonbasic one of the slot change places.
void LemkeSolver::exchange(int r, int slot) {
  const size_t s = 1 + at(slot);
  double* const pivot_row = row(r);
  const double inverse = 1 / pivot_row[s];
  for (size_t j = 0; j < stride_; ++j) pivot_row[j] *= -inverse;
  pivot_row[s] = inverse;
  for (int i = 0; i < n_; ++i) {
    double* const other = row(i);
    const double factor = other[s];
    if (i == r || factor == 0) continue;
    other[s] = 0;
    for (size_t j = 0; j < stride_; ++j) other[j] += factor * pivot_row[j];
  }
  std::swap(basic_[at(r)], nonbasic_[at(slot)]);
  place_[at(basic_[at(r)])] = -1 - r;
  place_[at(nonbasic_[at(slot)])] = slot;
}

// Makes z0 basic at the least value for which every basic variable is >= 0; false if none is negative. The variable
// that leaves is the lexicographically least of (b_i + sⁱ) / d_i: of equals the last.
bool LemkeSolver::start() {
  const int slot = slot_of(2 * n_);
  int leaving = -1;
  double least = 0;
  for (int i = 0; i < n_; ++i) {
    const double ratio = row(i)[0] / row(i)[1 + slot];
    const bool tie = leaving >= 0 && ratio == least && basic_[at(i)] > basic_[at(leaving)];
    if (ratio < least || tie) least = ratio, leaving = i;
  }
  if (leaving < 0) return false;
  entering_ = basic_[at(leaving)];
  entering_ += entering_ < n_ ? n_ : -n_;
  exchange(leaving, slot);
  ++pivots_;
  return true;
}

// The row whose basic variable reaches zero first as the slot's variable grows from zero, -1 if none does.
int LemkeSolver::blocking_row(int slot) {
  const size_t s = 1 + at(slot);
  double largest = 1;
  for (int i = 0; i < n_; ++i) largest = std::max(largest, std::abs(row(i)[s]));
  const double zero = options_.pivot_tolerance * largest;
  double step = infinity;
  for (int i = 0; i < n_; ++i) {
    const double* r = row(i);
    if (r[s] < -zero) step = std::min(step, std::max(r[0], 0.0) / -r[s]);
  }
  const double slack = options_.tie_tolerance * b_scale_;
  const auto remainder = [&](const double* r) { return r[0] + step * r[s]; };
  tied_.clear();
  for (int i = 0; i < n_; ++i) {
    const double* r = row(i);
    if (r[s] >= -zero || remainder(r) > slack + options_.tie_tolerance * std::abs(r[0])) continue;
    tied_.push_back(i);
  }
  if (tied_.empty()) return -1;
  const int z0_row = row_of(2 * n_);  // z0 leaves where it can: the end of the path
  if (row(z0_row)[s] < -zero && remainder(row(z0_row)) <= z0_is_zero * b_scale_) return z0_row;
  for (const int i : tied_)
    if (std::abs(row(i)[0]) <= slack) step = 0;
  for (const int i : tied_) row(i)[0] = -step * row(i)[s];  // tied exactly
  return tied_.size() == 1 ? tied_.front() : first_in_lexicographic_order(slot);
}

// Of the tied rows the one whose [entry of s, of s², ...] / |pivot| is least. With b + (s, s², ...) in place of b a
// nonbasic w_j stands at -sʲ, a basic one is sʲ more.
int LemkeSolver::first_in_lexicographic_order(int slot) {
  const size_t s = 1 + at(slot);
  for (int j = 0; j < n_ && tied_.size() > 1; ++j) {
    const bool basic = is_basic(j);
    if (!basic && slot_of(j) == slot) continue;  // the same ratio for all
    const auto ratio = [&](int i) {
      const double entry = basic ? (row_of(j) == i ? 1.0 : 0.0) : -row(i)[1 + slot_of(j)];
      return entry / -row(i)[s];
    };
    double least = infinity, largest = 0;
    for (const int i : tied_) {
      least = std::min(least, ratio(i));
      largest = std::max(largest, std::abs(ratio(i)));
    }
    const double limit = least + options_.pivot_tolerance * largest;
    size_t kept = 0;
    for (const int i : tied_)
      if (ratio(i) <= limit) tied_[kept++] = i;
    tied_.resize(kept);
  }
  return tied_.front();
}

// Lets entering_ grow, then the complement of what left, and so on.
LcpStatus LemkeSolver::follow(const ConstMatrix& A, const ConstVector& b) {
  for (int k = 1; pivots_ < max_pivots_; ++k) {
    if (k % check_every == 0 && has_drifted(A, b) && !refactorise(A, b)) return LcpStatus::Inaccurate;
    const int slot = slot_of(entering_);
    const int r = blocking_row(slot);
    if (r < 0) return LcpStatus::SecondaryRay;
    const int leaving = basic_[at(r)];
    exchange(r, slot);
    ++pivots_;
    if (leaving == 2 * n_) return LcpStatus::Solved;
    entering_ = leaving < n_ ? leaving + n_ : leaving - n_;
  }
  return LcpStatus::PivotLimit;
}

// Sets the dictionary of the present basis up again from A, b and d, by exchanges with the largest pivots left.
// False, with the basis as far as it went, if the basis is singular to rounding.
bool LemkeSolver::refactorise(const ConstMatrix& A, const ConstVector& b) {
  std::vector<int>& wanted = tied_;  // the variables other than w that are basic now
  wanted.clear();
  std::vector<char> leaves(at(n_), 0);
  for (int i = 0; i < n_; ++i) leaves[at(i)] = !is_basic(i);
  for (const int variable : basic_)
    if (variable >= n_) wanted.push_back(variable);
  load(A, b);
  while (!wanted.empty()) {
    double largest = 0;
    int best_row = -1;
    size_t best = 0;
    for (int i = 0; i < n_; ++i) {
      if (!leaves[at(i)]) continue;
      for (size_t k = 0; k < wanted.size(); ++k) {
        const double size = std::abs(row(i)[1 + slot_of(wanted[k])]);
        if (size > largest) largest = size, best_row = i, best = k;
      }
    }
    if (best_row < 0 || largest < residual_settled) return false;
    exchange(best_row, slot_of(wanted[best]));
    leaves[at(best_row)] = 0;
    wanted.erase(wanted.begin() + static_cast<std::ptrdiff_t>(best));
  }
  return true;
}

// A new artificial variable over the present basis without z0: each basic variable + z0. In terms of the data,
// d = (change of w) - A (change of z) for a unit of z0.
void LemkeSolver::cover_basis(const ConstMatrix& A) {
  for (int i = 0; i < n_; ++i) cover_[at(i)] = is_basic(i) ? 1 : 0;
  for (int j = 0; j < n_; ++j)
    if (is_basic(n_ + j))
      for (int i = 0; i < n_; ++i) cover_[at(i)] -= A(i, j);
  const size_t s = 1 + at(slot_of(2 * n_));
  for (int i = 0; i < n_; ++i) row(i)[s] = 1;
}

// At a ray: takes z0 out of the basis for one of the pair whose variables are both nonbasic, so that the basis is
// complementary again, though not feasible. False if neither can take its place.
bool LemkeSolver::drop_artificial() {
  const int r = row_of(2 * n_);
  const int one = slot_of(entering_), other = slot_of(entering_ < n_ ? entering_ + n_ : entering_ - n_);
  const int slot = std::abs(row(r)[1 + one]) > std::abs(row(r)[1 + other]) ? one : other;
  if (std::abs(row(r)[1 + slot]) <= options_.pivot_tolerance) return false;
  exchange(r, slot);
  ++pivots_;
  return true;
}

// Whether the basic solution of the dictionary no longer satisfies w = A z + d z0 + b.
bool LemkeSolver::has_drifted(const ConstMatrix& A, const ConstVector& b) {
  const double z0 = is_basic(2 * n_) ? row(row_of(2 * n_))[0] : 0;
  for (int i = 0; i < n_; ++i) {
    w_[at(i)] = b[i] + cover_[at(i)] * z0;
    size_[at(i)] = std::abs(b[i]) + std::abs(cover_[at(i)] * z0);
  }
  for (int j = 0; j < n_; ++j) {
    if (!is_basic(n_ + j)) continue;
    const double z = row(row_of(n_ + j))[0];
    for (int i = 0; i < n_; ++i) w_[at(i)] += A(i, j) * z, size_[at(i)] += std::abs(A(i, j) * z);
  }
  double miss = 0, size = 0;
  for (int i = 0; i < n_; ++i) {
    const double w = is_basic(i) ? row(row_of(i))[0] : 0;
    miss = std::max(miss, std::abs(w - w_[at(i)]));
    size = std::max(size, size_[at(i)]);
  }
  return miss > drift_limit * size;
}

// w_ = A z + b, size_ = |A| |z| + |b|; returns lcp_relative_residual.
double LemkeSolver::evaluate(const ConstMatrix& A, const ConstVector& b, const Vector& z) {
  for (int i = 0; i < n_; ++i) w_[at(i)] = b[i], size_[at(i)] = std::abs(b[i]);
  for (int j = 0; j < n_; ++j) {
    const double z_j = z[j];
    if (z_j == 0) continue;
    for (int i = 0; i < n_; ++i) {
      const double term = A(i, j) * z_j;
      w_[at(i)] += term;
      size_[at(i)] += std::abs(term);
    }
  }
  double miss = 0, size = 0;
  for (int i = 0; i < n_; ++i) {
    miss = std::max(miss, z[i] > 0 ? std::abs(w_[at(i)]) : -w_[at(i)]);
    size = std::max(size, size_[at(i)]);
  }
  return miss > 0 ? miss / size : 0;
}

// The dictionary's z, refined: where w_i = 0 is asked for and A z + b says w_i = e_i, the dictionary says how far
// the basic z have to move for -e_i. Returns the relative residual; w_ belongs to z.
double LemkeSolver::read_solution(const ConstMatrix& A, const ConstVector& b, Vector& z) {
  for (int j = 0; j < n_; ++j) z[j] = is_basic(n_ + j) ? std::max(row(row_of(n_ + j))[0], 0.0) : 0.0;
  double error = evaluate(A, b, z);
  for (int k = 0; k < 3 && error > residual_settled; ++k) {
    for (int j = 0; j < n_; ++j) {
      if (!is_basic(n_ + j)) continue;
      double* r = row(row_of(n_ + j));
      double correction = 0;
      for (int i = 0; i < n_; ++i)
        if (!is_basic(i)) correction += r[1 + slot_of(i)] * w_[at(i)];
      r[0] = z[j] - correction;
    }
    const double before = error;
    for (int j = 0; j < n_; ++j)
      if (is_basic(n_ + j)) z[j] = std::max(row(row_of(n_ + j))[0], 0.0);
    error = evaluate(A, b, z);
    if (!(error < before)) break;
  }
  return error;
}

// A ray of z that is at the same time a certificate, as it is for every copositive-plus A.
void LemkeSolver::read_ray(const ConstMatrix& A, const ConstVector& b, LcpSolution& out) {
  const int slot = slot_of(entering_);
  Vector y = Vector::Zero(n_);
  for (int j = 0; j < n_; ++j)
    if (is_basic(n_ + j)) y[j] = std::max(row(row_of(n_ + j))[1 + slot], 0.0);
  if (entering_ >= n_) y[entering_ - n_] = 1;
  if (!proves_no_solution(A, b, y)) return;
  out.status = LcpStatus::NoSolution;
  out.certificate = y;
}

void LemkeSolver::solve(const ConstMatrix& A, const ConstVector& b, LcpSolution& out) {
  check_sizes(A, b);
  n_ = static_cast<int>(b.size());
  if (out.z.size() != n_) out.z.resize(n_);
  if (out.certificate.size() > 0) out.certificate.resize(0);
  out.stage = "lemke";
  out.pivots = 0;
  if (n_ == 0 || b.minCoeff() >= 0) {
    out.z.setZero();
    out.status = LcpStatus::Solved;
    out.residual = 0;
    return;
  }

  if (options_.covering.size() > 0 && options_.covering.size() != n_)
    refuse("LemkeSolver::solve", "covering", static_cast<double>(options_.covering.size()),
           "one d_i for each of " + std::to_string(n_) + " rows is needed");
  stride_ = (at(n_) + 3) & ~size_t{1};
  dictionary_.resize(at(n_) * stride_);
  cover_.resize(at(n_));
  w_.resize(at(n_)), size_.resize(at(n_));
  basic_.resize(at(n_)), nonbasic_.resize(at(n_) + 1), place_.resize(2 * at(n_) + 1);
  tied_.reserve(at(n_) + 1);
  for (int i = 0; i < n_; ++i) cover_[at(i)] = options_.covering.size() > 0 ? options_.covering[i] : 1.0;
  b_scale_ = b.cwiseAbs().maxCoeff();
  pivots_ = 0;
  max_pivots_ = options_.max_pivots > 0 ? options_.max_pivots : 50 * (n_ + 1);

  load(A, b);
  start();
  out.status = follow(A, b);
  double error = infinity;
  for (int repairs = max_repairs, restarts = options_.restarts;;) {
    if (out.status == LcpStatus::Solved) {
      error = read_solution(A, b, out.z);
      if (error <= good_enough * options_.tolerance || repairs-- == 0 || !refactorise(A, b)) break;
      error = read_solution(A, b, out.z);
      if (error <= good_enough * options_.tolerance) break;
      cover_basis(A);
      if (!start()) break;
      out.status = follow(A, b);
    } else if (out.status == LcpStatus::SecondaryRay) {
      if (!refactorise(A, b)) break;
      const int before = pivots_;
      out.status = follow(A, b);
      if (pivots_ != before) continue;  // no ray of the data
      read_ray(A, b, out);
      if (out.status == LcpStatus::NoSolution || restarts-- == 0 || !drop_artificial()) break;
      cover_basis(A);
      out.status = start() ? follow(A, b) : LcpStatus::Solved;
    } else {
      break;
    }
  }
  out.pivots = pivots_;
  if (out.status == LcpStatus::Solved && !(error <= options_.tolerance)) out.status = LcpStatus::Inaccurate;
  if (out.status != LcpStatus::Solved && out.status != LcpStatus::Inaccurate) {
    out.z.setZero();
    evaluate(A, b, out.z);
  }
  out.residual = 0;
  for (int i = 0; i < n_; ++i) out.residual = std::max(out.residual, std::abs(std::min(out.z[i], w_[at(i)])));
}

}  // namespace perp
