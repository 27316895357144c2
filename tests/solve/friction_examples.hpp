// Contact problems made for tests, and a second opinion on their answers.
#pragma once

#include <algorithm>
#include <cmath>
#include <random>

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
