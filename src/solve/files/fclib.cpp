#include "perp/core/errors.hpp"
#include "solve/files/friction_io.hpp"

#ifndef PERP_HAS_HDF5

namespace perp {
bool has_hdf5() { return false; }
FrictionProblem read_fclib(const std::string& path, std::vector<std::string>*) {
  refuse(path, "format", "HDF5", "perp was built without HDF5; text can be read");
}
void write_fclib(const FrictionProblem&, const std::string& path) {
  refuse(path, "format", "HDF5", "perp was built without HDF5; text can be written");
}
}  // namespace perp

#else

#include <stdexcept>
#include <utility>
#include <vector>

#include "solve/files/hdf5_handle.hpp"

namespace perp {
namespace {

class FclibReader {
 public:
  explicit FclibReader(const std::string& path)
      : path_(path), file_(H5Fopen(path.c_str(), H5F_ACC_RDONLY, H5P_DEFAULT), H5Fclose) {
    if (!file_.valid()) fail("not an HDF5 file that can be opened", "an FCLIB file is needed");
  }

  /// True if every group on the way to `name` is there.
  bool has(const std::string& name) const {
    for (size_t slash = name.find('/', 1);; slash = name.find('/', slash + 1)) {
      if (H5Lexists(file_, name.substr(0, slash).c_str(), H5P_DEFAULT) <= 0) return false;
      if (slash == std::string::npos) return true;
    }
  }

  std::vector<int> integers(const std::string& name) const { return read<int>(name, H5T_NATIVE_INT); }
  Vector reals(const std::string& name) const {
    const std::vector<double> x = read<double>(name, H5T_NATIVE_DOUBLE);
    const Vector values = Eigen::Map<const Vector>(x.data(), static_cast<Eigen::Index>(x.size()));
    if (!values.allFinite()) fail(name + " has a number that is not finite", "finite numbers are needed");
    return values;
  }
  int integer(const std::string& name) const {
    const std::vector<int> x = integers(name);
    if (x.size() != 1) fail(name + " has " + std::to_string(x.size()) + " numbers", "one is needed");
    return x[0];
  }

  /// A matrix as it is stored: compressed columns (nz = -1), compressed rows (-2), or nz triplets.
  struct Stored {
    std::string name;
    int rows, columns, nz;
    std::vector<int> p, i;
    std::vector<double> x;
  };

  /// (rows, columns), as the problem's vectors say: a file of no length may announce any size.
  Stored stored(const std::string& name, Eigen::Index rows, Eigen::Index columns) const {
    const int m = integer(name + "/m"), n = integer(name + "/n"), nz = integer(name + "/nz");
    if (m != rows || n != columns)
      fail(name + " is " + std::to_string(m) + " by " + std::to_string(n),
           std::to_string(rows) + " by " + std::to_string(columns) + " is needed, as its vectors are");
    if (nz < -2) fail(name + "/nz is " + std::to_string(nz), "-2, -1 or the number of triplets is needed");
    Stored a{name,
             m,
             n,
             nz,
             integers(name + "/p"),
             integers(name + "/i"),
             read<double>(name + "/x", H5T_NATIVE_DOUBLE)};
    const int outer = nz == -2 ? m : n;
    if (nz < 0 && static_cast<int>(a.p.size()) < outer + 1)
      fail(name + "/p has " + std::to_string(a.p.size()) + " numbers",
           std::to_string(outer + 1) + " are needed");
    const int entries = nz >= 0 ? nz : a.p[outer];
    const auto enough = [&](size_t size) { return entries >= 0 && size >= static_cast<size_t>(entries); };
    if (!enough(a.i.size()) || !enough(a.x.size()) || (nz >= 0 && !enough(a.p.size())))
      fail(name + " has fewer entries than announced", std::to_string(entries) + " are needed");
    return a;
  }

  /// Whether triplets fit the shape with p as the row and i as the column, and not the other way round, as FCLIB's files have them.
  static bool swapped(const Stored& a) {
    bool as_usual = true, as_swapped = true;
    for (int k = 0; k < a.nz; ++k) {
      as_usual = as_usual && a.i[k] < a.rows && a.p[k] < a.columns;
      as_swapped = as_swapped && a.p[k] < a.rows && a.i[k] < a.columns;
    }
    return a.nz > 0 && !as_usual && as_swapped;
  }

  SparseMatrix matrix(const Stored& a, bool p_is_row) const {
    const int outer = a.nz == -2 ? a.rows : a.columns;
    std::vector<Eigen::Triplet<double> > triplets;
    const auto add = [&](int row, int col, double value) {
      if (row < 0 || row >= a.rows || col < 0 || col >= a.columns)
        fail(a.name + " has an entry at row " + std::to_string(row) + ", column " + std::to_string(col),
             "rows below " + std::to_string(a.rows) + " and columns below " + std::to_string(a.columns) +
                 " are needed");
      if (!(value - value == 0))
        fail(a.name + " has an entry that is not finite", "finite numbers are needed");
      triplets.emplace_back(row, col, value);
    };
    for (int k = 0; k < a.nz; ++k) p_is_row ? add(a.p[k], a.i[k], a.x[k]) : add(a.i[k], a.p[k], a.x[k]);
    for (int o = 0; a.nz < 0 && o < outer; ++o) {
      if (a.p[o] < 0 || a.p[o] > a.p[o + 1] || a.p[o + 1] > a.p[outer])
        fail(a.name + "/p is not ascending", "0 to the number of entries");
      for (int k = a.p[o]; k < a.p[o + 1]; ++k) a.nz == -1 ? add(a.i[k], o, a.x[k]) : add(o, a.i[k], a.x[k]);
    }
    SparseMatrix A(a.rows, a.columns);
    A.setFromTriplets(triplets.begin(), triplets.end());
    return A;
  }

  [[noreturn]] void fail(const std::string& found, const std::string& allowed) const {
    throw ParseError(path_, 1, 1, found, allowed);
  }

 private:
  template <class T>
  std::vector<T> read(const std::string& name, hid_t type) const {
    if (!has(name)) fail("there is no dataset " + name, "FCLIB's layout has it");
    const Hdf5Handle set(H5Dopen2(file_, name.c_str(), H5P_DEFAULT), H5Dclose);
    if (!set.valid()) fail(name + " is not a dataset", "numbers are needed");
    const Hdf5Handle space(H5Dget_space(set), H5Sclose);
    const hssize_t size = H5Sget_simple_extent_npoints(space);
    // no compression of HDF5's makes more than some thousand numbers of a byte
    constexpr double most = 8192;
    const auto stored = static_cast<double>(H5Dget_storage_size(set));
    if (static_cast<double>(size) > most * (stored + 1))
      fail(name + " announces " + std::to_string(size) + " numbers and holds " +
               std::to_string(static_cast<long long>(stored)) + " bytes",
           "a dataset of numbers is needed");
    std::vector<T> values(size > 0 ? static_cast<size_t>(size) : 0);
    if (size < 0 || (size > 0 && H5Dread(set, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, values.data()) < 0))
      fail(name + " cannot be read as numbers", "a dataset of numbers is needed");
    return values;
  }

  Hdf5Silence silence_;
  std::string path_;
  Hdf5Handle file_;
};

class FclibWriter {
 public:
  explicit FclibWriter(const std::string& path)
      : path_(path), file_(H5Fcreate(path.c_str(), H5F_ACC_TRUNC, H5P_DEFAULT, H5P_DEFAULT), H5Fclose) {
    need(file_.valid());
  }
  void group(const std::string& name) {
    const Hdf5Handle made(H5Gcreate2(file_, name.c_str(), H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT), H5Gclose);
    need(made.valid());
  }
  void integers(const std::string& name, const std::vector<int>& x) {
    write(name, x.data(), x.size(), H5T_NATIVE_INT);
  }
  void reals(const std::string& name, const double* x, Eigen::Index size) {
    write(name, x, static_cast<size_t>(size), H5T_NATIVE_DOUBLE);
  }
  void matrix(const std::string& name, SparseMatrix A) {
    A.makeCompressed();
    group(name);
    const auto entries = static_cast<int>(A.nonZeros());
    integers(name + "/m", {static_cast<int>(A.rows())});
    integers(name + "/n", {static_cast<int>(A.cols())});
    integers(name + "/nz", {-1});
    integers(name + "/nzmax", {entries});
    integers(name + "/p", std::vector<int>(A.outerIndexPtr(), A.outerIndexPtr() + A.cols() + 1));
    integers(name + "/i", std::vector<int>(A.innerIndexPtr(), A.innerIndexPtr() + entries));
    reals(name + "/x", A.valuePtr(), entries);
  }

 private:
  void need(bool done) const {
    if (!done) throw std::runtime_error(path_ + ": cannot be written");
  }
  void write(const std::string& name, const void* x, size_t size, hid_t type) {
    const hsize_t length = size;
    const Hdf5Handle space(H5Screate_simple(1, &length, nullptr), H5Sclose);
    const Hdf5Handle set(H5Dcreate2(file_, name.c_str(), type, space, H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT),
                         H5Dclose);
    need(set.valid() && (size == 0 || H5Dwrite(set, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, x) >= 0));
  }

  Hdf5Silence silence_;
  std::string path_;
  Hdf5Handle file_;
};

}  // namespace

bool has_hdf5() { return true; }

namespace {

struct Root {
  const char* name;
  bool global, rolling;
};

constexpr Root roots[] = {{"/fclib_local", false, false},
                          {"/fclib_global", true, false},
                          {"/fclib_local_rolling", false, true},
                          {"/fclib_global_rolling", true, true}};

const Root& root_of(const FclibReader& file) {
  for (const Root& root : roots)
    if (file.has(root.name)) return root;
  file.fail("there is neither /fclib_local nor /fclib_global, nor one of them with _rolling",
            "FCLIB's layout has one of them");
}

/// The kind of all contacts by their rows, of which there are as many as the vectors say: rolling problems may give the dimension of space.
BlockKind kind_of(const FclibReader& file, const Root& root, Eigen::Index rows, Eigen::Index contacts) {
  const std::string spacedim = std::string(root.name) + "/spacedim";
  const int given = file.integer(spacedim);
  int dimension = given;
  if (root.rolling && contacts > 0 && rows == 5 * contacts && given == 3) dimension = 5;
  if (dimension < 2 || dimension > 6 || (root.rolling && (dimension == 2 || dimension == 4)))
    file.fail(spacedim + " is " + std::to_string(given),
              root.rolling ? "3, 5 or 6 is needed" : "2 to 6 is needed");
  if (rows != contacts * dimension)
    file.fail("the rows of contacts are " + std::to_string(rows) + " and vectors/mu has " +
                  std::to_string(contacts) + " numbers",
              std::to_string(dimension) + " rows a number are needed, by spacedim");
  if (root.rolling && dimension == 3) return BlockKind::PlanarRolling;
  constexpr BlockKind kinds[] = {BlockKind::Planar, BlockKind::Cone, BlockKind::Torsional, BlockKind::Rolling,
                                 BlockKind::TorsionalRolling};
  return kinds[dimension - 2];
}

/// The matrices, all of one convention of triplets: where one fits only with p as its row, so are the others read, and it is said.
void read_matrices(const FclibReader& file, const Root& root, FrictionProblem& problem,
                   std::vector<std::string>* remarks) {
  const std::string at = std::string(root.name) + "/";
  std::vector<std::pair<FrictionMatrix*, FclibReader::Stored> > all;
  const Eigen::Index n = problem.f.size(), m = problem.rows();
  if (root.global) {
    all.emplace_back(&problem.M, file.stored(at + "M", n, n));
    all.emplace_back(&problem.H, file.stored(at + "H", n, problem.w.size()));
    if (problem.b.size() > 0 || file.has(at + "G"))
      all.emplace_back(&problem.G, file.stored(at + "G", n, problem.b.size()));
  } else {
    all.emplace_back(&problem.W, file.stored(at + "W", m, m));
  }
  bool p_is_row = false;
  for (const auto& [matrix, stored] : all) {
    if (p_is_row || !FclibReader::swapped(stored)) continue;
    p_is_row = true;
    if (remarks != nullptr)
      remarks->push_back(
          "the triplets of " + stored.name +
          " fit its shape only with p as the row and i as the column; all of the file's are read so");
  }
  for (const auto& [matrix, stored] : all) *matrix = file.matrix(stored, p_is_row);
}

}  // namespace

FrictionProblem read_fclib(const std::string& path, std::vector<std::string>* remarks) {
  const FclibReader file(path);
  FrictionProblem problem;
  const Root& root = root_of(file);
  const std::string vectors = std::string(root.name) + "/vectors/";
  if (root.global) {
    problem.f = file.reals(vectors + "f");
    problem.w = file.reals(vectors + "w");
    if (file.has(std::string(root.name) + "/G")) problem.b = file.reals(vectors + "b");
  } else {
    if (file.has(std::string(root.name) + "/V"))
      file.fail(std::string("there is an equality part ") + root.name + "/V",
                "a problem without it is needed");
    problem.q = file.reals(vectors + "q");
  }
  problem.mu = file.reals(vectors + "mu");
  const Eigen::Index rows = root.global ? problem.w.size() : problem.q.size();
  const BlockKind kind = kind_of(file, root, rows, problem.mu.size());
  problem.kinds.assign(static_cast<size_t>(problem.mu.size()), kind);
  const auto bounds = [&](Vector& x, const std::string& name) {
    x = file.reals(vectors + name);
    if (x.size() != problem.mu.size())
      file.fail(vectors + name + " has " + std::to_string(x.size()) + " numbers",
                std::to_string(problem.mu.size()) + " are needed, as vectors/mu has");
  };
  if (has_torsion(kind)) bounds(problem.torsion, "torsion");
  if (has_rolling(kind)) bounds(problem.rolling, "mu_r");
  if (file.has(vectors + "mu_o")) bounds(problem.mu_o, "mu_o");
  read_matrices(file, root, problem, remarks);
  try {
    check(problem);
  } catch (const std::invalid_argument& error) {
    file.fail(error.what(), "a problem whose parts fit together");
  }
  return problem;
}

void write_fclib(const FrictionProblem& problem, const std::string& path) {
  check(problem);
  const BlockKind kind = kind_of_all(problem);
  FclibWriter file(path);
  const bool rolling = has_rolling(kind);
  const std::string root =
      std::string(problem.is_global() ? "/fclib_global" : "/fclib_local") + (rolling ? "_rolling" : "");
  file.group(root);
  file.integers(root + "/spacedim", {block_rows(kind)});
  file.group(root + "/vectors");
  const auto vector = [&](const char* name, const Vector& x) {
    file.reals(root + "/vectors/" + name, x.data(), x.size());
  };
  if (problem.is_global()) {
    file.matrix(root + "/M", problem.M.to_sparse());
    file.matrix(root + "/H", problem.H.to_sparse());
    vector("f", problem.f);
    vector("w", problem.w);
    if (problem.G.cols() > 0) {
      file.matrix(root + "/G", problem.G.to_sparse());
      vector("b", problem.b);
    }
  } else {
    file.matrix(root + "/W", problem.W.to_sparse());
    vector("q", problem.q);
  }
  vector("mu", problem.mu);
  if (has_torsion(kind)) vector("torsion", problem.torsion);
  if (rolling) vector("mu_r", problem.rolling);
  if (problem.mu_o.size() > 0 && block_rows(kind) > 2) vector("mu_o", problem.mu_o);
}

}  // namespace perp

#endif
