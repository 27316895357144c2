// TOML read into a tree in which everything knows its line and column.
#pragma once

#include <memory>
#include <string>
#include <string_view>
#include <vector>

namespace perp {

/// A place in a text, counted from 1; columns in bytes.
struct Place {
  std::size_t line = 1, column = 1;
  std::shared_ptr<const std::string> file = nullptr;  ///< null: the file that is being read
};

/// A value of a TOML file. Whole numbers are numbers: 1 is as good as 1.0.
struct TomlValue {
  enum class Kind { Number, Text, Boolean, Date, List, Table };
  struct Entry;

  Kind kind = Kind::Table;
  Place place;
  std::string key;  ///< of the entry that it is in; empty for the file as a whole
  double number = 0;
  std::string text;
  Place text_begin;              ///< of the first letter; that of the value if the text has escapes or lines
  std::vector<TomlValue> items;  ///< of a list
  std::vector<Entry> entries;    ///< of a table, in the file's order

  const Entry* find(std::string_view wanted) const;
  std::string described() const;  ///< "mass is the number 3", "name is a list of 2", ...
};

struct TomlValue::Entry {
  std::string key;
  Place place;  ///< of the key
  TomlValue value;
};

/// Throws std::invalid_argument with "FILE:LINE:COLUMN: what was found, what is allowed".
[[noreturn]] void refuse_at(std::string_view file, const Place& place, std::string_view found,
                            std::string_view allowed);

inline constexpr std::size_t longest_toml = 100'000'000;  ///< bytes

/// Reads `text` as TOML 1.0, whatever the locale. Throws through refuse_at for what is not TOML, for a text that is not
/// UTF-8, and for one that is longer than 100 MB or nests deeper than 32.
[[nodiscard]] TomlValue parse_toml(std::string_view text, const std::string& file);

}  // namespace perp
