// An island's discrete-time model with polygonal friction: the seed's LCP(F, f).
#pragma once

#include <vector>

#include "perp/instant/reduced_system.hpp"
#include "perp/solve/lcp.hpp"

namespace perp {

/// What a method may choose about (39): the polygon, and what stands beside W_n^T nu+ in the gap rows.
struct PolygonalTerms {
  const std::vector<Vector2>& polygon;   ///< friction_polygon(n)
  const std::vector<Vector3>& polytope;  ///< friction_polytope(n)
  const Vector& gap_term;  ///< of each contact of the Instant: psi_n/h [m/s] or what stands for it
  double h;                ///< [s]
};

/// The seed's standard LCP (39) for one island, z = (p_n, beta_u, beta_b, sigma_u, sigma_b):
///       [ W_nn  W_nD  W_nb  0    0  ]        [ q_n + gap term ]
///       [ W_Dn  W_DD  W_Db  E_u  0  ]        [ q_D            ]
///   F = [ W_bn  W_bD  W_bb  0    E_b]    f = [ q_b            ]
///       [ U    -E_u^T 0     0    0  ]        [ 0              ]
///       [ 0     0    -E_b^T 0    0  ]        [ h c_max        ]
/// with W, q of ReducedSystem and D = W_t d over the polygon's vertices. A planar contact has the two vertices +t, -t; one
/// without friction has p_n alone. A contact with torsion, rolling or friction axes has its semi-axes in D, diag(mu_t, mu_o, gamma) times the vertices
/// of friction_polytope, a sigma of its own for what rolls, rho times those of the polygon, and 1 in U. Signs and blocks as corrected in doc/errata.md (24)-(29).
class PolygonalLcp {
 public:
  /// With `scaled`, impulses are counted in units of 1/sqrt(w) and velocities in sqrt(w) of their contact's w = W_nn before
  /// joints: then F has a unit diagonal and does not depend on units of length, mass or time.
  void assemble(const ReducedSystem& reduced, const Instant& instant, const Island& island,
                const PolygonalTerms& terms, bool scaled);

  /// The two halves of `assemble`: z, which is enough to read a solution; and F, f.
  void list_unknowns(const ReducedSystem& reduced, const Instant& instant, const Island& island,
                     const PolygonalTerms& terms, bool scaled);
  void fill(const ReducedSystem& reduced, const Island& island, const PolygonalTerms& terms);

  const Lcp& lcp() const { return lcp_; }

  /// Impulses r along the rows of ReducedSystem, in N s, from a solution z of lcp().
  void read_impulses(const Vector& z, Vector& r) const;

  /// Largest violation [m/s] of the friction rows (36)-(38) at z and the velocities u (rows of ReducedSystem) of nu+, each unit
  /// of which is worth `length` metres.
  double friction_residual(const Vector& z, const Vector& u, const Vector& length) const;

  /// Whether contact i of the island slips at z: its sliding speed sigma is above rounding.
  bool slips(int i, const Vector& z, double speed_scale) const;

  /// The solution z whose impulses are r, at the velocities u of them; r is taken to satisfy (36)-(38). Not of contacts with moments.
  void read_solution(const Vector& r, const Vector& u, Vector& z) const;

  /// One entry of z that is an impulse: up to three rows of r that it adds to.
  struct Column {
    int row = 0, rows = 1;
    double c0 = 1, c1 = 0, c2 = 0;
    int group = -1;    // of sigma, or -1 for a normal impulse
    double scale = 1;  // physical = scale * z
  };
  /// One sigma with its bound on the sum of beta: mu p_n, or h c_max.
  struct Group {
    int normal = -1;  // column of p_n, or -1
    double mu = 0;    // over p_n: 1 where semi-axes are in D
    double bound = 0;
    double diagonal = 1;  // w of its contact or joint, before joints
    double scale = 1;     // physical sigma = scale * z
  };
  const std::vector<Column>& columns() const { return columns_; }  ///< those of contacts' normals first
  const std::vector<Group>& groups() const { return groups_; }     ///< in the order of their columns

 private:
  void add_moments(const ContactInstant& c, const MomentInstant& m, int normal, int row, double diagonal,
                   const PolygonalTerms& terms);

  std::vector<Column> columns_;
  std::vector<Group> groups_;
  std::vector<int> group_of_contact_;
  Lcp lcp_;
};

}  // namespace perp
