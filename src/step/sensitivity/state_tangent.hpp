// Small changes of a state: motions xi of the bodies (q ⊕ xi, in nu's coordinates) and changes of nu.
#pragma once

#include "perp/step/sensitivity.hpp"

namespace perp {

/// Directions, a column each.
struct StateTangent {
  Matrix xi, nu;  ///< (nv, m)
};

/// x ⊕ eps (xi, dnu).
[[nodiscard]] State displaced(const Model& model, const State& x, const Vector& xi, const Vector& dnu,
                              double eps);

/// xi with to.q = from.q ⊕ xi; rotations by less than half a turn.
[[nodiscard]] Vector displacement(const Model& model, const State& from, const State& to);

/// The columns as derivatives of State::q and State::nu at x.
[[nodiscard]] StateDerivative in_coordinates(const Model& model, const State& x, const StateTangent& tangent);

/// What a central difference of half-width eps gives: the directions from `minus` to `plus`, both near x, over 2 eps.
void difference(const Model& model, const State& x, const State& plus, const State& minus, double eps,
                Eigen::Index column, StateTangent& out);

/// The half-width of a difference along the column: as little as rounding lets it, of lengths, speeds and of `parameter`.
[[nodiscard]] double half_width(const Model& model, const State& x, const StateTangent& tangent,
                                Eigen::Index column);

}  // namespace perp
