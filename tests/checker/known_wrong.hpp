// Runs of the quick shards that are known to be wrong today.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <string_view>

namespace checker {

struct KnownWrong {
  std::uint64_t seed;
  std::string_view method;
};

inline constexpr std::array<KnownWrong, 1> all_known_wrong = {{{0, ""}}};

inline bool known_wrong(std::uint64_t seed, std::string_view method) {
  return std::any_of(all_known_wrong.begin(), all_known_wrong.end(),
                     [&](const KnownWrong& k) { return k.seed == seed && k.method == method; });
}

}  // namespace checker
