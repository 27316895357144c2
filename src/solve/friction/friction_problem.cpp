#include "perp/solve/friction_problem.hpp"

#include <cmath>
#include <string>

#include "perp/core/errors.hpp"
#include "solve/blocks/layout.hpp"

namespace perp {
namespace {

constexpr const char* where = "FrictionProblem";

void need_size(const char* name, Eigen::Index size, Eigen::Index needed) {
  if (size != needed)
    refuse(where, std::string(name) + " size", std::to_string(size), "needed " + std::to_string(needed));
}

void need_shape(const char* name, const FrictionMatrix& A, Eigen::Index rows, Eigen::Index cols) {
  if (A.rows() != rows || A.cols() != cols)
    refuse(where, std::string(name) + " shape", std::to_string(A.rows()) + " x " + std::to_string(A.cols()),
           "needed " + std::to_string(rows) + " x " + std::to_string(cols));
  if (!A.allFinite()) refuse(where, name, "not finite", "finite numbers are needed");
}

void need_finite(const char* name, const Vector& x) {
  for (Eigen::Index i = 0; i < x.size(); ++i)
    if (!std::isfinite(x(i)))
      refuse(where, std::string(name) + "(" + std::to_string(i) + ")", x(i), "finite numbers are needed");
}

/// Sizes of the vectors of bounds, and that each number that is read is one >= 0.
void check_bounds(const FrictionProblem& problem) {
  const Eigen::Index blocks = problem.blocks();
  if (problem.mu_o.size() > 0) need_size("mu_o", problem.mu_o.size(), blocks);
  const auto bound = [&](Eigen::Index i, const char* name, const Vector& x) {
    need_size(name, x.size(), blocks);
    if (!(x(i) >= 0) || (std::isinf(x(i)) && &x != &problem.mu))
      refuse(where, std::string(name) + "(" + std::to_string(i) + ")", x(i), "a number >= 0 is needed");
  };
  for (Eigen::Index i = 0; i < blocks; ++i) {
    const BlockLayout& layout = layout_of(problem.kind(i));
    for (int k = 0; k < layout.rows; ++k) {
      const int place = layout.place[static_cast<size_t>(k)];
      if (place == 0) continue;
      if (!layout.contact || place < 3) bound(i, "mu", problem.mu);
      if (layout.contact && place == 2 && problem.mu_o.size() > 0) bound(i, "mu_o", problem.mu_o);
      if (layout.contact && place == 3) bound(i, "torsion", problem.torsion);
      if (layout.contact && place > 3) bound(i, "rolling", problem.rolling);
    }
  }
}

}  // namespace

BlockKind FrictionProblem::kind(Eigen::Index i) const {
  if (!kinds.empty()) return kinds[i];
  constexpr BlockKind by_rows[] = {
      BlockKind::Cone,      BlockKind::HalfLine, BlockKind::Planar,          BlockKind::Cone,
      BlockKind::Torsional, BlockKind::Rolling,  BlockKind::TorsionalRolling};
  const Eigen::Index each = blocks() > 0 ? rows() / blocks() : 0;
  return each <= 6 ? by_rows[each] : BlockKind::Cone;
}

std::vector<Eigen::Index> FrictionProblem::offsets() const {
  std::vector<Eigen::Index> first(1, 0);
  first.reserve(blocks() + 1);
  for (Eigen::Index i = 0; i < blocks(); ++i) first.push_back(first.back() + block_rows(kind(i)));
  return first;
}

void check(const FrictionProblem& problem) {
  if (!problem.kinds.empty())
    need_size("kinds", static_cast<Eigen::Index>(problem.kinds.size()), problem.blocks());
  const Eigen::Index m = problem.offsets().back();
  if (problem.is_global()) {
    const Eigen::Index n = problem.M.rows();
    need_size("w", problem.w.size(), m);
    need_shape("M", problem.M, n, n);
    need_shape("H", problem.H, n, m);
    need_size("f", problem.f.size(), n);
    if (problem.G.cols() > 0) need_shape("G", problem.G, n, problem.G.cols());
    need_size("b", problem.b.size(), problem.G.cols());
    need_finite("f", problem.f);
    need_finite("w", problem.w);
    need_finite("b", problem.b);
  } else {
    need_size("q", problem.q.size(), m);
    need_shape("W", problem.W, m, m);
    need_finite("q", problem.q);
  }
  check_bounds(problem);
}

}  // namespace perp
