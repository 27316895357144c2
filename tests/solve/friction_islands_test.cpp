// Problems that fall apart: the global form, taken apart along bodies and joints, against the local one.
#include <catch2/catch.hpp>

#include "friction_examples.hpp"

namespace perp {
namespace {

/// Up to six bodies, eight contacts of every kind between any two of them or none, two bilateral rows; dense or sparse.
FrictionProblem random_bodies(unsigned seed) {
  Draw draw(seed);
  const int bodies = draw.integer(1, 6), contacts = draw.integer(1, 8), joints = draw.integer(0, 2);
  const int n = 6 * bodies;
  Matrix M = Matrix::Zero(n, n), H = Matrix::Zero(n, 0), G = Matrix::Zero(n, joints);
  for (int b = 0; b < bodies; ++b) {
    const Matrix A = draw.matrix(6, 6);
    M.block<6, 6>(6 * b, 6 * b) = A * A.transpose() + 0.3 * Matrix::Identity(6, 6);
  }
  const auto tie = [&](Matrix& columns, Eigen::Index first, int rows) {
    for (const int sign : {-1, 1})
      if (const int body = draw.integer(-1, bodies - 1); body >= 0)
        columns.block(6 * body, first, 6, rows) += sign * draw.matrix(6, rows);
  };
  FrictionProblem problem;
  for (int i = 0; i < contacts; ++i) {
    problem.kinds.push_back(static_cast<BlockKind>(draw.integer(0, 3)));
    const int rows = block_rows(problem.kinds.back());
    H.conservativeResize(Eigen::NoChange, H.cols() + rows);
    H.rightCols(rows).setZero();
    tie(H, H.cols() - rows, rows);
  }
  for (int j = 0; j < joints; ++j) {
    while (G.col(j).isZero(0)) tie(G, j, 1);
  }
  const bool sparse = draw.integer(0, 1) == 1;
  const auto given = [&](const Matrix& A) {
    return sparse ? FrictionMatrix(SparseMatrix(A.sparseView())) : FrictionMatrix(A);
  };
  problem.M = given(M);
  problem.H = given(H);
  if (joints > 0) problem.G = given(G);
  problem.f = draw.matrix(n, 1);
  problem.w = 0.5 * draw.matrix(H.cols(), 1);
  problem.b = 0.2 * draw.matrix(joints, 1);
  problem.mu = draw.matrix(contacts, 1).cwiseAbs();
  return problem;
}

}  // namespace

TEST_CASE("contacts between any bodies, jointed or not, end as they do in the local form", "[friction]") {
  int solved = 0, none = 0;
  for (unsigned seed = 0; seed < 600; ++seed) {
    const FrictionProblem problem = random_bodies(seed);
    const FrictionSolution apart = solve_friction(problem, {.use_ipopt = false});
    const FrictionSolution local = solve_friction(to_local(problem), {.use_ipopt = false});
    CAPTURE(seed, apart.residual, local.residual);
    CHECK(apart.status == local.status);
    if (apart.solved() && local.solved()) CHECK((apart.u - local.u).norm() <= 1e-6 * (1 + local.u.norm()));
    solved += apart.solved();
    none += apart.status == FrictionStatus::NoSolution;
  }
  CHECK(solved > 450);
  CHECK(none > 40);
}

}  // namespace perp
