// Runs of the quick shards that are known to be wrong today: known_wrong.txt, a line each of seed and method.
#pragma once

#include <cstdint>
#include <fstream>
#include <set>
#include <string>
#include <utility>

namespace checker {

inline bool known_wrong(std::uint64_t seed, const std::string& method) {
  static const auto all = [] {
    std::set<std::pair<std::uint64_t, std::string>> known;
    std::ifstream file(PERP_TEST_FOLDER "/known_wrong.txt");
    std::uint64_t s = 0;
    for (std::string m; file >> s >> m;) known.emplace(s, m);
    return known;
  }();
  return all.contains({seed, method});
}

}  // namespace checker
