// Scene files made of parts: what `include` brings in, and what [[repeat]] writes out.
#pragma once

#include <functional>
#include <string>

#include "io/scene_table.hpp"

namespace perp {

/// The text of an included file, by its path.
using ReadFile = std::function<std::string(const std::string& path)>;

/// `root` with the files that its key `include` names, a path or a list of them relative to `file`: their tables stand before its own; their
/// other keys, and parameters, hold where it has none of its own. Files may include others, each file once.
/// Throws through refuse_at for what is not TOML, a file that includes itself, or more than 100 files.
[[nodiscard]] TomlValue with_includes(TomlValue root, const std::string& file, const ReadFile& read);

/// `root` with each [[repeat]] written out: over = "i" counts from 0 to n - 1, or `from` to `to`, and each of its tables is there once a
/// number, at the end of the tables of its kind, ${i} in its texts being the number; ${i + 1} and the like, of the counters and the
/// parameters, are numbers too. Repeats may stand in repeats. At most 1,000,000 tables.
[[nodiscard]] TomlValue with_repeats(TomlValue root, const SceneSource& source);

}  // namespace perp
