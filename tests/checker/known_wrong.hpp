// Runs of the quick shards that are known to be wrong today: known_wrong.txt, which may only shrink.
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <utility>

namespace checker {

struct KnownWrong {
  std::map<std::string, std::string> reasons;                         // what is wrong, by a word for it
  std::map<std::pair<std::uint64_t, std::string>, std::string> runs;  // seed and method: that word
};

/// Lines `# WORD: reason` and `SEED METHOD WORD`. Throws std::runtime_error for a line that is neither, a word without a reason and a
/// run that is there twice.
[[nodiscard]] KnownWrong read_known_wrong(const std::string& path);

}  // namespace checker
