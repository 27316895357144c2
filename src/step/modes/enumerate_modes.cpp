// All answers of CP1 by trying every choice of modes: what a pivoting method, which finds one, is checked by.
#include <algorithm>
#include <cmath>
#include <Eigen/QR>

#include "core/index.hpp"
#include "solve/friction/vanishing_compliance.hpp"
#include "step/modes/acceleration_problem.hpp"

namespace perp {
namespace {

/// One choice of a mode for each block: c = P y + c0, with the rows `zero` of u' zero.
struct ModeChoice {
  std::vector<int> mode;  ///< of each block: 0 open or holds, 1 closed, 2 and 3 slips
  std::vector<Eigen::Index> zero;
  Matrix P;  ///< (rows, zero)
  Vector c0;
};

ModeChoice mode_choice(const FrictionProblem& problem, const std::vector<Eigen::Index>& rows, int number) {
  ModeChoice choice{std::vector<int>(at(problem.blocks())),
                    {},
                    Matrix::Zero(problem.rows(), problem.rows()),
                    Vector::Zero(problem.rows())};
  Matrix& P = choice.P;
  const auto free = [&](Eigen::Index row) {
    const auto y = static_cast<Eigen::Index>(choice.zero.size());
    P(row, y) = 1;
    choice.zero.push_back(row);
    return y;
  };
  for (Eigen::Index i = 0; i < problem.blocks(); ++i) {
    const Eigen::Index row = rows[at(i)];
    const BlockKind kind = problem.kind(i);
    const int kinds = kind == BlockKind::HalfLine ? 2 : kind == BlockKind::Planar ? 4 : 3;
    const int m = choice.mode[at(i)] = number % kinds;
    number /= kinds;
    if (kind == BlockKind::Interval) {
      if (m == 0)
        free(row);
      else
        choice.c0[row] = m == 1 ? -problem.mu[i] : problem.mu[i];
    } else if (m > 0) {
      const Eigen::Index y = free(row);
      if (m >= 2) P(row + 1, y) = m == 2 ? -problem.mu[i] : problem.mu[i];
      if (kind == BlockKind::Planar && m == 1) free(row + 1);
    }
  }
  P.conservativeResize(Eigen::NoChange, static_cast<Eigen::Index>(choice.zero.size()));
  return choice;
}

/// Whether block i has the law of its mode m in c and u, to what is small of either.
bool fits_law(const FrictionProblem& problem, Eigen::Index i, int m, Eigen::Index row, const Vector& c,
              const Vector& u, const Vector& small_u, double small_force) {
  const double small = small_u[row];
  if (problem.kind(i) == BlockKind::Interval)
    return m == 0 ? std::abs(c[row]) <= problem.mu[i] + small_force : (m == 1 ? u[row] : -u[row]) >= -small;
  if (!(u[row] >= -small && c[row] >= -small_force)) return false;
  if (problem.kind(i) != BlockKind::Planar || m == 0) return true;
  return m == 1 ? std::abs(c[row + 1]) <= problem.mu[i] * c[row] + small_force
                : (m == 2 ? u[row + 1] : -u[row + 1]) >= -small_u[row + 1];
}

}  // namespace

std::vector<Vector> AccelerationProblem::enumerate(bool& one_limit) const {
  const Matrix& W = problem.W.dense();
  const std::vector<Eigen::Index> rows = problem.offsets();
  std::vector<Vector> found;
  VanishingCompliance limit;
  one_limit = true;
  const double a_scale =
      std::max(acceleration_scale, problem.q.size() > 0 ? problem.q.cwiseAbs().maxCoeff() : 0.0);
  const auto small_of =
      [&](const Vector& c) -> Vector {  // with what rounding leaves where large parts cancel
    return (1e-13 * W.cwiseAbs() * c.cwiseAbs()).array() + 1e-9 * a_scale;
  };
  const Vector scale = W.diagonal().cwiseAbs().cwiseMax(1e-300).cwiseSqrt();  // compares forces with moments
  const int count = static_cast<int>(choices());
  for (int number = 0; number < count; ++number) {
    const ModeChoice choice = mode_choice(problem, rows, number);
    const std::vector<Eigen::Index>& zero = choice.zero;
    Vector c = choice.c0;
    auto outcome = VanishingCompliance::Outcome::None;
    if (!zero.empty()) {
      const Matrix A = (W * choice.P)(zero, Eigen::all);
      const Vector b = (problem.q + W * choice.c0)(zero);
      Vector y;
      if (even)
        outcome =
            limit.solve(A, b, (C_ * choice.P)(zero, Eigen::all), (k_ + C_ * choice.c0)(zero), scale(zero), y);
      if (outcome != VanishingCompliance::Outcome::Found) {
        Eigen::CompleteOrthogonalDecomposition<Matrix> qr(A);
        qr.setThreshold(1e-12);
        y = qr.solve(-b);
      }
      if (!y.allFinite()) continue;
      c += choice.P * y;
      if (((A * y + b).cwiseAbs() - small_of(c)(zero)).maxCoeff() > 0) continue;
    }
    const Vector u = W * c + problem.q, small_u = small_of(c);
    bool fits = true;
    for (Eigen::Index i = 0; i < problem.blocks() && fits; ++i) {
      const Eigen::Index row = rows[at(i)];
      const double weight = std::max(W.row(row).cwiseAbs().maxCoeff(), 1e-300);
      const double small_force =
          small_u[row] / weight + 1e-11 * (scale.cwiseProduct(c)).cwiseAbs().maxCoeff() / scale[row];
      fits = fits_law(problem, i, choice.mode[at(i)], row, c, u, small_u, small_force);
    }
    const bool known = std::any_of(found.begin(), found.end(), [&](const Vector& other) {
      return (W * (other - c)).cwiseAbs().maxCoeff() <=
             1e-7 * a_scale + 100 * (small_u.maxCoeff() - 1e-9 * a_scale);
    });
    one_limit = one_limit && !(fits && outcome == VanishingCompliance::Outcome::Several);
    if (fits && !known) found.push_back(c);
  }
  return found;
}

}  // namespace perp
