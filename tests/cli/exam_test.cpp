// The exam: every question can be failed, its scores are those of its answers, and motions from elsewhere are graded alike.
#include <catch2/catch.hpp>
#include <cmath>
#include <set>

#include "perp/instant/instant.hpp"
#include "perp/io/exam.hpp"
#include "perp/step/event_driven.hpp"
#include "perp/step/methods.hpp"
#include "tests/cli/program.hpp"

namespace perp {
namespace {

/// Nothing ever moves.
std::vector<State> still(const Scene& s, double T) {
  std::vector<State> motion;
  for (int i = 0; i <= 2000; ++i) {
    motion.push_back(s.start);
    motion.back().t = s.start.t + (T - s.start.t) * i / 2000;
  }
  return motion;
}

/// Nothing ever touches: Euler's explicit method without reactions.
std::vector<State> without_reactions(const Scene& s, double T) {
  std::vector<State> motion{s.start};
  const int n = 2000;
  const double h = (T - s.start.t) / n;
  Instant now;
  Vector a;
  for (int i = 1; i <= n; ++i) {
    State x = motion.back();
    evaluate(s.model, x, now);
    solve_mass(s.model, now, now.k, a);
    move(s.model, x.nu, h, x.q);
    x.nu += h * a;
    x.t = s.start.t + i * h;
    motion.push_back(x);
  }
  return motion;
}

bool passed(const std::vector<ExamAnswer>& answers) {
  return std::all_of(answers.begin(), answers.end(),
                     [](const ExamAnswer& a) { return a.verdict == ExamVerdict::Pass; });
}

}  // namespace

TEST_CASE("every question of the exam is failed by a wrong method, and by one that refuses every step",
          "[exam]") {
  CHECK(exam_questions().size() >= 60);
  std::set<std::string> names;
  for (const ExamQuestion& question : exam_questions()) {
    CAPTURE(question.name);
    CHECK(names.insert(question.name).second);
    CHECK_FALSE(question.quantities.empty());
    CHECK_FALSE(question.why.empty());
    const Scene s = scene(question.scene, question.set);
    CHECK_FALSE((passed(grade(question, s, still(s, question.until), "still")) &&
                 passed(grade(question, s, without_reactions(s, question.until), "free"))));
    for (const ExamAnswer& a : grade(question, s, {}, "refuses")) {
      CHECK(a.verdict == ExamVerdict::Fail);
      CHECK(a.reason == "the motion ends before");
    }
    for (const ExamQuantity& q : question.quantities) {
      CHECK(q.tolerance >= 0);
      CHECK(q.t <= question.until);
      if (q.what == "error") CHECK(s.exact != nullptr);
    }
  }
}

TEST_CASE("the exact motion of a scene passes each question that is held against it", "[exam]") {
  for (const ExamQuestion& question : exam_questions()) {
    const Scene s = scene(question.scene, question.set);
    if (!s.exact || !s.exact(question.until).q.allFinite()) continue;
    std::vector<State> motion;
    for (int i = 0; i <= 200; ++i) {
      motion.push_back(s.exact(s.start.t + (question.until - s.start.t) * i / 200));
      motion.back().t = s.start.t + (question.until - s.start.t) * i / 200;
    }
    motion.front() = s.start;
    for (const ExamAnswer& a : grade(question, s, motion, "exact")) {
      CAPTURE(question.name, a.quantity, a.value, a.right);
      CHECK(a.verdict == ExamVerdict::Pass);
    }
  }
}

TEST_CASE("perp exam tells methods apart: circular cones, second order, what creeps", "[exam]") {
  const Scratch scratch("exam");
  const Outcome done = run_perp(
      scratch, "exam lcp ncp2 penalty --csv --questions rolls,rolls-sharp,oblique,slope-holds --out " +
                   (scratch / "o"));
  CHECK(done.status == 0);
  CHECK(done.out.rfind("method,question,quantity,value,right,tolerance,verdict\n", 0) == 0);
  auto table = columns(scratch / "o/exam.csv");
  const auto verdict = [&](const std::string& method, const std::string& question) {
    std::string all;
    for (std::size_t i = 0; i < table["method"].size(); ++i)
      if (table["method"][i] == method && table["question"][i] == question) all += table["verdict"][i] + " ";
    return all;
  };
  CHECK(verdict("lcp", "rolls") == "pass pass ");
  CHECK(verdict("lcp", "rolls-sharp") == "fail ");
  CHECK(verdict("ncp2", "rolls-sharp") == "pass ");
  CHECK(verdict("lcp", "oblique").find("fail fail") == 0);
  CHECK(verdict("ncp2", "oblique") == "pass pass pass ");
  CHECK(verdict("lcp", "slope-holds") == "pass ");
  CHECK(verdict("penalty", "slope-holds") == "fail ");
  CHECK(contents(scratch / "o/failures.md").find("# Where methods fail") == 0);
}

TEST_CASE("what a method says it cannot do is counted apart, with its reason and an exit status of 1",
          "[exam]") {
  const Scratch scratch("exam-said-so");
  const Outcome done = run_perp(scratch, "exam ncp2 --questions C14-sunk,rolls --out " + (scratch / "o"));
  const Outcome again = run_perp(scratch, "exam ncp2 --questions rolls");
  CHECK(again.status == 0);
  CHECK(again.out.find("ncp2: 1 passed, 0 failed, 0 said so, 0 not applicable, of 1 questions") !=
        std::string::npos);
  auto table = columns(scratch / "o/exam.csv");
  const bool said_so = table["verdict"][1] == "said-so";
  CHECK(done.status == (said_so ? 1 : 0));
  if (said_so) CHECK_FALSE(table["reason"][1].empty());
  CHECK(run_perp(scratch, "exam").status == 2);
  CHECK(run_perp(scratch, "exam lcp --all").status == 2);
  CHECK(run_perp(scratch, "exam nonsense").status == 2);
  CHECK(run_perp(scratch, "exam lcp --questions nonsense").status == 2);
  CHECK(run_perp(scratch, "exam --grade " + (scratch / "nowhere")).status == 2);
}

TEST_CASE("the exam is written, and trajectories from elsewhere are graded", "[exam]") {
  const Scratch scratch("exam-grade");
  REQUIRE(run_perp(scratch, "exam --write " + (scratch / "d")).status == 0);
  const std::string place = scratch / "d/rolls-sharp/";
  CHECK(contents(place + "question.json").find("\"tolerance\": 2e-05") != std::string::npos);
  REQUIRE(run_perp(scratch, "run " + place + "scene.toml --method ncp2 --step 0.001 --until 0.6 --out " +
                                (scratch / "r"))
              .status == 0);
  std::filesystem::copy_file(scratch / "r/trajectory.csv", place + "trajectory.csv");
  const Outcome right =
      run_perp(scratch, "exam --csv --questions rolls-sharp,rolls --grade " + (scratch / "d"));
  CHECK(right.status == 0);
  CHECK(right.out.find("graded,rolls-sharp,error,") != std::string::npos);
  CHECK(right.out.find(",pass\n") != std::string::npos);
  CHECK(right.out.find("not-applicable") != std::string::npos);  // of the question without a trajectory
  REQUIRE(run_perp(scratch, "run " + place + "scene.toml --method lcp --step 0.001 --until 0.6 --out " +
                                (scratch / "l"))
              .status == 0);
  std::filesystem::copy_file(scratch / "l/trajectory.csv", place + "trajectory.csv",
                             std::filesystem::copy_options::overwrite_existing);
  CHECK(run_perp(scratch, "exam --csv --questions rolls-sharp --grade " + (scratch / "d"))
            .out.find(",fail\n") != std::string::npos);
  std::ofstream(place + "trajectory.csv") << "t,ball.x\n0,1\n";
  const Outcome bad = run_perp(scratch, "exam --questions rolls-sharp --grade " + (scratch / "d"));
  CHECK(bad.status == 2);
  CHECK(bad.err.find("ball.y") != std::string::npos);
}

TEST_CASE("fifteen questions are failed by every first-order method, and passed by one of the others",
          "[exam][slow]") {
  if (!has_sundials()) return;
  int only_others = 0;
  for (const ExamQuestion& question : exam_questions()) {
    if (!question.quick) continue;
    bool first = false, other = false;
    for (const Method& m : methods()) {
      if (m.order == 1 && !first) first = passed(take(question, std::string(m.name), 20));
      if (m.order != 1 && !other && !first) other = passed(take(question, std::string(m.name), 20));
      if (first) break;
    }
    only_others += !first && other;
  }
  CHECK(only_others >= 15);
}

}  // namespace perp
