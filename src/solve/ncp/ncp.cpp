#include "perp/solve/ncp.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <Eigen/LU>

#include "perp/core/errors.hpp"
#include "solve/ncp/ncp_by_ipopt.hpp"

namespace perp {
namespace {

/// A complementarity function of every pair and its generalised Jacobian da dz + db dF.
struct Map {
  Vector value, da, db;
};

Map min_map(const Vector& z, const Vector& w) {
  const Eigen::Array<bool, Eigen::Dynamic, 1> z_smaller = z.array() < w.array();
  const Vector da = z_smaller.cast<double>();
  return {z.cwiseMin(w), da, Vector::Ones(z.size()) - da};
}

Map fischer_burmeister(const Vector& z, const Vector& w) {
  Map map{Vector(z.size()), Vector(z.size()), Vector(z.size())};
  for (Eigen::Index i = 0; i < z.size(); ++i) {
    const double root = std::hypot(z(i), w(i));
    map.value(i) = z(i) + w(i) - root;
    map.da(i) = root > 0 ? 1 - z(i) / root : 1 - std::sqrt(0.5);  // an element of the derivative at the kink
    map.db(i) = root > 0 ? 1 - w(i) / root : 1 - std::sqrt(0.5);
  }
  return map;
}

/// The k-th other start: around z0 and at growing sizes, from a fixed linear congruence.
Vector other_start(const Vector& z0, int k) {
  const double size = std::max(1.0, z0.cwiseAbs().maxCoeff()) * std::array{0.1, 1.0, 3.0, 10.0, 100.0}[k % 5];
  std::uint64_t state = 0x2545f4914f6cdd1du * static_cast<std::uint64_t>(k + 1);
  Vector z(z0.size());
  for (Eigen::Index i = 0; i < z.size(); ++i) {
    state = state * 6364136223846793005u + 1442695040888963407u;
    const double unit = static_cast<double>(state >> 11) * 0x1p-53;
    z(i) = k < 5 ? size : size * unit;  // the first ones are constant vectors
  }
  return z;
}

class NcpSolver {
 public:
  NcpSolver(const NcpFunction& F, const NcpJacobian& J, const NcpOptions& options)
      : F_(F), J_(J), options_(options) {}

  NcpSolution best;

  void run(Map (*complementarity)(const Vector&, const Vector&), const Vector& start, std::string_view stage,
           int most) {
    constexpr int most_halvings = 30;
    constexpr double sufficient = 1e-4;  // Armijo's fraction
    Vector z = start, w = F_(z);
    if (!w.allFinite()) return;
    keep(z, w, stage);
    Map map = complementarity(z, w);
    std::array<double, 8> merits;  // of the last steps: the search is nonmonotone
    merits.fill(map.value.squaredNorm());
    for (int k = 0; k < most && !done(); ++k) {
      ++best.iterations;
      const Matrix jacobian = J_(z);
      if (!jacobian.allFinite()) return;
      Matrix A = map.db.asDiagonal() * jacobian;
      A.diagonal() += map.da;
      const double merit = map.value.squaredNorm();
      const Vector gradient = A.transpose() * map.value;
      Vector step = A.partialPivLu().solve(-map.value);
      if (!step.allFinite() || gradient.dot(step) > -1e-8 * std::min(merit, step.squaredNorm())) {
        // Levenberg-Marquardt where Newton's direction is no descent
        Matrix normal = A.transpose() * A;
        normal.diagonal().array() += 1e-3 * std::sqrt(merit) + 1e-14 * normal.diagonal().maxCoeff();
        step = normal.partialPivLu().solve(-gradient);
      }
      if (!step.allFinite()) return;
      const double reference = *std::max_element(merits.begin(), merits.end());
      const double slope = 2 * gradient.dot(step);
      double t = 1;
      for (int halvings = 0;; ++halvings, t /= 2) {
        const Vector trial = z + t * step;
        const Vector w_trial = F_(trial);
        if (w_trial.allFinite()) {
          map = complementarity(trial, w_trial);
          if (map.value.squaredNorm() <= reference + sufficient * t * slope) {
            z = trial, w = w_trial;
            break;
          }
        }
        if (halvings == most_halvings) return;
      }
      merits[k % merits.size()] = map.value.squaredNorm();
      keep(z, w, stage);
    }
  }

  /// Ipopt from z0 and, if need be, from other starts, each answer polished by Newton's method.
  void ipopt_stage(const Vector& z0) {
    constexpr int starts = 4, polish = 30;  // the polish's iterations
    for (int k = 0; k < starts && !done(); ++k) {
      const Vector z = ncp_by_ipopt(F_, J_, k == 0 ? z0 : other_start(z0, k - 1), best.iterations);
      if (!z.allFinite()) continue;
      run(min_map, z, "ipopt", polish);
      if (!done()) run(fischer_burmeister, z, "ipopt", polish);
    }
  }

  bool done() const { return best.residual <= options_.tolerance; }

 private:
  void keep(const Vector& z, const Vector& w, std::string_view stage) {
    const double residual = z.cwiseMin(w).cwiseAbs().maxCoeff();
    if (!(residual < best.residual)) return;
    best.z = z;
    best.w = w;
    best.residual = residual;
    best.stage = stage;
  }

  const NcpFunction& F_;
  const NcpJacobian& J_;
  const NcpOptions& options_;
};

}  // namespace

NcpSolution solve_ncp(const NcpFunction& F, const NcpJacobian& J, const Vector& z0,
                      const NcpOptions& options) {
  const Eigen::Index n = z0.size();
  if (!z0.allFinite()) refuse("solve_ncp", "z0", "not finite", "finite numbers are needed");
  if (!(options.tolerance > 0)) refuse("solve_ncp", "tolerance", options.tolerance, "a number > 0 is needed");
  const Vector w0 = F(z0);
  const Matrix J0 = J(z0);
  if (w0.size() != n)
    refuse("solve_ncp", "size of F(z0)", static_cast<double>(w0.size()), "as many entries as z0 are needed");
  if (J0.rows() != n || J0.cols() != n)
    refuse("solve_ncp", "rows of J(z0)", static_cast<double>(J0.rows()),
           "a square matrix of z0's size is needed");
  NcpSolver solver(F, J, options);
  if (n == 0) {
    solver.best.residual = 0;
  } else {
    const int most = options.max_iterations;
    solver.run(min_map, z0, "min-map", most);
    if (!solver.done()) solver.run(fischer_burmeister, z0, "fischer-burmeister", most);
    for (int k = 0; k < options.restarts && !solver.done(); ++k) {
      const Vector start = other_start(z0, k);
      solver.run(fischer_burmeister, start, "restart", most);
      if (!solver.done()) solver.run(min_map, start, "restart", most);
    }
    if (options.use_ipopt) solver.ipopt_stage(z0);
  }
  if (solver.done()) solver.best.status = NcpStatus::Solved;
  if (solver.best.z.size() != n) solver.best.z = z0, solver.best.w = w0;
  return solver.best;
}

}  // namespace perp
