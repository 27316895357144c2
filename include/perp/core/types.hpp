// Linear algebra and scalar types that every floor shares.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <limits>

namespace perp {

using Matrix = Eigen::MatrixXd;  ///< dense, sized at run time
using Vector = Eigen::VectorXd;  ///< dense, sized at run time
using Vector2 = Eigen::Vector2d;
using Vector3 = Eigen::Vector3d;
using Matrix3 = Eigen::Matrix3d;
using Quaternion = Eigen::Quaterniond;  ///< unit; files and printouts order it w, x, y, z

inline constexpr double infinity = std::numeric_limits<double>::infinity();
inline constexpr double not_set = std::numeric_limits<double>::quiet_NaN();  ///< "no value given"

}  // namespace perp
