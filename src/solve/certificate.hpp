// A proof that a contact problem has no solution.
#pragma once

#include "contact_system.hpp"

namespace perp {

/// y (m), nonnegative on the normal rows and zero elsewhere, with Wᵀ y = 0 and qᵀ y < 0: then yᵀ u = qᵀ y < 0 for
/// every r, so that u_N >= 0 cannot be met. Found as min over y >= 0 of yᵀ W_NN y + (q_Nᵀ y + 1)², whose minimum
/// is then 0. Accepted only with |Wᵀ y|/|y| < 1e-10 and q^T y/|y| < -1e-6 in the scaled problem. Empty if none.
Vector infeasibility_certificate(const FrictionProblem& local, const ContactSystem& system);

}  // namespace perp
