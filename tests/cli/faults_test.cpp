// The k-th write, close, sync, lock, truncation, renaming, thread start fails, for k = 1, 2, ... until none is left, found by counting.
#include <catch2/catch.hpp>

#include "tests/cli/program.hpp"

#ifdef PERP_FAULTS  // not under the sanitizers, which want to be the first library themselves

namespace perp {
namespace {

Outcome run_with_fault(const Scratch& scratch, const std::string& kind, long k,
                       const std::string& arguments) {
  return run_perp(scratch, arguments,
                  "PERP_FAULT=" + kind + " PERP_FAULT_AT=" + std::to_string(k) + " PERP_FAULT_COUNT=" +
                      (scratch / "count") + " OPENBLAS_NUM_THREADS=1 LD_PRELOAD=" PERP_FAULTS);
}

/// Calls of a kind that `arguments` makes when none fails.
long calls_of(const Scratch& scratch, const std::string& kind, const std::string& arguments) {
  const Outcome fine = run_with_fault(scratch, kind, 0, arguments);
  CAPTURE(kind, arguments, fine.err);
  REQUIRE(fine.status == 0);
  return std::stol(contents(scratch / "count"));
}

void check_sentence(const Outcome& outcome) {
  CAPTURE(outcome.err);
  CHECK((outcome.status == 2 || outcome.status == 3));
  CHECK(outcome.err.substr(0, 6) == "perp: ");
  CHECK(outcome.err.size() > 20);
}

const char* const kinds[] = {"write", "short-write", "close", "sync", "lock", "truncate", "rename"};

TEST_CASE("whatever call of a run fails it says so, and what is there is whole and goes on", "[faults]") {
  const std::string kind = GENERATE(from_range(std::begin(kinds), std::end(kinds)));
  const Scratch scratch("faults-run-" + kind);
  const std::string run = "run oblique-sphere --method ncp2 --step 1e-3 --until 1 --out ";
  const long calls = calls_of(scratch, kind, run + (scratch / "alone"));
  CAPTURE(kind, calls);
  CHECK(calls > 0);
  long survived = 0;
  for (long k = 1; k <= calls; ++k) {
    CAPTURE(k);
    std::filesystem::remove_all(scratch / "o");
    const Outcome outcome = run_with_fault(scratch, kind, k, run + (scratch / "o"));
    if (outcome.status == 0) {
      ++survived;
    } else {
      check_sentence(outcome);
      const bool begun = std::filesystem::exists(scratch / "o/run.restart");
      const Outcome again =
          run_perp(scratch, begun ? "run --resume " + (scratch / "o") : run + (scratch / "o"));
      CAPTURE(begun, again.err);
      CHECK(again.status == 0);
    }
    for (const char* table : {"/trajectory.csv", "/contacts.csv", "/joints.csv", "/report.csv"})
      CHECK((contents(scratch / ("o" + std::string(table))) ==
             contents(scratch / ("alone" + std::string(table)))));
  }
  // the rest of a short write is written; the last close is of the lock alone
  CHECK(survived == (kind == "short-write" ? calls : kind == "close" ? 1 : 0));
}

TEST_CASE("whatever call of a study fails it says so, and the same command ends it", "[faults]") {
  const std::string kind = GENERATE(from_range(std::begin(kinds), std::end(kinds)));
  const Scratch scratch("faults-study-" + kind);
  const std::string study = "study seed-sphere --methods lcp --steps 0.1,0.05 --out ";
  const long calls = calls_of(scratch, kind, study + (scratch / "alone"));
  CAPTURE(kind, calls);
  CHECK(calls > 0);
  if (kind == "sync")  // a run more is a line of the journal more
    CHECK(calls_of(scratch, kind,
                   "study seed-sphere --methods lcp --steps 0.1,0.05,0.025 --out " + (scratch / "c")) ==
          calls + 1);
  const auto without_seconds = [&](const std::string& folder) {
    auto table = columns(scratch / (folder + "/study.csv"));
    table.erase("seconds");
    return table;
  };
  long survived = 0;
  for (long k = 1; k <= calls; ++k) {
    CAPTURE(k);
    std::filesystem::remove_all(scratch / "o");
    const Outcome outcome = run_with_fault(scratch, kind, k, study + (scratch / "o"));
    if (outcome.status == 0)
      ++survived;
    else
      check_sentence(outcome);
    const Outcome again = run_perp(scratch, study + (scratch / "o"));
    CAPTURE(again.err);
    CHECK(again.status == 0);
    CHECK(without_seconds("o") == without_seconds("alone"));
  }
  // the last close is of the journal, which was synchronised
  CHECK(survived == (kind == "short-write" ? calls : kind == "close" ? 1 : 0));
}

TEST_CASE("a thread that does not start leaves its work to the others", "[faults]") {
  const Scratch scratch("faults-threads");
  const std::string study = "study seed-sphere --methods lcp --steps 0.1,0.05,0.025,0.02 --jobs 4 --out ";
  REQUIRE(calls_of(scratch, "thread", study + (scratch / "alone")) == 3);
  for (long k = 1; k <= 3; ++k) {
    std::filesystem::remove_all(scratch / "o");
    const Outcome outcome = run_with_fault(scratch, "thread", k, study + (scratch / "o"));
    CAPTURE(k, outcome.err);
    CHECK(outcome.status == 0);
    CHECK_THAT(outcome.out, Catch::Contains("4 runs: 4 made now"));
    CHECK_THAT(outcome.err, Catch::Contains("gave " + std::to_string(k) + " threads of the 4"));
  }
}

}  // namespace
}  // namespace perp

#endif
