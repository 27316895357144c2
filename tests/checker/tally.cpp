#include "tally.hpp"

#include <algorithm>
#include <cctype>
#include <filesystem>
#include <fstream>
#include <sstream>

namespace checker {

std::string kind_of(const std::string& reason) {
  std::string kind = reason.substr(0, reason.find('\n'));
  if (const auto time = kind.find("t = "); time != std::string::npos)
    if (const auto after = kind.find(": ", time); after != std::string::npos) kind = kind.substr(after + 2);
  std::string out;
  bool quoted = false;
  for (std::size_t i = 0; i < kind.size(); ++i) {
    const char c = kind[i];
    if (c == '\'') quoted = !quoted;
    if (quoted) continue;
    const bool digit = std::isdigit(static_cast<unsigned char>(c)) != 0;
    const bool in_number =
        !out.empty() && out.back() == '#' && (digit || c == '.' || c == 'e' || c == '-' || c == '+');
    if (in_number) continue;
    out += digit ? '#' : c;
  }
  return out.substr(0, 90);
}

namespace {

/// Makes one failure small and writes it with what to run.
void keep(const RandomScene& random, const std::string& method, const Fault& fault, std::uint64_t seed,
          const TallyOptions& options) {
  TrialOptions trial = options.trial;
  trial.folder += "/shrink";
  const auto fails = [&](const RandomScene& r) {
    const Trial t = try_scene(r, method, trial);
    return std::any_of(t.judgement.faults.begin(), t.judgement.faults.end(),
                       [&](const Fault& f) { return f.part == fault.part; });
  };
  RandomScene from = random;
  const std::string text = text_of(random.scene);
  (void)run_scene(text, method, random.h, random.until(), trial);
  try {  // begin where it fails, if it still does
    const Run run = read_run(random.scene, trial.folder + "/out");
    RandomScene late = begun_at(random, run.states[fault.step]);
    late.steps = 1;
    if (fails(late)) from = late;
  } catch (const std::exception&) {
  }
  const RandomScene least = shrink(from, fails);
  const Trial t = try_scene(least, method, trial);
  std::string what;
  for (const Fault& f : t.judgement.faults)
    if (f.part == fault.part) {
      what = "step " + std::to_string(f.step + 1) + ", " + f.part + " " + f.of + ": " + digits(f.value) +
             ", allowed " + digits(f.allowed);
      break;
    }
  std::filesystem::create_directories(options.failures);
  const std::string name = method + "-" + fault.part + "-" + std::to_string(seed) + ".toml";
  std::ofstream file(options.failures + "/" + name);
  file << "# seed " << seed << ": perp run " << name << " --method " << method;
  if (method != "event") file << " --step " << digits(least.h);
  file << " --until " << digits(least.until()) << "\n# " << what << "\n" << text_of(least.scene);
  std::printf("seed %llu, %s: %s; smallest: %s/%s\n", static_cast<unsigned long long>(seed), method.c_str(),
              what.c_str(), options.failures.c_str(), name.c_str());
  std::fflush(stdout);
}

}  // namespace

void add(const Record& record, Tally& tally) {
  MethodTally& m = tally[record.method];
  ++m.scenes;
  if (record.ending == Ending::Unjudged) ++m.unjudged;
  if (record.ending == Ending::Mistake) ++m.mistakes;
  if (record.ending == Ending::Refused) ++m.refused;
  if (record.ending != Ending::Done) ++m.reasons[record.reason];
  m.undecided += record.undecided;
  m.steps += record.steps;
  m.wrong += record.wrong;
  m.right += record.steps - record.wrong;
  m.wrong_runs += record.wrong > 0 ? 1 : 0;
  m.loaded += record.loaded;
  m.sliding += record.sliding;
  m.impacts += record.impacts;
  for (const std::string& part : record.parts) ++m.parts[part];
}

const char* const record_header =
    "seed,method,steps,wrong,loaded,sliding,impacts,undecided,ending,parts,reason";

void write(const Record& r, std::FILE* file) {
  std::string parts;
  for (const std::string& part : r.parts) parts += (parts.empty() ? "" : " ") + part;
  std::string reason = r.reason;
  std::replace_if(
      reason.begin(), reason.end(), [](char c) { return c == ',' || c == '"'; }, ' ');
  std::fprintf(file, "%llu,%s,%zu,%zu,%zu,%zu,%zu,%zu,%d,%s,%s\n", static_cast<unsigned long long>(r.seed),
               r.method.c_str(), r.steps, r.wrong, r.loaded, r.sliding, r.impacts, r.undecided,
               static_cast<int>(r.ending), parts.c_str(), reason.c_str());
}

std::vector<Record> read_records(const std::string& path) {
  const Csv csv(path);
  std::vector<Record> all;
  for (std::size_t i = 0; i < csv.rows(); ++i) {
    const auto count = [&](const char* column) { return static_cast<std::size_t>(csv.number(i, column)); };
    Record r{count("seed"),
             csv.text(i, "method"),
             csv.text(i, "reason"),
             static_cast<Ending>(count("ending")),
             count("steps"),
             count("wrong"),
             count("loaded"),
             count("sliding"),
             count("impacts"),
             count("undecided"),
             {}};
    std::istringstream parts(csv.text(i, "parts"));
    for (std::string part; parts >> part;) r.parts.push_back(part);
    all.push_back(std::move(r));
  }
  return all;
}

Tally run_scenes(const TallyOptions& options) {
  Tally tally;
  std::map<std::string, std::size_t> kept;
  if (options.each != nullptr) std::fprintf(options.each, "%s\n", record_header);
  for (std::uint64_t seed = options.seed; seed < options.seed + options.count; ++seed) {
    if (seed % options.shards != options.shard) continue;
    const RandomScene random = random_scene(seed);
    for (const std::string& method : options.methods) {
      const Trial trial = try_scene(random, method, options.trial);
      const Judgement& j = trial.judgement;
      if (trial.ending == Ending::Mistake || trial.ending == Ending::Unjudged)
        std::printf("seed %llu, %s: %s\n", static_cast<unsigned long long>(seed), method.c_str(),
                    trial.reason.c_str());
      Record record{seed,
                    method,
                    kind_of(trial.reason),
                    trial.ending,
                    j.steps,
                    trial.wrong(),
                    j.loaded,
                    j.sliding,
                    j.impacts,
                    trial.undecided,
                    {}};
      std::map<std::string, const Fault*> parts;
      for (const Fault& f : j.faults) parts.emplace(f.part, &f);
      for (const auto& [part, fault] : parts) {
        record.parts.push_back(part);
        if (options.aloud)
          std::printf("seed %llu, %s, step %zu: %s %s: %.3g, allowed %.3g\n",
                      static_cast<unsigned long long>(seed), method.c_str(), fault->step + 1, part.c_str(),
                      fault->of.c_str(), fault->value, fault->allowed);
        if (!options.failures.empty() && kept[method + part]++ < options.shrink_most)
          keep(random, method, *fault, seed, options);
      }
      add(record, tally);
      if (options.each == nullptr) continue;
      write(record, options.each);
      std::fflush(options.each);
    }
  }
  return tally;
}

std::string table_of(const Tally& tally) {
  std::string out =
      "| method | scenes | steps advanced | right | wrong | runs with a wrong step | runs refused | loaded | "
      "sliding | impact |\n"
      "|---|---|---|---|---|---|---|---|---|---|\n";
  const auto share = [](std::size_t part, std::size_t whole) {
    char text[16];
    std::snprintf(text, sizeof text, "%.0f %%",
                  whole == 0 ? 0 : 100 * static_cast<double>(part) / static_cast<double>(whole));
    return std::string(text);
  };
  for (const auto& [method, m] : tally)
    out += "| " + method + " | " + std::to_string(m.scenes) + " | " + std::to_string(m.steps) + " | " +
           std::to_string(m.right) + " | " + std::to_string(m.wrong) + " | " + std::to_string(m.wrong_runs) +
           " | " + std::to_string(m.refused) + " | " + share(m.loaded, m.steps) + " | " +
           share(m.sliding, m.steps) + " | " + share(m.impacts, m.steps) + " |\n";
  for (const auto& [method, m] : tally) {
    if (!m.parts.empty()) out += "\n" + method + ", runs wrong in:";
    for (const auto& [part, n] : m.parts) out += " " + part + " " + std::to_string(n) + ";";
    std::vector<std::pair<std::size_t, std::string>> reasons;
    for (const auto& [reason, n] : m.reasons) reasons.emplace_back(n, reason);
    std::sort(reasons.rbegin(), reasons.rend());
    if (!reasons.empty()) out += "\n" + method + ", refused:";
    for (const auto& [n, reason] : reasons) out += "\n  " + std::to_string(n) + " " + reason;
    if (m.undecided + m.unjudged + m.mistakes > 0)
      out += "\n" + method + ": " + std::to_string(m.undecided) + " gains undecided, " +
             std::to_string(m.unjudged) + " runs unjudged, " + std::to_string(m.mistakes) +
             " scenes not taken";
    out += "\n";
  }
  return out;
}

}  // namespace checker
