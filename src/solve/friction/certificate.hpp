// Proofs that a contact problem has no solution, and that it has one.
#pragma once

#include "solve/friction/contact_system.hpp"

namespace perp {

/// y (m), nonnegative on the normal rows and zero elsewhere, with Wᵀ y = 0 and qᵀ y < 0: then yᵀ u = qᵀ y < 0 for
/// every r, so that u_N >= 0 cannot be met. Found as min over y >= 0 of yᵀ W_NN y + (q_Nᵀ y + 1)², whose minimum
/// is then 0. Accepted only with |Wᵀ y|/|y| < 1e-10 and q^T y/|y| < -1e-6 in the scaled problem. Empty if none.
template <int R>
Vector infeasibility_certificate(const FrictionProblem& local, const ContactSystem<R>& system);

/// u (m) = W rho + q with u_N > mu |u_T| (the De Saxcé term, whatever the block) at every contact and u_N > 0 at every half line: then a solution exists for
/// symmetric positive semidefinite W [ACLM11]. Found as the answer of convex problems, without De Saxcé's term and with
/// contacts that ask for some more room. Empty if none came out, or W is not symmetric.
template <int R>
Vector existence_certificate(const FrictionProblem& problem, ContactSystem<R>& system);

}  // namespace perp
