#include "perp/solve/numerics_matrix.hpp"

#include <charconv>
#include <string>
#include <vector>

namespace perp {
namespace {

using Entries = std::vector<Eigen::Triplet<double>>;

struct Shape {
  int rows, cols;
};

constexpr int largest_size = 10'000'000;  // of an empty matrix too: a wrong number must not cost gigabytes

// A count of things of which each takes at least two bytes of what is left: a wrong count fails here, not in memory.
int count(TextReader& reader, const char* what) {
  return reader.integer(what, 0, static_cast<int>(std::min<size_t>(reader.bytes_left(), INT_MAX)));
}

void read_dense(TextReader& reader, Shape shape, Entries& entries) {
  reader.integer("number of rows", shape.rows, shape.rows);
  reader.integer("number of columns", shape.cols, shape.cols);
  for (int j = 0; j < shape.cols; ++j)
    for (int i = 0; i < shape.rows; ++i)
      if (const double value = reader.real("matrix entry"); value != 0) entries.emplace_back(i, j, value);
}

// Where each of `blocks` block rows (columns) begins, and the end of all.
std::vector<int> read_block_ends(TextReader& reader, int blocks, int size, const char* what) {
  std::vector<int> begins{0};
  for (int k = 0; k < blocks; ++k) begins.push_back(reader.integer(what, begins.back(), size));
  if (begins.back() != size) reader.reject(what, "the last must be " + std::to_string(size));
  return begins;
}

void read_blocks(TextReader& reader, Shape shape, Entries& entries) {
  const int blocks = count(reader, "number of blocks");
  const int block_rows = count(reader, "number of block rows");
  const int block_cols = count(reader, "number of block columns");
  const auto row = read_block_ends(reader, block_rows, shape.rows, "end of a block row");
  const auto col = read_block_ends(reader, block_cols, shape.cols, "end of a block column");
  const int pointers = reader.integer("length of the row pointer", 0, block_rows + 1);
  reader.integer("length of the column list", blocks, blocks);
  std::vector<int> first;  // block row r holds the blocks first[r] .. first[r + 1] - 1
  for (int r = 0; r < pointers; ++r)
    first.push_back(reader.integer("row pointer", first.empty() ? 0 : first.back(), blocks));
  first.resize(static_cast<size_t>(block_rows) + 1, blocks);
  std::vector<int> block_col;
  for (int k = 0; k < blocks; ++k) block_col.push_back(reader.integer("block column", 0, block_cols - 1));

  for (int k = 0, r = 0; k < blocks; ++k) {
    while (r < block_rows && first[static_cast<size_t>(r) + 1] <= k) ++r;
    reader.integer("number of the block", k, k);
    if (r == block_rows) reader.reject("number of the block", "the row pointer ends before this block");
    const size_t c = static_cast<size_t>(block_col[static_cast<size_t>(k)]), b = static_cast<size_t>(r);
    for (int j = col[c]; j < col[c + 1]; ++j)
      for (int i = row[b]; i < row[b + 1]; ++i) entries.emplace_back(i, j, reader.real("block entry"));
  }
}

// "R-by-C,": returns after checking that it is the shape said before, or for storage by rows its transpose.
void read_shape(TextReader& reader, std::string_view token, Shape shape, bool by_rows) {
  const std::string there = std::to_string(shape.rows) + "-by-" + std::to_string(shape.cols) + ",";
  const std::string back = std::to_string(shape.cols) + "-by-" + std::to_string(shape.rows) + ",";
  if (token != there && !(by_rows && token == back)) reader.reject("shape", "\"" + there + "\" is needed");
}

void read_triplets(TextReader& reader, Shape shape, bool lower_half, Entries& entries) {
  reader.expect("triplet:");
  read_shape(reader, reader.word("shape"), shape, false);
  reader.expect("nzmax:");
  reader.integer("nzmax", 0);
  reader.expect("nnz:");
  const int nnz = count(reader, "nnz");
  for (int k = 0; k < nnz; ++k) {
    const int i = reader.integer("row", 0, shape.rows - 1);
    const int j = reader.integer("column", 0, (lower_half ? std::min(i + 1, shape.cols) : shape.cols) - 1);
    reader.expect(":");
    const double value = reader.real("matrix entry");
    entries.emplace_back(i, j, value);
    if (lower_half && i != j) entries.emplace_back(j, i, value);
  }
}

void read_compressed(TextReader& reader, Shape shape, bool by_rows, Entries& entries) {
  read_shape(reader, reader.word("shape"), shape, by_rows);
  reader.expect("nzmax:");
  reader.integer("nzmax", 0);
  reader.expect("nnz:");
  const std::string_view token = reader.word("nnz");  // "K," with its comma
  int nnz = -1;
  const auto [end, error] = std::from_chars(token.data(), token.data() + token.size(), nnz);
  if (error != std::errc() || nnz < 0 || token.substr(static_cast<size_t>(end - token.data())) != ",")
    reader.reject("nnz", "an integer >= 0 and a comma are needed");
  reader.expect("1-norm:");
  reader.word("1-norm");
  const int outer = by_rows ? shape.rows : shape.cols, inner = by_rows ? shape.cols : shape.rows;
  int k = 0;
  for (int j = 0; j < outer; ++j) {
    const std::string_view direction = reader.word("\"col\"");
    if (direction != "col" && !(by_rows && direction == "row"))
      reader.reject("the word", "\"col\" is needed");
    reader.integer("column", j, j);
    reader.expect(":");
    reader.expect("locations");
    reader.integer("first location", k, k);
    reader.expect("to");
    const int last = reader.integer("last location", k - 1, nnz - 1);
    for (; k <= last; ++k) {
      const int i = reader.integer("row", 0, inner - 1);
      reader.expect(":");
      const double value = reader.real("matrix entry");
      by_rows ? entries.emplace_back(j, i, value) : entries.emplace_back(i, j, value);
    }
  }
  if (k != nnz) reader.reject("number of entries", std::to_string(nnz) + " were announced");
}

void read_csparse(TextReader& reader, Shape shape, Entries& entries) {
  const int origin = reader.integer("origin of a sparse matrix", 1, 4);
  reader.rest_of_line();
  reader.rest_of_line();  // free text
  if (origin == 1 || origin == 4)
    read_triplets(reader, shape, origin == 4, entries);
  else
    read_compressed(reader, shape, origin == 3, entries);
}

}  // namespace

SparseMatrix read_numerics_matrix(TextReader& reader, int rows, int cols) {
  const int storage = reader.integer("matrix storage", 0, 2);
  Shape shape{};
  shape.rows = reader.integer("number of rows", rows < 0 ? 0 : rows, rows < 0 ? largest_size : rows);
  shape.cols = reader.integer("number of columns", cols < 0 ? 0 : cols, cols < 0 ? largest_size : cols);

  Entries entries;
  if (storage == 0) read_dense(reader, shape, entries);
  if (storage == 1) read_blocks(reader, shape, entries);
  if (storage == 2) read_csparse(reader, shape, entries);

  SparseMatrix matrix(shape.rows, shape.cols);
  matrix.setFromTriplets(entries.begin(), entries.end());
  return matrix;
}

}  // namespace perp
