// Josephy and Newton's method for a step: the bodies' equations linearised, the cones left as they are.
#include <array>
#include <Eigen/LU>
#include <Eigen/QR>

#include "core/index.hpp"
#include "perp/solve/friction_solver.hpp"
#include "step/implicit/nonsmooth_newton.hpp"
#include "step/parts/contact_blocks.hpp"

namespace perp {
namespace {

constexpr Eigen::Index most_dense_rows = 240;  // of contacts; beyond, the sparse form

/// The columns of reaction i that are rows of the problem; of moments those that their contact has.
struct UsedColumns {
  std::array<int, 3> column{0, 1, 2};
  int count = 0;
};
UsedColumns columns_of(const std::vector<Reaction>& reactions, std::size_t i) {
  const Reaction& r = reactions[i];
  UsedColumns used;
  if (r.law != Law::Moments) {
    const auto [first, rows] = rows_of(r.law);
    for (int j = 0; j < rows; ++j) used.column[at(j)] = first + j;
    used.count = rows;
    return used;
  }
  const auto use = [&](int column) { used.column[at(used.count++)] = column; };
  if (r.torsion > 0) use(0);
  if (r.rolling > 0 && reactions[i - 1].law == Law::Cone) use(1);
  if (r.rolling > 0) use(2);
  return used;
}

/// Where the rows of contacts and joint frictions stand, and what they are now.
struct Rows {
  std::vector<Eigen::Index> first;  // of each reaction; of equalities their place among them
  std::vector<UsedColumns> used;
  Eigen::Index contacts = 0, equalities = 0;
  FrictionProblem problem;
  Vector u, p, u_b, p_b;
  int spent = 0;  // iterations of the chain

  explicit Rows(const std::vector<Reaction>& reactions) {
    ContactBlocks blocks;
    for (std::size_t i = 0; i < reactions.size(); ++i) {
      const Reaction& r = reactions[i];
      Eigen::Index& count = r.law == Law::Equality ? equalities : contacts;
      first.push_back(count);
      used.push_back(columns_of(reactions, i));
      count += used.back().count;
      if (r.law == Law::Equality || r.law == Law::Moments) continue;
      if (!r.has_moments) {
        blocks.add(kind_of(r.law), r.mu);
        continue;
      }
      const Reaction& m = reactions[i + 1];
      blocks.add_with_moments(r.law == Law::Cone ? 2 : 1, r.mu, m.mu_o, m.torsion / m.lever,
                              m.rolling / m.lever);
    }
    blocks.give(problem);
    u.resize(contacts), p.resize(contacts);
    u_b.resize(equalities), p_b.resize(equalities);
    for (std::size_t i = 0; i < reactions.size(); ++i) {
      const Reaction& r = reactions[i];
      Vector &velocity = r.law == Law::Equality ? u_b : u, &impulse = r.law == Law::Equality ? p_b : p;
      for (int j = 0; j < used[i].count; ++j) {
        velocity[first[i] + j] = r.u[used[i].column[at(j)]];
        impulse[first[i] + j] = r.p[used[i].column[at(j)]];
      }
    }
  }

  void give(const Vector& new_p, const Vector& new_p_b, std::vector<Reaction>& reactions) const {
    for (std::size_t i = 0; i < reactions.size(); ++i) {
      Reaction& r = reactions[i];
      const Vector& impulse = r.law == Law::Equality ? new_p_b : new_p;
      for (int j = 0; j < used[i].count; ++j) r.p[used[i].column[at(j)]] = impulse[first[i] + j];
    }
  }
};

/// Calls add(velocity, value) for the entries of column j of W, or of row j of G.
template <class Add>
void wrench_entries(const Reaction& r, int j, const Add& add) {
  for (int k = 0; k < r.W.na; ++k) add(r.W.va + k, r.W.A(k, j));
  for (int k = 0; k < r.W.nb; ++k) add(r.W.vb + k, r.W.B(k, j));
}
template <class Add>
void slope_entries(const Reaction& r, int j, const Add& add) {
  for (int k = 0; k < r.W.na; ++k) add(r.W.va + k, r.G(j, k));
  for (int k = 0; k < r.W.nb; ++k) add(r.W.vb + k, r.G(j, 6 + k));
}

/// With y = nu - nu_k:   K y - W (p - p_k) - W_b (p_b - p_b,k) = -R,   G_b y = -u_b,   u = u_k + G y, in the local form.
bool dense_round(const Model& model, const std::vector<Coupling>& K, const Vector& R, FrictionOptions how,
                 Rows& rows, Vector& nu, std::vector<Reaction>& reactions) {
  const Eigen::Index nv = model.nv(), nb = rows.equalities, m = rows.contacts;
  Matrix A = Matrix::Zero(nv + nb, nv + nb), rhs = Matrix::Zero(nv + nb, m + 1), G = Matrix::Zero(m, nv);
  for (const Coupling& c : K) {
    const Body &row = model.bodies()[at(c.row)], &column = model.bodies()[at(c.column)];
    A.block(row.v0, column.v0, row.nv, column.nv) += c.value.topLeftCorner(row.nv, column.nv);
  }
  for (std::size_t i = 0; i < reactions.size(); ++i) {
    const Reaction& r = reactions[i];
    for (int j = 0; j < rows.used[i].count; ++j) {
      const Eigen::Index k = rows.first[i] + j;
      const int column = rows.used[i].column[at(j)];
      if (r.law == Law::Equality) {
        wrench_entries(r, column, [&](int v, double x) { A(v, nv + k) -= x; });
        slope_entries(r, column, [&](int v, double x) { A(nv + k, v) += x; });
      } else {
        wrench_entries(r, column, [&](int v, double x) { rhs(v, k) += x; });
        slope_entries(r, column, [&](int v, double x) { G(k, v) += x; });
      }
    }
  }
  rhs.col(m).head(nv) = -R;
  rhs.col(m).tail(nb) = -rows.u_b;
  rhs.col(m) -= rhs.leftCols(m) * rows.p;
  const Matrix Y =
      nb > 0 ? Matrix(A.completeOrthogonalDecomposition().solve(rhs)) : Matrix(A.partialPivLu().solve(rhs));
  if (!Y.allFinite()) return false;
  rows.problem.W = Matrix(G * Y.topRows(nv).leftCols(m));
  rows.problem.q = rows.u + G * Y.topRows(nv).col(m);
  how.start = rows.p;
  const FrictionSolution answer = solve_friction(rows.problem, how);
  rows.spent = answer.iterations;
  const Vector y = Y.leftCols(m) * answer.r + Y.col(m);
  nu += y.head(nv);
  rows.give(answer.r, rows.p_b + y.tail(nb), reactions);
  return true;
}

/// The same with M for K and Wᵀ for G, in the global form, which large systems can afford: it converges as fast as the
/// step's geometry changes little.
bool sparse_round(const Model& model, const Instant& instant, const Vector& R, FrictionOptions how,
                  Rows& rows, Vector& nu, std::vector<Reaction>& reactions) {
  const Eigen::Index nv = model.nv();
  std::vector<Eigen::Triplet<double>> M, H, G;
  std::vector<Coupling> mass;
  add_mass(model, instant, mass);
  for (const Coupling& c : mass) {
    const Body& b = model.bodies()[at(c.row)];
    for (int i = 0; i < b.nv; ++i)
      for (int j = 0; j < b.nv; ++j)
        if (c.value(i, j) != 0) M.emplace_back(b.v0 + i, b.v0 + j, c.value(i, j));
  }
  for (std::size_t i = 0; i < reactions.size(); ++i) {
    const Reaction& r = reactions[i];
    for (int j = 0; j < rows.used[i].count; ++j)
      wrench_entries(r, rows.used[i].column[at(j)], [&](int v, double x) {
        (r.law == Law::Equality ? G : H).emplace_back(v, static_cast<int>(rows.first[i]) + j, x);
      });
  }
  const auto sparse = [&](const std::vector<Eigen::Triplet<double>>& entries, Eigen::Index columns) {
    SparseMatrix S(nv, columns);
    S.setFromTriplets(entries.begin(), entries.end());
    return S;
  };
  const SparseMatrix mass_matrix = sparse(M, nv), wrenches = sparse(H, rows.contacts),
                     joints = sparse(G, rows.equalities);
  FrictionProblem& problem = rows.problem;
  problem.M = mass_matrix;
  problem.H = wrenches;
  problem.f = mass_matrix * nu - R - wrenches * rows.p;
  problem.w = rows.u - wrenches.transpose() * nu;
  if (rows.equalities > 0) {
    problem.G = joints;
    problem.f -= joints * rows.p_b;
    problem.b = rows.u_b - joints.transpose() * nu;
  }
  how.start = rows.p;
  const FrictionSolution answer = solve_friction(problem, how);
  rows.spent = answer.iterations;
  if (answer.v.size() != nv || !answer.v.allFinite()) return false;
  nu = answer.v;
  rows.give(answer.r, rows.equalities > 0 ? answer.lambda : rows.p_b, reactions);
  return true;
}

}  // namespace

bool NonsmoothNewton::josephy_newton(const Model& model, StepProblem& problem, const Options& options,
                                     bool ipopt, Vector& nu, std::vector<Reaction>& reactions,
                                     NewtonOutcome& outcome) {
  constexpr int most_rounds = 12;
  constexpr int most_idle_rounds = 2;  // rounds in a row that have not halved the residual
  constexpr double most_work = 2e5;    // rows times iterations of the chain, over all rounds
  constexpr Eigen::Index few = 180;    // rows up to which Ipopt's dense problem is affordable
  FrictionOptions how{.tolerance = options.tolerance, .use_ipopt = false};
  how.method = ipopt ? FrictionMethod::Ipopt : FrictionMethod::Chain;
  double best = infinity, work = 0;
  for (int round = 0, idle = 0; round < most_rounds && idle < most_idle_rounds && work < most_work; ++round) {
    problem.differentiate(reactions, K_);
    Rows rows(reactions);
    if (rows.contacts == 0 || (ipopt && rows.contacts > few)) return false;
    how.max_iterations = 1 + static_cast<int>((most_work - work) / static_cast<double>(rows.contacts));
    const bool found = rows.contacts <= most_dense_rows
                           ? dense_round(model, K_, R_, how, rows, nu, reactions)
                           : sparse_round(model, *instant_, R_, how, rows, nu, reactions);
    work += static_cast<double>(rows.spent) * static_cast<double>(rows.contacts);
    if (!found) return false;
    ++outcome.iterations;
    outcome.solver = ipopt ? "ipopt" : "friction-chain";
    if (!evaluate(model, problem, options, nu, reactions, outcome)) return false;
    if (outcome.converged) return true;
    if (rows.contacts > most_dense_rows) {  // near the answer Newton is faster
      for (Island& island : islands_)
        island.map = island.stalled = 0, island.best = infinity, island.best_good = false;
      Options short_run = options;
      short_run.most = 12;
      if (newton(model, problem, short_run, nu, reactions, outcome)) return true;
    }
    idle = outcome.residuals.largest() < 0.5 * best ? 0 : idle + 1;
    best = std::min(best, outcome.residuals.largest());
  }
  return false;
}

}  // namespace perp
