#include "io/run_hdf5.hpp"

#include "perp/core/errors.hpp"

#ifndef PERP_HAS_HDF5

namespace perp {
struct Hdf5Tables::File {};
Hdf5Tables::Hdf5Tables(const std::filesystem::path& folder, bool) {
  refuse("perp run", "--format", "hdf5", "perp was built without HDF5; " + folder.string() + " can have csv");
}
Hdf5Tables::~Hdf5Tables() = default;
std::unique_ptr<RunTable> Hdf5Tables::table(const std::string&, const std::vector<RunColumn>&,
                                            std::uintmax_t) {
  return {};
}
}  // namespace perp

#else

#include <cerrno>
#include <cmath>
#include <cstring>
#include <stdexcept>

#include "solve/files/hdf5_handle.hpp"

namespace perp {

struct Hdf5Tables::File {
  Hdf5Silence silence;
  std::filesystem::path path;
  Hdf5Handle id;

  File(const std::filesystem::path& where, bool again)
      : path(where),
        id(again ? H5Fopen(path.c_str(), H5F_ACC_RDWR, H5P_DEFAULT)
                 : H5Fcreate(path.c_str(), H5F_ACC_TRUNC, H5P_DEFAULT, H5P_DEFAULT),
           H5Fclose) {
    if (!id.valid())
      refuse("writing", path.string(), again ? "no HDF5 file that can be opened" : std::strerror(errno),
             "needs to be a file that can be written");
  }

  /// Throws unless HDF5 did what it was asked for.
  void need(bool done) const {
    if (!done)
      throw std::runtime_error("writing " + path.string() + ": " +
                               (errno != 0 ? std::strerror(errno) : "HDF5 refused"));
  }
};

namespace {

class Hdf5Table final : public RunTable {
 public:
  Hdf5Table(std::shared_ptr<Hdf5Tables::File> file, const std::string& name,
            const std::vector<RunColumn>& header, std::uintmax_t rows)
      : file_(std::move(file)), rows_(rows) {
    const bool again = H5Lexists(file_->id, name.c_str(), H5P_DEFAULT) > 0;
    const Hdf5Handle group(again ? H5Gopen2(file_->id, name.c_str(), H5P_DEFAULT)
                                 : H5Gcreate2(file_->id, name.c_str(), H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT),
                           H5Gclose);
    file_->need(group.valid());
    for (const RunColumn& column : header) columns_.push_back(make(group, column, again));
  }

  RunTable& cell(double value) override {
    columns_[next_++]->numbers.push_back(value);
    return *this;
  }
  RunTable& cell(int value) override { return cell(static_cast<double>(value)); }
  RunTable& cell(std::string_view text) override {
    columns_[next_++]->texts.emplace_back(text);
    return *this;
  }

  void end_row() override {
    next_ = 0;
    constexpr std::size_t block = 4096;
    if (++waiting_ >= block) write();
  }
  void flush() override {
    write();
    file_->need(H5Fflush(file_->id, H5F_SCOPE_GLOBAL) >= 0);
    std::error_code gone;
    if (!std::filesystem::exists(file_->path, gone))
      throw std::runtime_error("writing " + file_->path.string() + ": " + std::strerror(ENOENT));
  }
  std::uintmax_t position() const override { return rows_; }
  void close() override { flush(); }

 private:
  struct Column {
    Column(hid_t s, hid_t t) : set(s, H5Dclose), type(t, H5Tclose) {}
    Hdf5Handle set, type;
    std::vector<double> numbers = {};
    std::vector<std::string> texts = {};
  };

  std::unique_ptr<Column> make(hid_t group, const RunColumn& column, bool again) const {
    const hid_t type = H5Tcopy(column.text ? H5T_C_S1 : H5T_NATIVE_DOUBLE);
    if (column.text) {
      H5Tset_size(type, H5T_VARIABLE);
      H5Tset_cset(type, H5T_CSET_UTF8);
    }
    const hsize_t rows = rows_, most = H5S_UNLIMITED, chunk = 1024;
    const Hdf5Handle space(H5Screate_simple(1, &rows, &most), H5Sclose);
    const Hdf5Handle how(H5Pcreate(H5P_DATASET_CREATE), H5Pclose);
    H5Pset_chunk(how, 1, &chunk);
    const hid_t set =
        again ? H5Dopen2(group, column.name.c_str(), H5P_DEFAULT)
              : H5Dcreate2(group, column.name.c_str(), type, space, H5P_DEFAULT, how, H5P_DEFAULT);
    auto made = std::make_unique<Column>(set, type);
    file_->need(made->set.valid() && H5Dset_extent(made->set, &rows) >= 0);
    return made;
  }

  void write() {
    if (waiting_ == 0) return;
    const hsize_t first = rows_, count = waiting_, rows = first + count;
    errno = 0;
    for (const auto& column : columns_) {
      file_->need(H5Dset_extent(column->set, &rows) >= 0);
      const Hdf5Handle place(H5Dget_space(column->set), H5Sclose),
          memory(H5Screate_simple(1, &count, nullptr), H5Sclose);
      file_->need(H5Sselect_hyperslab(place, H5S_SELECT_SET, &first, nullptr, &count, nullptr) >= 0);
      std::vector<const char*> texts;
      for (const std::string& text : column->texts) texts.push_back(text.c_str());
      const void* const values =
          texts.empty() ? static_cast<const void*>(column->numbers.data()) : texts.data();
      file_->need(H5Dwrite(column->set, column->type, memory, place, H5P_DEFAULT, values) >= 0);
      column->numbers.clear();
      column->texts.clear();
    }
    rows_ = rows;
    waiting_ = 0;
  }

  std::shared_ptr<Hdf5Tables::File> file_;
  std::vector<std::unique_ptr<Column> > columns_;
  std::uintmax_t rows_;
  std::size_t waiting_ = 0, next_ = 0;
};

}  // namespace

Hdf5Tables::Hdf5Tables(const std::filesystem::path& folder, bool again) {
  std::error_code failed;  // opening says it better
  std::filesystem::create_directories(folder, failed);
  file_ = std::make_shared<File>(folder / "run.h5", again);
}
Hdf5Tables::~Hdf5Tables() = default;

std::unique_ptr<RunTable> Hdf5Tables::table(const std::string& name, const std::vector<RunColumn>& header,
                                            std::uintmax_t rows) {
  return std::make_unique<Hdf5Table>(file_, name, header, rows);
}

}  // namespace perp

#endif
