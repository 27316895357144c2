// Many random scenes, method by method: what advanced, what of that is right, what was refused and why.
#pragma once

#include <cstdio>
#include <map>

#include "trial.hpp"

namespace checker {

struct MethodTally {
  std::size_t scenes = 0, steps = 0, right = 0, wrong = 0, loaded = 0, sliding = 0, impacts = 0;
  std::size_t refused = 0, unjudged = 0, mistakes = 0, undecided = 0;
  std::map<std::string, std::size_t> reasons, parts;  // of refusals; of faults
};

struct TallyOptions {
  std::uint64_t seed = 1;  // the first
  std::size_t count = 100;
  std::size_t shard = 0, shards = 1;  // seeds with seed % shards == shard
  std::vector<std::string> methods = {"lcp", "ncp", "ncp2", "event"};
  TrialOptions trial;
  std::string failures;          // folder for the smallest scenes that fail; empty: they are only counted
  std::size_t shrink_most = 20;  // failures of one method and part that are made small
  std::FILE* each = nullptr;     // a line a seed and method: seed,method,steps,right,wrong,ending
  bool aloud = false;            // says each failure
};

using Tally = std::map<std::string, MethodTally>;

[[nodiscard]] Tally run_scenes(const TallyOptions& options);
[[nodiscard]] std::string table_of(const Tally& tally);  // markdown
/// A reason without its numbers and names.
[[nodiscard]] std::string kind_of(const std::string& reason);

}  // namespace checker
