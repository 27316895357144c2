// LCPs and mixed LCPs as text files.
//
// LCP          n; matrix A (n, n); b (n)
// plain LCP    n; A row by row; b: these 1 + n² + n numbers and nothing else
// mixed LCP    two flags; n; m; if the first flag is set: the blocks' boundaries, from 0 to n + m, for each block 1 if
//              it is of pairs and 0 if of equations, the whole matrix and the whole constant; if the second flag is
//              set: A, B, C, D, each row by row, a, b. The whole is read where it is there.
// Matrices of the first kind as in numerics_matrix.hpp. What follows the last number is not read.
#pragma once

#include <string>

#include "perp/solve/mixed_lcp.hpp"
#include "perp/solve/text_reader.hpp"

namespace perp {

/// Each throws ParseError at the first token that is not as above, naming the place in the file.
[[nodiscard]] Lcp read_lcp(TextReader reader);
bool is_plain_lcp(TextReader reader);  ///< whether all of the text is as a plain LCP has it
[[nodiscard]] MixedLcp read_mixed_lcp(TextReader reader);

/// Throws std::invalid_argument too if the file cannot be read.
[[nodiscard]] Lcp read_lcp(const std::string& path);
[[nodiscard]] MixedLcp read_mixed_lcp(const std::string& path);

}  // namespace perp
