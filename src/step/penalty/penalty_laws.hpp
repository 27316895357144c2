// The regularised laws of `penalty`: impulses of contacts and joint frictions as functions of velocities.
#pragma once

#include <vector>

#include "perp/instant/instant.hpp"
#include "perp/step/penalty_stepper.hpp"

namespace perp {

/// p(u) of one contact in a step, u = its velocity along n, t, o, with what its derivative is.
class PenaltyContact {
 public:
  PenaltyContact(const Model& model, const Instant& s, const ContactInstant& c, const PenaltyOptions& options,
                 double h, double slip_speed);

  /// The impulse and dp/du; the overlap is -(psi_n + h u_n) if `end`, else -psi_n.
  Vector3 impulse(const Vector3& u, bool end, Matrix3& slope) const;
  /// Whether an explicit step follows its spring and damper.
  bool followed(double h) const { return h * h * k * w + 2 * h * c * w <= 4; }
  /// 1/2 k d^2 [J] at a gap.
  double stored(double psi_n) const { return psi_n < 0 ? 0.5 * k * psi_n * psi_n : 0; }

  double k = 0, c = 0, w = 0;  ///< [N/m], [N s/m], [1/kg]

 private:
  double psi_n_, mu_, h_, slip_;
  int tangents_;
};

/// -c_max h u/max(|u|, slip), and its slope.
[[nodiscard]] double regularised_friction(double most, double u, double slip, double& slope);

}  // namespace perp
