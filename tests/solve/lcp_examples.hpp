// LCPs that the tests of this folder draw or know.
#pragma once

#include <cmath>
#include <random>

#include "perp/solve/lcp.hpp"

namespace perp {

inline Matrix random_matrix(std::mt19937& draw, int rows, int cols) {
  std::uniform_real_distribution<double> uniform(-1, 1);
  Matrix M(rows, cols);
  for (double& entry : M.reshaped()) entry = uniform(draw);
  return M;
}

inline Vector random_vector(std::mt19937& draw, int n) { return random_matrix(draw, n, 1); }

/// A = G Gᵀ + I/10 + K with K skew: positive definite, not symmetric, hence a P-matrix.
inline Lcp positive_definite_lcp(unsigned seed, int n) {
  std::mt19937 draw(seed);
  const Matrix G = random_matrix(draw, n, n), K = random_matrix(draw, n, n);
  return {G * G.transpose() + 0.1 * Matrix::Identity(n, n) + K - K.transpose(), random_vector(draw, n)};
}

/// A path through all 2^n bases [Mur78]: A lower triangular, 1 on and 2 below the diagonal.
inline Lcp murty_lcp(int n) {
  Lcp lcp{Matrix::Identity(n, n), -Vector::Ones(n)};
  for (int i = 0; i < n; ++i) lcp.A.row(i).head(i).setConstant(2);
  return lcp;
}

/// Two players' costs P, Q > 0: 0 <= x ⟂ P y - e >= 0, 0 <= y ⟂ Q x - e >= 0. Always has a solution; Lemke's path ends
/// on a ray at its first pivot for every d > 0, since the first z to enter has zero in the row of z0.
inline Lcp bimatrix_game(unsigned seed, int n) {
  std::mt19937 draw(seed);
  Lcp lcp{Matrix::Zero(2 * n, 2 * n), -Vector::Ones(2 * n)};
  lcp.A.topRightCorner(n, n) = random_matrix(draw, n, n).array() + 2;
  lcp.A.bottomLeftCorner(n, n) = random_matrix(draw, n, n).array() + 2;
  return lcp;
}

/// One step of `count` unit cubes, one on the other, touching at the corners of their faces, with a friction polygon of
/// `edges` directions: A = [W_nn W_nf 0; W_fn W_ff E; mu -Eᵀ 0] of 4 count (edges + 2) rows, scaled to diagonal 1.
/// Copositive; W has rank 6 count at most, so most bases are singular and at rest most ratios tie.
inline Lcp cube_stack_lcp(int count, int edges, double mu, const Vector& nu) {
  const int nv = 6 * count, nc = 4 * count, rows = nc * (1 + edges), n = rows + nc;
  Matrix J = Matrix::Zero(nv, rows);  // wrenches: normals, then directions contact by contact
  const auto wrench = [&](int cube, double height, double sign, const Vector3& d, int corner, int column) {
    if (cube < 0) return;
    const Vector3 r(corner & 1 ? 0.5 : -0.5, corner & 2 ? 0.5 : -0.5, height);
    J.col(column).segment<3>(6 * cube) = sign * d;
    J.col(column).segment<3>(6 * cube + 3) = sign * r.cross(d);
  };
  for (int i = 0; i < nc; ++i) {
    for (int e = -1; e < edges; ++e) {
      const double angle = 2 * M_PI * e / edges;
      const Vector3 d = e < 0 ? Vector3(0, 0, 1) : Vector3(std::cos(angle), std::sin(angle), 0);
      const int column = e < 0 ? i : nc + i * edges + e;
      wrench(i / 4, -0.5, 1, d, i % 4, column);
      wrench(i / 4 - 1, 0.5, -1, d, i % 4, column);
    }
  }
  Vector inverse_mass = Vector::Ones(nv);
  for (int k = 0; k < count; ++k) inverse_mass.segment<3>(6 * k + 3).setConstant(6);  // m = 1, J = 1/6

  Lcp lcp{Matrix::Zero(n, n), Vector::Zero(n)};
  lcp.A.topLeftCorner(rows, rows) = J.transpose() * inverse_mass.asDiagonal() * J;
  lcp.b.head(rows) = J.transpose() * nu;
  Vector scale = Vector::Ones(n);
  for (int i = 0; i < rows; ++i) scale[i] = 1 / std::sqrt(lcp.A(i, i));
  for (int i = 0; i < nc; ++i) {
    lcp.A(rows + i, i) = mu;
    for (int e = 0; e < edges; ++e) {
      lcp.A(nc + i * edges + e, rows + i) = 1;
      lcp.A(rows + i, nc + i * edges + e) = -1;
    }
    scale[rows + i] = 1 / scale[nc + i * edges];
  }
  return {scale.asDiagonal() * lcp.A * scale.asDiagonal(), scale.cwiseProduct(lcp.b)};
}

}  // namespace perp
