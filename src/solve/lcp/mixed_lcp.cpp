#include "perp/solve/mixed_lcp.hpp"

#include <algorithm>
#include <cmath>
#include <Eigen/QR>
#include <numeric>
#include <string>
#include <vector>

#include "perp/core/errors.hpp"
#include "solve/linear/equilibrate.hpp"

namespace perp {
namespace {

using Eigen::Index;
using Indices = std::vector<Index>;

constexpr double zero_pivot = 1e-11;  // of a scaled matrix: counts as zero
constexpr double consistent = 1e-9;   // of max(1, |a|, |b|), scaled: what is left of a redundant equation

void check(const MixedLcp& p) {
  const Index n = p.a.size(), m = p.b.size();
  const auto shape = [](const char* name, const Matrix& M, Index rows, Index cols) {
    const auto pair = [](Index i, Index j) {
      return "(" + std::to_string(i) + ", " + std::to_string(j) + ")";
    };
    if (M.rows() != rows || M.cols() != cols)
      refuse("solve_mixed_lcp", name, pair(M.rows(), M.cols()), pair(rows, cols) + " is needed");
    if (!M.allFinite()) refuse("solve_mixed_lcp", name, "not finite", "finite entries are needed");
  };
  shape("A", p.A, n, n), shape("C", p.C, n, m), shape("D", p.D, m, n), shape("B", p.B, m, m);
  if (!p.a.allFinite()) refuse("solve_mixed_lcp", "a", "not finite", "finite entries are needed");
  if (!p.b.allFinite()) refuse("solve_mixed_lcp", "b", "not finite", "finite entries are needed");
}

Matrix whole(const MixedLcp& p) {
  const Index n = p.a.size(), m = p.b.size();
  Matrix K(n + m, n + m);
  K << p.A, p.C, p.D, p.B;
  return K;
}

Vector concatenate(const Vector& x, const Vector& y) {
  Vector both(x.size() + y.size());
  both << x, y;
  return both;
}

// The dictionary (e; w) = K (u; v) + k and exchanges in it. Variables: e is 0..n-1, w n..N-1, u N..N+n-1, v the rest.
struct Dictionary {
  Index n, N;
  Matrix T;
  Vector t;
  Indices basic, nonbasic;  // variable of a row, of a column

  Dictionary(Matrix K, Vector k, Index equations)
      : n(equations), N(k.size()), T(std::move(K)), t(std::move(k)), basic(size()), nonbasic(size()) {
    std::iota(basic.begin(), basic.end(), Index{0});
    std::iota(nonbasic.begin(), nonbasic.end(), N);
  }
  size_t size() const { return static_cast<size_t>(N); }
  bool is_equation(Index row) const { return basic[static_cast<size_t>(row)] < n; }
  bool is_free(Index column) const {
    const Index variable = nonbasic[static_cast<size_t>(column)];
    return N <= variable && variable < N + n;
  }

  void exchange(Index r, Index s) {
    const double p = T(r, s);
    const Eigen::RowVectorXd row = T.row(r) / -p;
    const Vector column = T.col(s);
    const double constant = t[r] / -p;
    T += column * row;
    T.row(r) = row;
    T.col(s) = column / p;
    T(r, s) = 1 / p;
    t += column * constant;
    t[r] = constant;
    std::swap(basic[static_cast<size_t>(r)], nonbasic[static_cast<size_t>(s)]);
  }
};

// Exchanges equations for the u they depend on, the largest pivot first.
void eliminate(Dictionary& d) {
  for (;;) {
    double largest = zero_pivot;
    Index row = -1, column = -1;
    for (Index s = 0; s < d.N; ++s)
      for (Index r = 0; d.is_free(s) && r < d.N; ++r)
        if (d.is_equation(r) && std::abs(d.T(r, s)) > largest)
          largest = std::abs(d.T(r, s)), row = r, column = s;
    if (row < 0) return;
    d.exchange(row, column);
  }
}

// The equations left over depend on v alone. Exchanges such an equation for a v_j, and w_j for a u left over; false
// if none is left over. Row and column of pair j are n + j until then.
bool exchange_pair(Dictionary& d) {
  double best = zero_pivot;
  Index pair = -1, row = -1, column = -1;
  for (Index j = d.n; j < d.N; ++j) {
    const auto k = static_cast<size_t>(j);
    if (d.basic[k] != j || d.nonbasic[k] != d.N + j) continue;
    Index i = -1, u = -1;
    double of_equation = 0, of_u = 0;
    for (Index r = 0; r < d.N; ++r)
      if (d.is_equation(r) && std::abs(d.T(r, j)) > of_equation) of_equation = std::abs(d.T(r, j)), i = r;
    for (Index s = 0; s < d.N; ++s)
      if (d.is_free(s) && std::abs(d.T(j, s)) > of_u) of_u = std::abs(d.T(j, s)), u = s;
    if (std::min(of_equation, of_u) > best) best = std::min(of_equation, of_u), pair = j, row = i, column = u;
  }
  if (pair < 0) return false;
  d.exchange(row, pair);
  d.exchange(pair, column);
  return true;
}

// What the equations and u that are left over say: nothing, that there is no solution, or that they have to be split.
enum class LeftOver { Nothing, Contradiction, Coupled };

LeftOver left_over(const Dictionary& d) {
  LeftOver answer = LeftOver::Nothing;
  const double scale = std::max(1.0, d.t.lpNorm<Eigen::Infinity>());
  for (Index r = 0; r < d.N; ++r) {
    if (!d.is_equation(r)) continue;
    double largest = 0;  // over what is not an equation exchanged, hence zero
    for (Index s = 0; s < d.N; ++s)
      if (d.nonbasic[static_cast<size_t>(s)] >= d.n) largest = std::max(largest, std::abs(d.T(r, s)));
    if (largest > zero_pivot) answer = LeftOver::Coupled;
    if (largest <= zero_pivot && std::abs(d.t[r]) > consistent * scale) return LeftOver::Contradiction;
  }
  for (Index s = 0; s < d.N; ++s)
    for (Index r = 0; d.is_free(s) && r < d.N; ++r)
      if (d.basic[static_cast<size_t>(r)] < d.N && std::abs(d.T(r, s)) > zero_pivot)
        answer = LeftOver::Coupled;
  return answer;
}

// Solves the pairs' LCP and reads u and v off the dictionary; u left over, and equations, are zero.
Vector solve_pairs(const Dictionary& d, const LcpOptions& options, MixedLcpSolution& out) {
  Indices rows, columns;  // of pair j, in order
  const auto find = [](const Indices& among, Index one, Index other) {
    return std::find_if(among.begin(), among.end(), [=](Index x) { return x == one || x == other; }) -
           among.begin();
  };
  for (Index j = d.n; j < d.N; ++j) {
    rows.push_back(find(d.basic, j, d.N + j));
    columns.push_back(find(d.nonbasic, j, d.N + j));
  }
  const LcpSolution pairs = solve_lcp({d.T(rows, columns), d.t(rows)}, options);
  out.status = pairs.status;
  out.pivots += pairs.pivots;

  Vector x = Vector::Zero(d.N);  // (u; v)
  for (Index r = 0; r < d.N; ++r) {
    const Index variable = d.basic[static_cast<size_t>(r)];
    if (variable >= d.N) x[variable - d.N] = d.t[r] + d.T(r, columns).dot(pairs.z);
  }
  for (size_t j = 0; j < columns.size(); ++j) {
    const Index variable = d.nonbasic[static_cast<size_t>(columns[j])];
    if (variable >= d.N) x[variable - d.N] = pairs.z[static_cast<Index>(j)];
  }
  return x;
}

// u = u⁺ - u⁻: an LCP of 2 n + m.
Vector solve_split(const Matrix& K, const Vector& k, Index n, const LcpOptions& options,
                   MixedLcpSolution& out) {
  const Index m = k.size() - n;
  Lcp split{Matrix(2 * n + m, 2 * n + m), Vector(2 * n + m)};
  const auto A = K.topLeftCorner(n, n), C = K.topRightCorner(n, m);
  const auto D = K.bottomLeftCorner(m, n), B = K.bottomRightCorner(m, m);
  split.A << A, -A, C, -A, A, -C, D, -D, B;
  split.b << k.head(n), -k.head(n), k.tail(m);
  const LcpSolution solution = solve_lcp(split, options);
  out.status = solution.status;
  out.pivots += solution.pivots;
  return concatenate(solution.z.head(n) - solution.z.segment(n, n), solution.z.tail(m));
}

// Once more from the data: the shortest correction of u and of the v_i in use that meets (1) and w_i = 0 for these.
Vector corrected(const Matrix& K, const Vector& k, Index n, const Vector& x) {
  Indices used;
  const Vector w = K * x + k;
  for (Index i = 0; i < k.size(); ++i)
    if (i < n || x[i] > w[i]) used.push_back(i);
  if (used.empty()) return x;
  const Eigen::CompleteOrthogonalDecomposition<Matrix> factors(K(used, used));
  Vector y = x;
  for (Index i = n; i < k.size(); ++i)
    if (x[i] <= w[i]) y[i] = 0;
  for (int round = 0; round < 2; ++round) {
    const Vector miss = K(used, Eigen::all) * y + k(used);
    y(used) -= factors.solve(miss);
  }
  return y;
}

}  // namespace

double mixed_lcp_residual(const MixedLcp& p, const Vector& u, const Vector& v) {
  const Vector equations = p.A * u + p.C * v + p.a, pairs = (p.D * u + p.B * v + p.b).cwiseMin(v);
  return concatenate(equations, pairs).lpNorm<Eigen::Infinity>();
}

double mixed_lcp_relative_residual(const MixedLcp& p, const Vector& u, const Vector& v) {
  const double residual = mixed_lcp_residual(p, u, v);
  if (residual == 0) return 0;
  return residual /
         (whole(p).cwiseAbs() * concatenate(u, v).cwiseAbs() + concatenate(p.a, p.b).cwiseAbs()).maxCoeff();
}

MixedLcpSolution solve_mixed_lcp(const MixedLcp& problem, const LcpOptions& options) {
  check(problem);
  const Index n = problem.a.size(), m = problem.b.size();
  MixedLcpSolution solution;
  solution.u = Vector::Zero(n), solution.v = Vector::Zero(m);
  const Scaling scaling = equilibrate(whole(problem), false);
  const Matrix K = scaling.apply(whole(problem));
  const Vector k = scaling.r.cwiseProduct(concatenate(problem.a, problem.b));

  Dictionary dictionary(K, k, n);
  eliminate(dictionary);
  solution.stage = "elimination";
  while (exchange_pair(dictionary)) solution.stage = "exchange";
  Vector x = Vector::Zero(n + m);
  switch (left_over(dictionary)) {
    case LeftOver::Nothing:
      x = solve_pairs(dictionary, options, solution);
      break;
    case LeftOver::Contradiction:
      solution.status = LcpStatus::NoSolution;
      break;
    case LeftOver::Coupled:
      solution.stage = "split";
      x = solve_split(K, k, n, options, solution);
      break;
  }
  if (solution.solved() || solution.status == LcpStatus::Inaccurate) {
    const auto keep = [&](const Vector& y) {
      const Vector u = scaling.c.head(n).cwiseProduct(y.head(n)),
                   v = scaling.c.tail(m).cwiseProduct(y.tail(m)).cwiseMax(0.0);
      const double residual = mixed_lcp_residual(problem, u, v);
      if (!(solution.residual <= residual)) solution.u = u, solution.v = v, solution.residual = residual;
    };
    keep(x);
    keep(corrected(K, k, n, x));
    const bool good = mixed_lcp_relative_residual(problem, solution.u, solution.v) <= options.tolerance;
    solution.status = good ? LcpStatus::Solved : LcpStatus::Inaccurate;
  }
  solution.residual = mixed_lcp_residual(problem, solution.u, solution.v);
  return solution;
}

}  // namespace perp
