// Random scenes under the methods, every step judged by a checker that shares nothing with the library but the files.
//   random_scenes --seed A --count N [--shard i/n] [--methods lcp,ncp,...] [--program PERP] [--failures DIR] [--each FILE] [--units]
//   random_scenes --scene FILE      random_scenes --merge FILE...
#include <unistd.h>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <sstream>

#include "tally.hpp"

namespace {

/// Each scene in other units, drawn too: lengths times 1e-9 to 1e9, masses times 1e-18 to 1e18.
int run_units(const checker::TallyOptions& options) {
  std::size_t runs = 0, differ = 0;
  for (std::uint64_t seed = options.seed; seed < options.seed + options.count; ++seed) {
    if (seed % options.shards != options.shard) continue;
    checker::Random random(seed ^ 0x756e697473ULL);
    const double length = random.decades(-9, 9), mass = random.decades(-18, 18);
    for (const std::string& method : options.methods) {
      std::string how;
      try {
        how = checker::units_differ(checker::random_scene(seed), method, length, mass, options.trial);
      } catch (const std::exception& error) {
        how = error.what();
      }
      ++runs;
      if (how.empty()) continue;
      ++differ;
      std::printf("seed %llu, %s, lengths times %.3g, masses times %.3g: %s\n",
                  static_cast<unsigned long long>(seed), method.c_str(), length, mass, how.c_str());
    }
  }
  std::printf("%zu runs, %zu differ\n", runs, differ);
  return differ > 0 ? 1 : 0;
}

/// A scene that --failures wrote, or any whose first line names method, step and end as that does: what is wrong with it now.
int judge_file(const std::string& path, const checker::TallyOptions& options) {
  std::ifstream file(path);
  std::string line, method = "event";
  std::getline(file, line);
  checker::RandomScene random{checker::read_scene(path), 0, 1};
  double until = 0;
  std::istringstream words(line);
  for (std::string word; words >> word;) {
    if (word == "--method") words >> method;
    if (word == "--step") words >> random.h;
    if (word == "--until") words >> until;
  }
  if (!(until > 0)) {
    std::fprintf(stderr, "%s: its first line needs '--method M --step H --until T'\n", path.c_str());
    return 2;
  }
  if (!(random.h > 0)) random.h = until;
  random.steps = std::max(1, static_cast<int>(std::lround(until / random.h)));
  const checker::Trial trial = checker::try_scene(random, method, options.trial);
  for (const checker::Fault& f : trial.judgement.faults)
    std::printf("step %zu: %s %s: %.3g, allowed %.3g\n", f.step + 1, f.part.c_str(), f.of.c_str(), f.value,
                f.allowed);
  std::printf("%s by %s: %zu steps, %zu wrong%s%s\n", path.c_str(), method.c_str(), trial.judgement.steps,
              trial.wrong(), trial.reason.empty() ? "" : "; ", trial.reason.c_str());
  return trial.wrong() > 0 ? 1 : 0;
}

}  // namespace

int main(int count, char** arguments) {
  checker::TallyOptions options;
  options.trial.folder = "/tmp/random-scenes-" + std::to_string(getpid());
  std::string table;
  std::FILE* each = nullptr;
  bool units = false, keeps = false;
  for (int i = 1; i < count; ++i) {
    const std::string key = arguments[i];
    if (key == "--aloud") {
      options.aloud = true;
      continue;
    }
    if (key == "--units") {
      units = true;
      continue;
    }
    if (key == "--merge") {  // all that follows: records of shards
      checker::Tally all;
      for (++i; i < count; ++i)
        for (const checker::Record& record : checker::read_records(arguments[i])) checker::add(record, all);
      std::fputs(checker::table_of(all).c_str(), stdout);
      return 0;
    }
    if (key == "--no-energy") {
      options.trial.energy = false;
      continue;
    }
    if (i + 1 == count) {
      std::fprintf(stderr, "%s needs a value\n", key.c_str());
      return 2;
    }
    const std::string value = arguments[++i];
    if (key == "--seed") {
      options.seed = std::strtoull(value.c_str(), nullptr, 10);
    } else if (key == "--count") {
      options.count = std::strtoull(value.c_str(), nullptr, 10);
    } else if (key == "--shard") {
      options.shards = std::strtoull(value.c_str() + value.find('/') + 1, nullptr, 10);
      options.shard = std::strtoull(value.c_str(), nullptr, 10) % options.shards;
    } else if (key == "--methods") {
      options.methods.clear();
      std::istringstream stream(value);
      for (std::string m; std::getline(stream, m, ',');) options.methods.push_back(m);
    } else if (key == "--program") {
      options.trial.program = value;
    } else if (key == "--failures") {
      options.failures = value;
    } else if (key == "--most") {
      options.shrink_most = std::strtoull(value.c_str(), nullptr, 10);
    } else if (key == "--table") {
      table = value;
    } else if (key == "--scene") {
      return judge_file(value, options);
    } else if (key == "--keep") {
      keeps = true;
      options.trial.folder = value;
    } else if (key == "--each") {
      each = options.each = std::fopen(value.c_str(), "w");
    } else {
      std::fprintf(stderr,
                   "%s is no option; --seed --count --shard --methods --program --failures --most --each "
                   "--table --keep --aloud --no-energy are\n",
                   key.c_str());
      return 2;
    }
  }
  std::printf("seeds %llu to %llu, shard %zu of %zu\n", static_cast<unsigned long long>(options.seed),
              static_cast<unsigned long long>(options.seed + options.count - 1), options.shard,
              options.shards);
  if (units) return run_units(options);
  const checker::Tally tally = checker::run_scenes(options);
  if (each != nullptr) std::fclose(each);
  const std::string text = checker::table_of(tally);
  std::fputs(text.c_str(), stdout);
  if (!table.empty()) std::ofstream(table) << text;
  if (!keeps) std::filesystem::remove_all(options.trial.folder);
  for (const auto& [method, m] : tally)
    if (m.wrong > 0 || m.unjudged > 0 || m.mistakes > 0) return 1;
  return 0;
}
