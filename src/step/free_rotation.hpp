// A free body's turn in the second-order step.
#pragma once

#include "perp/core/pose.hpp"

namespace perp {

/// w with exp(h w/2) J w = L: the angular velocity (body axes) of a step that starts with the angular momentum L (body axes) and
/// keeps it. For h |w| small it is the only one near J^-1 L. For turns of radians a step there are several; one always exists, for
/// w -> exp(h w/2) J w maps the ellipsoid |J w| = |L| to the sphere |L| with degree one. Newton from J^-1 L, then from starts all over the
/// ellipsoid; the one that misses least is returned.
Vector3 free_rotation(const Matrix3& J, const Vector3& L, double h);

}  // namespace perp
