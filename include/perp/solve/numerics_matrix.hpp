// The matrix block of contact-problem text files, in its three storages.
//
//   STORAGE                 0 dense, 1 sparse blocks, 2 CSparse text
//   ROWS COLS
//   body
//
// dense     ROWS COLS again, then ROWS*COLS reals column by column, however the lines are broken.
// blocks    the number of blocks, of block rows, of block columns; the last row (column) + 1 of each block row
//           (column); the lengths of the next two lists; where each block row begins; each block's block column;
//           then for each block its number and its entries, column by column.
// CSparse   ORIGIN (1 triplet, 2 by columns, 3 by rows, 4 triplet of a symmetric matrix's lower half), a line
//           of free text, then "triplet: R-by-C, nzmax: N nnz: K" and K lines "i j : value", or
//           "R-by-C, nzmax: N nnz: K, 1-norm: X" and for each column j "col j : locations a to b", each followed
//           by b-a+1 lines "i : value".
// Indices count from 0.
#pragma once

#include "perp/core/sparse.hpp"
#include "perp/solve/text_reader.hpp"

namespace perp {

/// The next matrix block, entries of equal place summed, zeros of dense storage left out; Matrix(result) is dense.
/// With rows or cols >= 0 the matrix must have that shape. Throws ParseError at the first token that is not as above.
[[nodiscard]] SparseMatrix read_numerics_matrix(TextReader& reader, int rows = -1, int cols = -1);

}  // namespace perp
