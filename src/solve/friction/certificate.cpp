#include "solve/friction/certificate.hpp"

#include <algorithm>
#include <Eigen/Cholesky>
#include <vector>

#include "solve/friction/friction_stages.hpp"

namespace perp {
namespace {

/// min over y >= 0 of yᵀ Q y - 2 cᵀ y by Lawson and Hanson's active set [LH74, ch. 23], Q = W_NN + q_N q_Nᵀ.
Vector nonnegative_quadratic(const Matrix& Q, const Vector& c) {
  const Eigen::Index n = c.size();
  Vector y = Vector::Zero(n), gradient = c;
  std::vector<int> passive;
  std::vector<char> is_passive(n, false);
  for (int outer = 0; outer < 3 * n + 10; ++outer) {
    int enter = -1;
    double steepest = 1e-12;
    for (int i = 0; i < n; ++i)
      if (!is_passive[i] && gradient(i) > steepest) steepest = gradient(i), enter = i;
    if (enter < 0) break;
    is_passive[enter] = true;
    passive.push_back(enter);
    for (;;) {
      const auto size = static_cast<Eigen::Index>(passive.size());
      Matrix part(size, size);
      Vector rhs(size);
      for (int i = 0; i < size; ++i) {
        rhs(i) = c(passive[i]);
        for (int j = 0; j < size; ++j) part(i, j) = Q(passive[i], passive[j]);
      }
      const Vector z = part.ldlt().solve(rhs);
      double t = 1;
      for (int i = 0; i < size; ++i)
        if (z(i) <= 0) t = std::min(t, y(passive[i]) / (y(passive[i]) - z(i)));
      if (!(t >= 0) || !z.allFinite()) return y;
      for (int i = 0; i < size; ++i) y(passive[i]) += t * (z(i) - y(passive[i]));
      if (t >= 1) break;
      std::vector<int> kept;
      for (const int i : passive) {
        if (y(i) > 1e-14 * y.maxCoeff())
          kept.push_back(i);
        else
          is_passive[i] = false, y(i) = 0;
      }
      if (kept.size() == passive.size() || kept.empty()) return y;
      passive = std::move(kept);
    }
    gradient = c - Q * y;
  }
  return y;
}

}  // namespace

template <int R>
Vector infeasibility_certificate(const FrictionProblem& local, const ContactSystem<R>& system) {
  constexpr double null_tolerance = 1e-10;  // |Wᵀ y|/|y| in the scaled problem
  constexpr double negative = -1e-6;        // qᵀ y/|y|, with |q| = 1
  constexpr int largest = 2000;             // contacts; the dense active set costs n³
  std::vector<int> contacts;
  for (int i = 0; i < system.n; ++i)
    if (system.block[i].contact) contacts.push_back(i);
  const auto n = static_cast<Eigen::Index>(contacts.size());
  if (n == 0 || n > largest) return {};
  const Matrix W = system.W->dense();
  Matrix Q(n, n);
  Vector q(n);
  for (int i = 0; i < n; ++i) {
    q(i) = system.q(0, contacts[i]);
    for (int j = 0; j < n; ++j)
      Q(i, j) = (W(R * contacts[i], R * contacts[j]) + W(R * contacts[j], R * contacts[i])) / 2;
  }
  if (q.minCoeff() >= 0) return {};  // r = 0 solves
  // yᵀ W y + (qᵀ y + 1)² = yᵀ (W + q qᵀ) y + 2 qᵀ y + 1
  Vector y = nonnegative_quadratic(Q + q * q.transpose(), -q);
  if (!(y.norm() > 0)) return {};
  y /= y.norm();
  Vector full = Vector::Zero(R * system.n);
  for (int i = 0; i < n; ++i) full(R * contacts[i]) = y(i);
  if (!((W.transpose() * full).norm() < null_tolerance) || !(q.dot(y) < negative)) return {};
  // in the problem's own units the row scale goes over to y
  const std::vector<Eigen::Index> offsets = local.offsets();
  Vector certificate = Vector::Zero(offsets.back());
  for (int i = 0; i < n; ++i) certificate(offsets[contacts[i]]) = y(i) * system.s(0, contacts[i]);
  return certificate;
}

template <int R>
Vector existence_certificate(const FrictionProblem& problem, ContactSystem<R>& system) {
  constexpr double rooms[] = {0.1, 1e-2, 1e-3, 1e-4};  // asked for, beside |q| = 1
  constexpr double symmetric = 1e-10;                  // |W - Wᵀ|/|W|
  if (!problem.is_global()) {
    const SparseMatrix W = problem.W.to_sparse();
    if (!(SparseMatrix(W - SparseMatrix(W.transpose())).norm() <= symmetric * W.norm())) return {};
  }
  const Columns<R> q = system.q;
  Vector certificate;
  system.associated = true;
  for (const double room : rooms) {
    for (int i = 0; i < system.n; ++i)
      if (system.block[i].contact) system.q(0, i) = q(0, i) - room;
    Iterate<R> point;
    point.r = Columns<R>::Zero(R, system.n);
    evaluate(system, point);
    Budget budget;
    interior_point(system, {.most = 100, .start = 1}, 1e-3 * room, budget, point);
    bool inside = point.u.allFinite();
    for (int i = 0; i < system.n && inside; ++i) {
      const Column<R> u = point.u.col(i);
      const double slip = augmented_velocity(system.block[i], u)(0) - u(0);
      inside = !system.block[i].contact || u(0) + room > slip + room / 2 + round_off(point.r.norm());
    }
    if (!inside) continue;
    const std::vector<Eigen::Index> offsets = problem.offsets();
    certificate = Vector(offsets.back());
    for (int i = 0; i < system.n; ++i) {
      Column<R> u = point.u.col(i);
      if (system.block[i].contact) u(0) += room;
      for (int k = 0; k < system.layout[i]->rows; ++k) {
        const int place = system.layout[i]->place[k];
        certificate(offsets[i] + k) = u(place) * (system.sigma / system.s(place, i));
      }
    }
    break;
  }
  system.associated = false;
  system.q = q;
  return certificate;
}

template Vector infeasibility_certificate(const FrictionProblem&, const ContactSystem<3>&);
template Vector infeasibility_certificate(const FrictionProblem&, const ContactSystem<6>&);
template Vector existence_certificate(const FrictionProblem&, ContactSystem<3>&);
template Vector existence_certificate(const FrictionProblem&, ContactSystem<6>&);

}  // namespace perp
