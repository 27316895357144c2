#include "friction_io.hpp"
#include "perp/core/errors.hpp"

#ifndef PERP_HAS_HDF5

namespace perp {
bool has_hdf5() { return false; }
FrictionProblem read_fclib(const std::string& path) {
  refuse(path, "format", "HDF5", "perp was built without HDF5; text can be read");
}
void write_fclib(const FrictionProblem&, const std::string& path) {
  refuse(path, "format", "HDF5", "perp was built without HDF5; text can be written");
}
}  // namespace perp

#else

#include <stdexcept>
#include <vector>

#include "solve/hdf5_handle.hpp"

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

  /// (rows, columns), as the problem's vectors say: a file of no length may announce any size.
  /// nz >= 0: triplets with i the row and p the column; -1: by columns; -2: by rows.
  SparseMatrix matrix(const std::string& name, Eigen::Index rows, Eigen::Index columns) const {
    const int m = integer(name + "/m"), n = integer(name + "/n"), nz = integer(name + "/nz");
    if (m != rows || n != columns)
      fail(name + " is " + std::to_string(m) + " by " + std::to_string(n),
           std::to_string(rows) + " by " + std::to_string(columns) + " is needed, as its vectors are");
    const std::vector<int> p = integers(name + "/p"), i = integers(name + "/i");
    const int outer = nz == -2 ? m : n;
    if (nz < -2) fail(name + "/nz is " + std::to_string(nz), "-2, -1 or the number of triplets is needed");
    if (nz < 0 && static_cast<int>(p.size()) < outer + 1)
      fail(name + "/p has " + std::to_string(p.size()) + " numbers",
           std::to_string(outer + 1) + " are needed");
    const int entries = nz >= 0 ? nz : p[outer];
    const std::vector<double> x = read<double>(name + "/x", H5T_NATIVE_DOUBLE);
    const auto enough = [&](size_t size) { return entries >= 0 && size >= static_cast<size_t>(entries); };
    if (!enough(i.size()) || !enough(x.size()) || (nz >= 0 && !enough(p.size())))
      fail(name + " has fewer entries than announced", std::to_string(entries) + " are needed");
    std::vector<Eigen::Triplet<double> > triplets;
    const auto add = [&](int row, int col, double value) {
      if (row < 0 || row >= m || col < 0 || col >= n)
        fail(name + " has an entry at row " + std::to_string(row) + ", column " + std::to_string(col),
             "rows below " + std::to_string(m) + " and columns below " + std::to_string(n) + " are needed");
      if (!(value - value == 0)) fail(name + " has an entry that is not finite", "finite numbers are needed");
      triplets.emplace_back(row, col, value);
    };
    if (nz >= 0) {
      for (int k = 0; k < nz; ++k) add(i[k], p[k], x[k]);
    } else {
      for (int o = 0; o < outer; ++o) {
        if (p[o] < 0 || p[o] > p[o + 1] || p[o + 1] > entries)
          fail(name + "/p is not ascending", "0 to the number of entries");
        for (int k = p[o]; k < p[o + 1]; ++k) nz == -1 ? add(i[k], o, x[k]) : add(o, i[k], x[k]);
      }
    }
    SparseMatrix A(m, n);
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

FrictionProblem read_fclib(const std::string& path) {
  const FclibReader file(path);
  FrictionProblem problem;
  const bool global = file.has("/fclib_global");
  const std::string root = global ? "/fclib_global" : "/fclib_local";
  if (!file.has(root))
    file.fail("there is neither /fclib_local nor /fclib_global", "FCLIB's layout has one of them");
  const int dimension = file.integer(root + "/spacedim");
  if (dimension != 2 && dimension != 3)
    file.fail(root + "/spacedim is " + std::to_string(dimension), "2 or 3 is needed");
  if (global) {
    problem.f = file.reals(root + "/vectors/f");
    problem.w = file.reals(root + "/vectors/w");
    problem.M = file.matrix(root + "/M", problem.f.size(), problem.f.size());
    problem.H = file.matrix(root + "/H", problem.f.size(), problem.w.size());
    if (file.has(root + "/G")) {
      problem.b = file.reals(root + "/vectors/b");
      problem.G = file.matrix(root + "/G", problem.f.size(), problem.b.size());
    }
  } else {
    if (file.has(root + "/V"))
      file.fail("there is an equality part /fclib_local/V", "a problem without it is needed");
    problem.q = file.reals(root + "/vectors/q");
    problem.W = file.matrix(root + "/W", problem.q.size(), problem.q.size());
  }
  if (problem.rows() % dimension != 0)
    file.fail("the rows of contacts are " + std::to_string(problem.rows()),
              "a multiple of spacedim is needed");
  problem.mu = file.reals(root + "/vectors/mu");
  if (problem.mu.size() != problem.rows() / dimension)
    file.fail(root + "/vectors/mu has " + std::to_string(problem.mu.size()) + " numbers",
              std::to_string(problem.rows() / dimension) + " are needed");
  set_kinds(problem, dimension);
  try {
    check(problem);
  } catch (const std::invalid_argument& error) {
    file.fail(error.what(), "a problem whose parts fit together");
  }
  return problem;
}

void write_fclib(const FrictionProblem& problem, const std::string& path) {
  check(problem);
  const int dimension = space_dimension(problem);
  FclibWriter file(path);
  const std::string root = problem.is_global() ? "/fclib_global" : "/fclib_local";
  file.group(root);
  file.integers(root + "/spacedim", {dimension});
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
}

}  // namespace perp

#endif
