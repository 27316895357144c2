// The seed's discrete-time model with its equations kept: one mixed LCP for the whole system.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "step/run/step_record.hpp"

namespace perp {

/// Unknowns u = (nu+, p_b) and v = (p_n, beta_u, beta_b, sigma_u, sigma_b), dense, straight from (25), (28) and (39):
///   M nu+ - W_b p_b - W_n p_n - D_u beta_u - D_b beta_b = M nu + h k,     -W_b^T nu+ = joint_bias,
/// with the rows of (39) as complementarity. Shares nothing with the condensed form but the Instant.
/// Fills `answer`; false, with `message`, if there is no answer.
bool solve_mixed(const Model& model, const Instant& s, const std::vector<Vector2>& polygon,
                 std::span<const int> active, const Vector& nu_free, const Vector& gap_term,
                 const Vector& joint_bias, double h, Answer& answer, std::string& message);

}  // namespace perp
