// The admissible reactions of one block, K, in a column of R rows, and what the solvers ask of them.
//
//   K = {r : r_N >= 0, r_g in r_N E_g for each group g of rows}                               (1)
// E_g an ellipsoid about the origin: T1, T2 and torsion are one group, the rolling rows another; a block without a normal row
// has 1 in the place of r_N. No kinds are told apart here: a row that a block does not have has an axis of length zero.
#pragma once

#include <array>
#include <vector>

#include "solve/blocks/ellipsoid.hpp"
#include "solve/blocks/layout.hpp"

namespace perp {

template <int R>
using Column = Eigen::Matrix<double, R, 1>;  ///< the rows of one block
template <int R>
using Square = Eigen::Matrix<double, R, R>;
template <int R>
using Columns = Eigen::Matrix<double, R, Eigen::Dynamic>;  ///< one column a block
template <int R>
using Squares = std::vector<Square<R>>;

/// Rows of one ellipsoid among the R.
struct RowGroup {
  int first, size;
};

template <int R>
struct RowGroups;
template <>
struct RowGroups<3> {
  static constexpr std::array<RowGroup, 1> all{{{1, 2}}};
};
template <>
struct RowGroups<6> {
  static constexpr std::array<RowGroup, 2> all{{{1, 3}, {4, 2}}};
};

template <int R>
struct Block {
  bool contact = true;                 ///< (1) with its normal row; else r_N = 1 stands there
  Column<R> axes = Column<R>::Zero();  ///< semi-axes; of the normal row 0
  double radius =
      0;  ///< of the disc, if R = 3 and the tangential rows are alike or one alone; NaN for other friction
  int tangents = 2;  ///< R = 3: tangential rows that there are, T1 first

  bool planar() const { return tangents == 1; }
  bool frictionless() const { return radius == 0; }
  bool is_disc() const { return radius > 0; }
  bool has(const RowGroup& group) const { return axes.segment(group.first, group.size).maxCoeff() > 0; }
  int groups() const;  ///< that have axes

  /// The rows of a group, with zeros behind.
  static Vector3 rows(const Column<R>& x, const RowGroup& group) {
    Vector3 z = Vector3::Zero();
    for (int k = 0; k < group.size; ++k) z(k) = x(group.first + k);
    return z;
  }
};

/// Block i of a problem in its own units, and with its rows scaled: r = s sigma r~, s (R) > 0.
template <int R>
Block<R> make_block(const FrictionProblem& problem, Eigen::Index i);
template <int R>
Block<R> make_block(const FrictionProblem& problem, Eigen::Index i, const Column<R>& s, double sigma);

/// û = u + sum_g |diag(axes) u_g| e_N, the velocity with the De Saxcé term [DSF98]. A bound of constant size has none.
template <int R>
Column<R> augmented_velocity(const Block<R>& block, const Column<R>& u);

/// d û_N / du, zero where the velocity of a group is.
template <int R>
Column<R> slip_gradient(const Block<R>& block, const Column<R>& u);

/// P > 0 of a contact with one group: with the longest axis a, P = (√a, √a/axes) maps K to the circular cone of slope 1 by P r, and
/// K* by P^-1 û. Rows without an axis have 1/√a.
template <int R>
Column<R> cone_scaling(const Block<R>& block);

/// The Euclidean projection of z onto K. With n = r_N it is the least of (n - z_N)²/2 + sum_g dist²(z_g, n E_g)/2, whose
/// derivative n - z_N - sum_g t_g/n rises (t_g the multipliers of the ellipsoids' projections): one root, or n = 0.
template <int R>
Column<R> project_block(const Block<R>& block, const Column<R>& z);

/// The projection of Alart and Curnier: z_N onto the half line, then each z_g onto z_N E_g [AC91]; r = p(r - u) holds exactly
/// for solutions. P is a generalised derivative of p at z.
template <int R>
void alart_curnier_projection(const Block<R>& block, const Column<R>& z, Column<R>& p, Square<R>& P);

}  // namespace perp
