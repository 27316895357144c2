#include "solve/files/friction_io.hpp"

#include <array>
#include <fstream>
#include <stdexcept>

#include "core/files.hpp"
#include "perp/core/errors.hpp"
#include "perp/solve/numerics_matrix.hpp"

namespace perp {

BlockKind kind_of_all(const FrictionProblem& problem) {
  const BlockKind kind = problem.blocks() > 0 ? problem.kind(0) : BlockKind::Cone;
  const bool has_place = block_rows(kind) > 1 && kind != BlockKind::Disc && kind != BlockKind::Ball;
  for (Eigen::Index i = 0; i < problem.blocks(); ++i)
    if (problem.kind(i) != kind || !has_place)
      refuse("contact problem file", "kinds", "mixed",
             "only contacts with friction, all of one kind, have a place there");
  return kind;
}

bool has_torsion(BlockKind kind) {
  return kind == BlockKind::Torsional || kind == BlockKind::TorsionalRolling;
}
bool has_rolling(BlockKind kind) {
  return kind == BlockKind::Rolling || kind == BlockKind::TorsionalRolling ||
         kind == BlockKind::PlanarRolling;
}

namespace {

constexpr std::array by_rows{BlockKind::Planar, BlockKind::Cone, BlockKind::Torsional, BlockKind::Rolling,
                             BlockKind::TorsionalRolling};

/// One number a contact.
Vector read_bounds(TextReader& reader, int contacts, const char* name) {
  Vector x(contacts);
  for (int i = 0; i < contacts; ++i) {
    const std::string what = std::string(name) + " of contact " + std::to_string(i);
    x(i) = reader.real(what);
    if (x(i) < 0) reader.reject(what, "a number >= 0 is needed");
  }
  return x;
}

/// After its first matrix a local text has reals; a global one has a storage and a shape of H that fits.
bool second_matrix_follows(TextReader reader, int n, int m) {
  try {
    reader.integer("storage", 0, 2);
    reader.integer("rows", n, n);
    reader.integer("columns", m, m);
    return true;
  } catch (const ParseError&) {
    return false;
  }
}

void write_vector(std::string& text, const Vector& x) {
  for (Eigen::Index i = 0; i < x.size(); ++i) text.append(shortest(x(i))).append("\n");
}

void write_matrix(std::string& text, const SparseMatrix& A) {
  const std::string rows = std::to_string(A.rows()), cols = std::to_string(A.cols());
  const std::string entries = std::to_string(A.nonZeros());
  text.append("2\n" + rows + " " + cols + "\n1\nCSparse text\n");
  text.append("triplet: " + rows + "-by-" + cols + ", nzmax: " + entries + " nnz: " + entries + "\n");
  for (Eigen::Index c = 0; c < A.cols(); ++c)
    for (SparseMatrix::InnerIterator it(A, c); it; ++it)
      text.append("    " + std::to_string(it.row()) + " " + std::to_string(c) + " : " + shortest(it.value()) +
                  "\n");
}

}  // namespace

FrictionProblem read_friction_text(const TextReader& from) {
  TextReader reader = from;
  FrictionProblem problem;
  const int dimension = reader.integer("rows a contact", 2, 6);
  const BlockKind kind = by_rows[static_cast<std::size_t>(dimension) - 2];
  const int contacts = reader.integer("number of contacts", 0, INT_MAX / 6);
  const int m = dimension * contacts;
  const SparseMatrix first = read_numerics_matrix(reader);
  const auto n = static_cast<int>(first.rows());
  if (first.cols() != n) reader.reject("the first matrix", "a square matrix is needed");
  if (second_matrix_follows(reader, n, m)) {
    problem.M = first;
    problem.H = read_numerics_matrix(reader, n, m);
    problem.f = reader.reals(n, "f");
    problem.w = reader.reals(m, "w");
  } else {
    if (n != m)
      reader.reject("the matrix",
                    "of " + std::to_string(m) + " rows, or a second matrix after it, is needed");
    problem.W = first;
    problem.q = reader.reals(m, "q");
  }
  problem.mu = read_bounds(reader, contacts, "mu");
  if (has_torsion(kind)) problem.torsion = read_bounds(reader, contacts, "torsion");
  if (has_rolling(kind)) problem.rolling = read_bounds(reader, contacts, "mu_r");
  if (dimension > 2 && reader.next_is("mu_o")) problem.mu_o = read_bounds(reader, contacts, "mu_o");
  problem.kinds.assign(static_cast<std::size_t>(contacts), kind);
  return problem;
}

bool is_hdf5_file(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  char bytes[8] = {};
  file.read(bytes, sizeof bytes);
  return std::string_view(bytes, sizeof bytes) == std::string_view("\x89HDF\r\n\x1a\n", 8);
}

FrictionProblem read_friction_problem(const std::string& path) {
  return read_friction_problem(path, nullptr);
}

FrictionProblem read_friction_problem(const std::string& path, std::vector<std::string>* remarks) {
  return is_hdf5_file(path) ? read_fclib(path, remarks) : read_friction_text(TextReader::from_file(path));
}

void write_friction_text(const FrictionProblem& problem, const std::string& path) {
  check(problem);
  if (problem.G.cols() > 0)
    refuse("write_friction_text", "G", "not empty", "the format has no bilateral rows");
  const BlockKind kind = kind_of_all(problem);
  if (kind == BlockKind::PlanarRolling)
    refuse("write_friction_text", "kinds", "planar with rolling", "three rows are a cone's in the format");
  std::string text = std::to_string(block_rows(kind)) + "\n" + std::to_string(problem.blocks()) + "\n";
  if (problem.is_global()) {
    write_matrix(text, problem.M.to_sparse());
    write_matrix(text, problem.H.to_sparse());
    write_vector(text, problem.f);
    write_vector(text, problem.w);
  } else {
    write_matrix(text, problem.W.to_sparse());
    write_vector(text, problem.q);
  }
  write_vector(text, problem.mu);
  if (has_torsion(kind)) write_vector(text, problem.torsion);
  if (has_rolling(kind)) write_vector(text, problem.rolling);
  if (problem.mu_o.size() > 0 && block_rows(kind) > 2) {
    text.append("mu_o\n");
    write_vector(text, problem.mu_o);
  }
  OutputFile file(path);
  file.append(text);
  file.close();
}

}  // namespace perp
