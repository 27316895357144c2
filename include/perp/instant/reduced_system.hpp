// An island seen from its contacts: velocities as a linear function of impulses, joints eliminated.
#pragma once

#include <array>
#include <Eigen/Cholesky>
#include <vector>

#include "perp/instant/islands.hpp"

namespace perp {

/// With the joint equations W_b^T nu+ + b_b = 0 solved for, the relative velocities u of an island's contact and joint-friction
/// rows depend on their impulses r alone:
///   u = W r + q,     W = W_r^T A11 W_r,  A11 as in (44),
///   q = W_r^T nu_free+ + explicit velocities,  nu_free+: the velocity with joints, r = 0.
/// A11 is never formed: with S = W_r^T M^-1 W_r, N = W_b^T M^-1 W_b = -B and C = W_b^T M^-1 W_r the Schur complement gives
///   W = S - C^T N^-1 C,   p_b = N^-1 (-b_b - W_b^T nu_free) - N^-1 C r.
/// A rank-deficient N (a closed loop, footnote 6) is solved in the least-squares sense, with the p_b of least sum c_bi p_bi^2, c_bi
/// the compliance of a row: the rule for redundant reactions (doc/methods/redundant.md).
///
/// Rows: for each contact of the island n, and as many of t, o as it has, then its torsion and its rolling about t, o, if it has them;
/// then one for each joint friction.
class ReducedSystem {
 public:
  /// nu_free (nv): the velocity without any reaction. joint_bias (all joint rows of the instant): b_b.
  void assemble(const Model& model, const Instant& instant, const Island& island, const Vector& nu_free,
                const Vector& joint_bias);

  int size() const { return static_cast<int>(q.size()); }
  int rows_of(int contact) const {
    return offset_[static_cast<std::size_t>(contact)];
  }                                                                 ///< first row of island.contacts[contact]
  int friction_row(int joint) const { return frictions_ + joint; }  ///< row of island.joint_frictions[joint]

  int rank() const { return rank_; }  ///< of the island's joint equations

  /// impulse += W_r r + W_b p_b over the system's velocities, and p_b into reactions (all joint rows).
  void add_impulses(const Instant& instant, const Island& island, const Vector& r, Vector& impulse,
                    Vector& reactions) const;

  /// What rows that give a little, eps c_i p_i each, add to u: u = W r + q + eps (C r + k) + O(eps²), with
  ///   C = diag(c) + NC^T diag(c_b) NC,   k = -NC^T diag(c_b) p_b(r = 0),   NC = N^-1 C_r.
  void compliance(const Model& model, const Instant& instant, const Island& island, Matrix& C,
                  Vector& k) const;

  Matrix W;         ///< (n, n), symmetric positive semidefinite
  Vector q;         ///< (n) [m/s, rad/s]
  Vector diagonal;  ///< (n) of S: W's before joints, always > 0

 private:
  void eliminate_redundant(const Model& model, const Instant& instant, const Island& island);
  void eliminate_joints(const Model& model, const Instant& instant, const Island& island,
                        const Vector& nu_free, const Vector& joint_bias);

  /// Rows of a contact, or of its moments.
  struct Part {
    int contact = 0;  // in Instant::contacts
    bool moments = false;
    int row = 0;  // the first
    int count = 0;
    std::array<int, 3> column{0, 1, 2};  // of W, for each row
    WrenchMap<3> Y = {};                 // M^-1 W

    const WrenchMap<3>& W(const Instant& instant) const {
      const ContactInstant& c = instant.contacts[static_cast<std::size_t>(contact)];
      return moments ? instant.moments_of(c)->W : c.W;
    }
  };
  void find_parts(const Instant& instant, const Island& island);

  std::vector<int> offset_;  // first row of each contact
  std::vector<Part> parts_;
  std::vector<WrenchMap<1>> friction_Y_, joint_Y_;
  int frictions_ = 0;  // first row of the joint frictions
  int rank_ = 0;
  Matrix N_, C_, NC_;  // NC = N^-1 C
  Vector p0_;          // p_b at r = 0
  Eigen::LLT<Matrix> llt_;
};

/// Rank of W_b, all rows of all joints: nv less it are the degrees of freedom that they leave.
[[nodiscard]] int joint_rank(const Model& model, const Instant& instant);

}  // namespace perp
