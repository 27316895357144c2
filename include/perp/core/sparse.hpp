// Sparse matrices, for the floors that have them.
#pragma once

#include <Eigen/SparseCore>

namespace perp {

using SparseMatrix = Eigen::SparseMatrix<double>;  ///< compressed columns, 32-bit indices

}  // namespace perp
