#include "perp/solve/problem_io.hpp"

#include <utility>
#include <vector>

#include "perp/solve/numerics_matrix.hpp"

namespace perp {
namespace {

constexpr int largest_size = 20'000;  // of a dense matrix

Matrix read_rows(TextReader& reader, int rows, int cols, const char* name) {
  Matrix M(rows, cols);
  for (int i = 0; i < rows; ++i) M.row(i) = reader.reals(cols, name).transpose();
  return M;
}

// Blocks of equations and of pairs may stand in any order: the rows (and columns) of each, in the file's order.
struct Partition {
  std::vector<int> equations, pairs;
};

Partition read_partition(TextReader& reader, int n, int m) {
  std::vector<int> ends{reader.integer("first boundary of the blocks", 0, 0)};
  while (ends.back() < n + m) ends.push_back(reader.integer("boundary of a block", ends.back() + 1, n + m));
  Partition partition;
  for (size_t k = 1; k < ends.size(); ++k) {
    const bool pairs = reader.integer("kind of a block (0 equations, 1 pairs)", 0, 1) == 1;
    for (int i = ends[k - 1]; i < ends[k]; ++i) (pairs ? partition.pairs : partition.equations).push_back(i);
  }
  if (static_cast<int>(partition.equations.size()) != n)
    reader.reject("kind of the last block",
                  "the blocks of equations must have " + std::to_string(n) + " rows");
  return partition;
}

}  // namespace

bool is_plain_lcp(TextReader reader) {
  double n = 0, count = 0;
  try {
    n = reader.integer("size of the LCP", 1, largest_size);
    for (; !reader.at_end() && count <= n * n + n; ++count) reader.real("number");
  } catch (const ParseError&) {
    return false;
  }
  return count == n * n + n;
}

Lcp read_lcp(TextReader reader) {
  const bool plain = is_plain_lcp(reader);
  const int n = reader.integer("size of the LCP", 0, largest_size);
  Lcp lcp;
  if (plain) {
    lcp.A = read_rows(reader, n, n, "entry of A");
    lcp.b = reader.reals(n, "entry of b");
    return lcp;
  }
  lcp.A = Matrix(read_numerics_matrix(reader, n, n));
  lcp.b = reader.reals(n, "entry of b");
  return lcp;
}

MixedLcp read_mixed_lcp(TextReader reader) {
  const bool whole = reader.integer("flag of the whole matrix", 0, 1) == 1;
  const bool parts = reader.integer("flag of the four matrices", whole ? 0 : 1, 1) == 1;
  const int n = reader.integer("number of equations", 0, largest_size);
  const int m = reader.integer("number of pairs", 0, largest_size - n);
  MixedLcp p;
  if (whole) {
    const auto [e, c] = read_partition(reader, n, m);
    const Matrix K(read_numerics_matrix(reader, n + m, n + m));
    const Vector k = reader.reals(n + m, "entry of the constant");
    p.A = K(e, e), p.C = K(e, c), p.D = K(c, e), p.B = K(c, c);
    p.a = k(e), p.b = k(c);
  } else if (parts) {
    p.A = read_rows(reader, n, n, "entry of A");
    p.B = read_rows(reader, m, m, "entry of B");
    p.C = read_rows(reader, n, m, "entry of C");
    p.D = read_rows(reader, m, n, "entry of D");
    p.a = reader.reals(n, "entry of a");
    p.b = reader.reals(m, "entry of b");
  }
  return p;
}

Lcp read_lcp(const std::string& path) { return read_lcp(TextReader::from_file(path)); }
MixedLcp read_mixed_lcp(const std::string& path) { return read_mixed_lcp(TextReader::from_file(path)); }

}  // namespace perp
