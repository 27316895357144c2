// Many random scenes, method by method: what advanced, what of that is right, what was refused and why.
#pragma once

#include <cstdio>
#include <map>

#include "trial.hpp"

namespace checker {

struct MethodTally {
  std::size_t scenes = 0, steps = 0, right = 0, wrong = 0, loaded = 0, sliding = 0, impacts = 0;
  std::size_t wrong_runs = 0, refused = 0, unjudged = 0, mistakes = 0, undecided = 0;
  std::map<std::string, std::size_t> reasons, parts;  // of refusals; of faults
};

/// What came of one run.
struct Record {
  std::uint64_t seed = 0;
  std::string method, reason;  // why it ended early, without numbers and names
  Ending ending = Ending::Done;
  std::size_t steps = 0, wrong = 0, loaded = 0, sliding = 0, impacts = 0, undecided = 0;
  std::vector<std::string> parts;  // in which steps are wrong
};

struct TallyOptions {
  std::uint64_t seed = 1;  // the first
  std::size_t count = 100;
  std::size_t shard = 0, shards = 1;  // seeds with seed % shards == shard
  std::vector<std::string> methods = {"lcp", "ncp", "ncp2", "event"};
  TrialOptions trial;
  std::string failures;          // folder for the smallest scenes that fail; empty: they are only counted
  std::size_t shrink_most = 20;  // failures of one method and part that are made small
  std::FILE* each = nullptr;     // gets the record of each run, a line
  bool aloud = false;            // says each failure
};

using Tally = std::map<std::string, MethodTally>;

[[nodiscard]] Tally run_scenes(const TallyOptions& options);
void add(const Record& record, Tally& tally);

/// Records as lines of a CSV file; of several shards together they make the table of all. Throws std::runtime_error for another file.
extern const char* const record_header;
void write(const Record& record, std::FILE* file);
[[nodiscard]] std::vector<Record> read_records(const std::string& path);

[[nodiscard]] std::string table_of(const Tally& tally);  // markdown
/// A reason without its numbers and names.
[[nodiscard]] std::string kind_of(const std::string& reason);

}  // namespace checker
