// A free body's turn in steps of fixed size.
#pragma once

#include "perp/model/model.hpp"

namespace perp {

/// w with exp(h w/2) J w = L: the angular velocity (body axes) of a step that starts with the angular momentum L (body axes) and
/// keeps it. For h |w| small it is the only one near J^-1 L. For turns of radians a step there are several; one always exists, for
/// w -> exp(h w/2) J w maps the ellipsoid |J w| = |L| to the sphere |L| with degree one. Newton from J^-1 L, then from starts all over the
/// ellipsoid; the one that misses least is returned.
Vector3 free_rotation(const Matrix3& J, const Vector3& L, double h);

/// The loads k of a step of first order from x, whose gyroscopic terms are those at its start, with those of the angular velocity w_f
/// that each spatial body would have at its end without reactions:
///   J (w_f - w) = h (torque - w_f x J w_f).
/// Explicit ones add energy in every step, h^2/2 (w x J w)^T J^-1 (w x J w); these take as much. Bodies whose J has no preferred axis
/// keep their k to the last bit.
void implicit_gyroscopic(const Model& model, const State& x, double h, Vector& k);

}  // namespace perp
