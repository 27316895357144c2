// What a minimum's curvature says: intervals, and directions along which the data do not change.
#pragma once

#include <string>
#include <vector>

#include "perp/core/types.hpp"

namespace perp {

/// A direction in the space of the unknowns, each measured in its scale.
struct FlatDirection {
  Vector v;  ///< (n), length 1
};

struct Curvature {
  Matrix covariance;  ///< (n, n), over the directions that are not flat [units of the unknowns]
  std::vector<FlatDirection> flat;
  std::vector<bool> identifiable;  ///< (n): no flat direction has a part in it
};

/// From H = J^T J, residuals in standard deviations. With x in units of `scale`, an eigenvector of H is flat where one unit along it
/// changes chi^2 by less than its 95 % mark, 1.96^2, or by less than `cancels` of what its entries do each alone.
[[nodiscard]] Curvature curvature(const Matrix& H, const Vector& scale);

}  // namespace perp
