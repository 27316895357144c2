#include "friction_io.hpp"

#include <fstream>
#include <stdexcept>

#include "core/files.hpp"
#include "perp/core/errors.hpp"
#include "perp/solve/numerics_matrix.hpp"

namespace perp {

int space_dimension(const FrictionProblem& problem) {
  const BlockKind kind = problem.blocks() > 0 ? problem.kind(0) : BlockKind::Cone;
  for (Eigen::Index i = 0; i < problem.blocks(); ++i)
    if (problem.kind(i) != kind || block_rows(kind) < 2)
      refuse("contact problem file", "kinds", "mixed",
             "only cones, or only planar contacts, have a place there");
  return block_rows(kind);
}

void set_kinds(FrictionProblem& problem, int dimension) {
  problem.kinds.assign(problem.mu.size(), dimension == 2 ? BlockKind::Planar : BlockKind::Cone);
}

namespace {

Vector read_coefficients(TextReader& reader, int contacts) {
  Vector mu(contacts);
  for (int i = 0; i < contacts; ++i) {
    mu(i) = reader.real("mu of contact " + std::to_string(i));
    if (mu(i) < 0) reader.reject("mu of contact " + std::to_string(i), "a number >= 0 is needed");
  }
  return mu;
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
  const int dimension = reader.integer("rows a contact", 2, 3);
  const int contacts = reader.integer("number of contacts", 0, INT_MAX / 3);
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
  problem.mu = read_coefficients(reader, contacts);
  set_kinds(problem, dimension);
  return problem;
}

bool is_hdf5_file(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  char bytes[8] = {};
  file.read(bytes, sizeof bytes);
  return std::string_view(bytes, sizeof bytes) == std::string_view("\x89HDF\r\n\x1a\n", 8);
}

FrictionProblem read_friction_problem(const std::string& path) {
  return is_hdf5_file(path) ? read_fclib(path) : read_friction_text(TextReader::from_file(path));
}

void write_friction_text(const FrictionProblem& problem, const std::string& path) {
  check(problem);
  if (problem.G.cols() > 0)
    refuse("write_friction_text", "G", "not empty", "the format has no bilateral rows");
  std::string text =
      std::to_string(space_dimension(problem)) + "\n" + std::to_string(problem.blocks()) + "\n";
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
  OutputFile file(path);
  file.append(text);
  file.close();
}

}  // namespace perp
