// Friction whose moments twist and roll, beside the forces of a contact: one law for both.
//
//   group 1   f_t²/mu_t² + f_o²/mu_o² + tau²/gamma² <= p_n²       sliding and twisting: an ellipsoid
//   group 2   m_t² + m_o² <= rho² p_n²                        rolling: a disc
// each with maximum work against its velocities (u_t, u_o, w_n), (w_t, w_o): p = -p_n A² u/|A u|, A = diag(semi-axes), where u is not
// zero. A contact is a Reaction (n, t, o) and, behind it, its moments' (torsion, rolling t, rolling o), these over a lever, so
// that they count as impulses.
#pragma once

#include <array>

#include "step/linearized/linearized_step.hpp"

namespace perp {

using Vector6 = Eigen::Matrix<double, 6, 1>;  ///< n, t, o, torsion, rolling t, o

/// Semi-axes of both groups, over p_n [-].
struct SemiAxes {
  Vector3 sliding = Vector3::Zero();  ///< along t, o and of the torsion
  double rolling = 0;
};

/// Those of a contact and its moments.
[[nodiscard]] SemiAxes semi_axes_of(const Reaction& contact, const Reaction& moments);

/// z_n onto the half line, then both groups of z onto theirs of that size [AC91]; P is a generalised derivative of p at z.
void project_with_moments(const SemiAxes& axes, const Vector6& z, Vector6& p, Matrix6& P);

/// -p/p_n of what rolls at angular velocities w: rolling w/|w|; zero where w is. (Of what slides: ellipsoid_support_gradient.)
[[nodiscard]] inline Vector2 rolling_friction(double rolling, const Vector2& w) {
  const double size = w.norm();
  return size > 0 ? Vector2(rolling / size * w) : Vector2::Zero();
}

/// Both parts of a contact with moments as one vector.
[[nodiscard]] inline Vector6 whole(const Vector3& contact, const Vector3& moments) {
  Vector6 all;
  all << contact, moments;
  return all;
}

/// Whether group 1 slides, group 2 rolls, at `speed`s of the step: on its bound and not at rest.
[[nodiscard]] bool slides(const Reaction& contact, const Reaction& moments, double speed);
[[nodiscard]] bool rolls(const Reaction& contact, const Reaction& moments, double speed);

/// The moments' reaction of a contact: W and axes at `m`, over the lever.
void place_moments(const MomentInstant& m, Reaction& r);

/// The lever with which a unit of moment and one of force give as much velocity, each along its own rows [m].
[[nodiscard]] double lever_of(const Model& model, const Instant& s, const ContactInstant& c,
                              const MomentInstant& m);

/// Throws std::invalid_argument naming the first contact with torsion or rolling: `method` does not know them.
void need_no_moments(std::string_view method, const Model& model);

/// A contact's friction and moments at velocities, for the certificate.
struct MomentLaw {
  const ContactInstant& c;
  const MomentInstant& m;
  Vector3 p, p_m;    ///< impulses along n, t, o [N s], moments' about them [N m s]
  double w = 1;      ///< what a unit of impulse gives [1/kg]
  double lever = 1;  ///< [m]
  Vector3 sliding_axes() const { return {c.mu, c.tangents == 2 ? m.mu_o : 0, m.torsion / lever}; }

  /// How far groups 1 and 2 are from their laws at u, omega [m/s].
  [[nodiscard]] std::array<double, 2> residuals(const Vector3& u, const Vector3& omega) const;
  /// The same with friction_polytope(edges) in the place of the ellipsoid's ball, the polygon in that of the disc: by how much impulses lie
  /// outside, as a speed, or by how much others would do more work, over p_n.
  [[nodiscard]] std::array<double, 2> residuals(const Vector3& u, const Vector3& omega, int edges) const;
  /// How far they are from the friction of what slides and rolls at u, omega; infinite of a group that does not.
  [[nodiscard]] std::array<double, 2> tied(const Vector3& u, const Vector3& omega) const;

 private:
  Vector3 sliding(const Vector3& across, double about) const {
    return {across.y(), c.tangents == 2 ? across.z() : 0, about};
  }
};

}  // namespace perp
