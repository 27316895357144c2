// Maps whose zeros are the solutions, F(r) = 0, each with a generalised Jacobian of the form A + B (W + eps I).
#pragma once

#include "cone.hpp"

namespace perp {

/// F = r - p(r - rho u), p the projection of Alart and Curnier.
struct AlartCurnierMap {
  const ContactSystem& system;
  double rho;  ///< step of the projection, in the scaled problem [-]
  Columns3 F;
  Blocks3 P;

  double evaluate(const Columns3& r, const Columns3& u);    ///< sets F; |F|²
  void jacobian(double eps, Blocks3& A, Blocks3& B) const;  ///< eps B is added into A
};

/// F = x + y - (x² + y²)^(1/2) in the Jordan algebra of the second-order cone [FLT02], x = P r, y = P^-1 û with
/// P = diag(√mu, 1/√mu, 1/√mu). Half lines: Fischer and Burmeister's a + b - √(a² + b²). Intervals: as above.
struct FischerBurmeisterMap {
  const ContactSystem& system;
  Columns3 F;
  Blocks3 dF_dr, dF_du;

  double evaluate(const Columns3& r, const Columns3& u);
  void jacobian(double eps, Blocks3& A, Blocks3& B) const;
};

}  // namespace perp
