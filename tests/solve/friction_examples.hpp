// Contact problems made for tests, and a second opinion on their answers.
#pragma once

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

#include "perp/solve/friction_solver.hpp"

namespace perp {

/// Uniform numbers that are the same under every standard library.
class Draw {
 public:
  explicit Draw(unsigned seed) : engine_(seed) {}
  double uniform(double low, double high) {
    return low + (high - low) * static_cast<double>(engine_() >> 11) * 0x1p-53;
  }
  int integer(int low, int high) {
    return low + static_cast<int>(engine_() % static_cast<unsigned>(high - low + 1));
  }
  Matrix matrix(Eigen::Index rows, Eigen::Index cols) {
    Matrix A(rows, cols);
    for (Eigen::Index j = 0; j < cols; ++j)
      for (Eigen::Index i = 0; i < rows; ++i) A(i, j) = uniform(-1, 1);
    return A;
  }

 private:
  std::mt19937_64 engine_;
};

/// W = H^T H of any rank, q anything, mu from 0 to 10: some have no solution.
inline FrictionProblem random_friction_problem(unsigned seed) {
  Draw draw(seed);
  const int contacts = draw.integer(1, 8), m = 3 * contacts;
  const Matrix H = draw.matrix(draw.integer(1, m + 2), m);
  FrictionProblem problem;
  problem.W = Matrix(H.transpose() * H);
  problem.q = draw.matrix(m, 1) * std::pow(10.0, draw.uniform(-3, 3));
  problem.mu.resize(contacts);
  for (int i = 0; i < contacts; ++i) {
    const int which = draw.integer(0, 5);
    problem.mu(i) = which == 0 ? 0 : which == 1 ? 10 : which == 2 ? 1e-6 : draw.uniform(0, 1.5);
  }
  return problem;
}

/// A step of 10 ms of discs of 1 kg in the plane: layers between walls, each disc on two below, pushed about; in the reduced form, with
/// 160 to 370 contacts.
inline FrictionProblem disc_pile(unsigned seed) {
  Draw draw(seed);
  constexpr double radius = 0.5, pitch = 2.1 * radius, h = 0.01;
  const double rise = std::sqrt(4 * radius * radius - pitch * pitch / 4);
  const int across = draw.integer(8, 12), layers = draw.integer(11, 15);
  const double mu = draw.uniform(0.1, 0.8);
  std::vector<Vector2> centre;
  for (int layer = 0; layer < layers; ++layer)
    for (int k = 0; k < across - layer % 2; ++k)
      centre.emplace_back(pitch * (k + 0.5 * (layer % 2)), radius + rise * layer);
  const int bodies = static_cast<int>(centre.size());
  std::vector<Eigen::Triplet<double>> entries;
  int contacts = 0;
  const auto act_on = [&](int body, double sign, const Vector2& n, const Vector2& t) {
    for (int k = 0; k < 2; ++k) {
      entries.emplace_back(3 * body + k, 2 * contacts, sign * n[k]);
      entries.emplace_back(3 * body + k, 2 * contacts + 1, sign * t[k]);
    }
    entries.emplace_back(3 * body + 2, 2 * contacts + 1, radius);
  };
  const auto add = [&](int a, int b, const Vector2& n) {  // n from a (-1: a wall) to b
    const Vector2 t(n.y(), -n.x());
    act_on(b, 1, n, t);
    if (a >= 0) act_on(a, -1, n, t);
    ++contacts;
  };
  for (int b = 0; b < bodies; ++b) {
    const Vector2& c = centre[static_cast<std::size_t>(b)];
    if (c.y() < 1.1 * radius) add(-1, b, {0, 1});
    if (c.x() < 0.1 * radius) add(-1, b, {1, 0});
    if (c.x() > pitch * (across - 1.1)) add(-1, b, {-1, 0});
    for (int a = 0; a < b; ++a) {
      const Vector2 apart = c - centre[static_cast<std::size_t>(a)];
      if (apart.norm() < 2.02 * radius) add(a, b, apart.normalized());
    }
  }
  SparseMatrix H(3 * bodies, 2 * contacts);
  H.setFromTriplets(entries.begin(), entries.end());
  Vector inverse_mass(3 * bodies), v(3 * bodies);
  for (int b = 0; b < bodies; ++b) {
    inverse_mass.segment<3>(3 * b) << 1, 1, 2 / (radius * radius);
    v.segment<3>(3 * b) << draw.uniform(-0.01, 0.01), -9.81 * h, draw.uniform(-0.01, 0.01);
  }
  FrictionProblem problem;
  problem.W = SparseMatrix(H.transpose() * SparseMatrix(inverse_mass.asDiagonal() * H));
  problem.q = H.transpose() * v;
  problem.mu = Vector::Constant(contacts, mu);
  return problem;
}

/// What residual.relative and .absolute must be, worked out here from W, q and mu of cones alone.
struct SecondOpinion {
  double relative, absolute;
};

inline SecondOpinion second_opinion(const FrictionProblem& problem, const Vector& r) {
  const Matrix W = problem.W.to_dense();
  const Eigen::Index contacts = problem.mu.size();
  Vector scaled_q = problem.q, s(contacts);
  for (Eigen::Index i = 0; i < contacts; ++i) {
    s(i) = 1 / std::sqrt(W.block<3, 3>(3 * i, 3 * i).trace() / 3);
    scaled_q.segment<3>(3 * i) *= s(i);
  }
  const double sigma = scaled_q.norm() > 0 ? scaled_q.norm() : 1;
  const Vector u = W * r + problem.q;
  double map = 0, size = 0;
  for (Eigen::Index i = 0; i < contacts; ++i) {
    const double mu = problem.mu(i);
    const Vector3 r_i = r.segment<3>(3 * i) / (s(i) * sigma), u_i = u.segment<3>(3 * i) * (s(i) / sigma);
    const double slip = std::hypot(u_i(1), u_i(2));
    const double n = r_i(0) - u_i(0) - mu * slip, t1 = r_i(1) - u_i(1), t2 = r_i(2) - u_i(2);
    const double t = std::hypot(t1, t2);
    Vector3 p(n, t1, t2);
    if (t > mu * n) {
      const double foot = std::max(0.0, (n + mu * t) / (1 + mu * mu));
      p = Vector3(foot, mu * foot * t1 / t, mu * foot * t2 / t);
    }
    map += (r_i - p).squaredNorm();
    size += r_i.squaredNorm();
  }
  return {std::sqrt(map) / std::max(1.0, std::sqrt(size)), std::sqrt(map)};
}

/// A 1 kg cube of 1 m at rest on a plane, under `force` for the time h = 1 s, seen at the corners of its lower face.
inline FrictionProblem cube_on_plane(const Vector3& force, double mu, double mass = 1) {
  FrictionProblem problem;
  Matrix M = Matrix::Identity(6, 6) * mass, H = Matrix::Zero(6, 12);
  M.bottomRightCorner(3, 3) /= 6;
  const Vector3 axes[3] = {Vector3::UnitZ(), Vector3::UnitX(), Vector3::UnitY()};
  for (int corner = 0; corner < 4; ++corner) {
    const Vector3 arm(corner % 2 == 0 ? -0.5 : 0.5, corner < 2 ? -0.5 : 0.5, -0.5);
    for (int k = 0; k < 3; ++k) {
      H.block<3, 1>(0, 3 * corner + k) = axes[k];
      H.block<3, 1>(3, 3 * corner + k) = arm.cross(axes[k]);
    }
  }
  problem.M = M;
  problem.H = H;
  problem.f = Vector::Zero(6);
  problem.f.head(3) = force;
  problem.w = Vector::Zero(12);
  problem.mu = Vector::Constant(4, mu);
  return problem;
}

}  // namespace perp
