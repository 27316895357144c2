// Maps whose zeros are the solutions, F(r) = 0, each with a generalised Jacobian of the form A + B (W + eps I).
#pragma once

#include "solve/friction/contact_system.hpp"

namespace perp {

/// F = r - p(r - rho u), p the projection of Alart and Curnier.
template <int R>
struct AlartCurnierMap {
  const ContactSystem<R>& system;
  double rho;  ///< step of the projection, in the scaled problem [-]
  Columns<R> F;
  Squares<R> P;

  double evaluate(const Columns<R>& r, const Columns<R>& u);  ///< sets F; |F|²
  void jacobian(double eps, Squares<R>& A,
                Squares<R>& B) const;  ///< the Jacobian is A + B W; eps B is added into A
};

/// F = x + y - (x² + y²)^(1/2) in the Jordan algebra of the second-order cone [FLT02], x = P r, y = P^-1 û with
/// P of cone_scaling(). Half lines: Fischer and Burmeister's a + b - √(a² + b²). Bounds of constant size and blocks of two groups, whose
/// dual cone is the sum of two: as above.
template <int R>
struct FischerBurmeisterMap {
  const ContactSystem<R>& system;
  Columns<R> F;
  Squares<R> dF_dr, dF_du;

  double evaluate(const Columns<R>& r, const Columns<R>& u);
  void jacobian(double eps, Squares<R>& A, Squares<R>& B) const;
};

}  // namespace perp
