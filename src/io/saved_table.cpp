#include "io/saved_table.hpp"

#include <algorithm>
#include <stdexcept>

#include "perp/core/errors.hpp"
#include "perp/io/csv_reader.hpp"

#ifdef PERP_HAS_HDF5
#include "solve/files/hdf5_handle.hpp"
#endif

namespace perp {
namespace {

namespace fs = std::filesystem;

bool is_text(const std::vector<std::string>& texts, const std::string& name) {
  return std::find(texts.begin(), texts.end(), name) != texts.end();
}

SavedTable read_csv(const fs::path& path, const std::vector<std::string>& texts) {
  CsvReader file(path);
  SavedTable table{.place = path.string(), .header = file.header(), .numbers = {}, .texts = {}};
  for (; file.next(); ++table.rows)
    for (std::size_t i = 0; i < table.header.size(); ++i) {
      const std::string& name = table.header[i];
      if (is_text(texts, name))
        table.texts[name].emplace_back(file.text(static_cast<int>(i)));
      else
        table.numbers[name].push_back(file.number(static_cast<int>(i)));
    }
  return table;
}

#ifdef PERP_HAS_HDF5

[[noreturn]] void refuse_file(const fs::path& path, const std::string& what) {
  throw std::invalid_argument(path.string() + ": " + what + ", needs to be as perp run wrote it");
}

herr_t add_name(hid_t, const char* name, const H5L_info_t*, void* names) {
  static_cast<std::vector<std::string>*>(names)->emplace_back(name);
  return 0;
}

SavedTable read_hdf5(const fs::path& path, const std::string& name, const std::vector<std::string>& texts) {
  const Hdf5Silence silence;
  const Hdf5Handle file(H5Fopen(path.c_str(), H5F_ACC_RDONLY, H5P_DEFAULT), H5Fclose);
  if (!file.valid()) refuse_file(path, "no HDF5 file that can be opened");
  const Hdf5Handle group(H5Gopen2(file, name.c_str(), H5P_DEFAULT), H5Gclose);
  if (!group.valid()) refuse_file(path, "no group " + name);
  SavedTable table{.place = path.string() + ": " + name, .header = {}, .numbers = {}, .texts = {}};
  hsize_t from = 0;
  H5Literate(group, H5_INDEX_NAME, H5_ITER_INC, &from, add_name, &table.header);
  bool first = true;
  for (const std::string& column : table.header) {
    const Hdf5Handle set(H5Dopen2(group, column.c_str(), H5P_DEFAULT), H5Dclose);
    if (!set.valid()) refuse_file(path, "the column " + name + "/" + column + " cannot be opened");
    const Hdf5Handle space(H5Dget_space(set), H5Sclose);
    const auto rows = static_cast<std::size_t>(std::max<hssize_t>(0, H5Sget_simple_extent_npoints(space)));
    table.rows = first ? rows : std::min(rows, table.rows);  // columns of a run that was broken off
    first = false;
    herr_t read = 0;
    if (is_text(texts, column)) {
      const Hdf5Handle type(H5Tcopy(H5T_C_S1), H5Tclose);
      H5Tset_size(type, H5T_VARIABLE);
      H5Tset_cset(type, H5T_CSET_UTF8);
      std::vector<char*> cells(rows, nullptr);
      read = H5Dread(set, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, cells.data());
      std::vector<std::string>& kept = table.texts[column];
      for (const char* cell : cells) kept.emplace_back(cell == nullptr ? "" : cell);
      H5Dvlen_reclaim(type, space, H5P_DEFAULT, cells.data());
    } else {
      std::vector<double>& kept = table.numbers[column];
      kept.resize(rows);
      read = H5Dread(set, H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT, kept.data());
    }
    if (read < 0) refuse_file(path, "the column " + name + "/" + column + " cannot be read");
  }
  return table;
}

#endif

}  // namespace

const std::vector<double>& SavedTable::column(const std::string& name) const {
  const auto found = numbers.find(name);
  static const std::vector<double> nothing;
  if (found != numbers.end()) return found->second;
  const bool there = std::find(header.begin(), header.end(), name) != header.end();
  if (there && rows == 0) return nothing;
  throw std::invalid_argument(place + ": there is no column '" + name + "' of numbers, needs one");
}

const std::vector<std::string>& SavedTable::text_column(const std::string& name) const {
  const auto found = texts.find(name);
  static const std::vector<std::string> nothing;
  if (found != texts.end()) return found->second;
  const bool there = std::find(header.begin(), header.end(), name) != header.end();
  if (there && rows == 0) return nothing;
  throw std::invalid_argument(place + ": there is no column '" + name + "' of texts, needs one");
}

void SavedTable::refuse_cell(const std::string& name, std::size_t row, const std::string& need) const {
  const auto number = numbers.find(name);
  const auto text = texts.find(name);
  const std::string found = number != numbers.end() ? shortest(number->second[row])
                            : text != texts.end()   ? text->second[row]
                                                    : "nothing";
  throw std::invalid_argument(place + ", row " + std::to_string(row + 1) + ", column " + name + ": " + found +
                              ", " + need);
}

bool has_saved_table(const fs::path& folder, const std::string& name) {
  if (fs::exists(folder / (name + ".csv"))) return true;
#ifdef PERP_HAS_HDF5
  const fs::path path = folder / "run.h5";
  if (!fs::exists(path)) return false;
  const Hdf5Silence silence;
  const Hdf5Handle file(H5Fopen(path.c_str(), H5F_ACC_RDONLY, H5P_DEFAULT), H5Fclose);
  return file.valid() && H5Lexists(file, name.c_str(), H5P_DEFAULT) > 0;
#else
  return false;
#endif
}

SavedTable read_saved_table(const fs::path& folder, const std::string& name,
                            const std::vector<std::string>& texts) {
  const fs::path csv = folder / (name + ".csv"), hdf5 = folder / "run.h5";
  if (fs::exists(csv) || !fs::exists(hdf5)) return read_csv(csv, texts);
#ifdef PERP_HAS_HDF5
  return read_hdf5(hdf5, name, texts);
#else
  refuse("reading a run", "run.h5", hdf5.string(), "perp was built without HDF5; csv can be read");
#endif
}

}  // namespace perp
