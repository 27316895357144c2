// perp exam: questions with known answers, put to methods or to motions from elsewhere.
#include <cstdio>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "cli/commands.hpp"
#include "cli/parameters.hpp"
#include "core/files.hpp"
#include "perp/core/errors.hpp"
#include "perp/io/exam.hpp"
#include "perp/step/methods.hpp"

namespace perp {
namespace {

struct ExamArguments {
  std::vector<std::string> methods, questions;
  bool all = false, quick = false, csv = false;
  std::string out, write, grade;
  double seconds = 60;
};

/// Answers of a question count once: with the worst verdict of its quantities.
struct Score {
  int pass = 0, fail = 0, said_so = 0, not_applicable = 0;
  double seconds = 0;
};

std::string in_short(double x) {
  char text[32];
  std::snprintf(text, sizeof text, "%.6g", x);
  return x == x ? text : "-";
}

void print(const std::vector<ExamAnswer>& answers, bool csv) {
  for (const ExamAnswer& a : answers)
    if (csv)
      std::printf("%s,%s,%s,%s,%s,%s,%s\n", a.method.c_str(), a.question.c_str(), a.quantity.c_str(),
                  a.value == a.value ? shortest(a.value).c_str() : "", shortest(a.right).c_str(),
                  shortest(a.tolerance).c_str(), std::string(name_of(a.verdict)).c_str());
    else if (a.verdict != ExamVerdict::Pass)
      std::printf("%-12s %-26s %-14s %s, right is %s to %s: %s%s%s\n", a.method.c_str(), a.question.c_str(),
                  a.quantity.c_str(), in_short(a.value).c_str(), in_short(a.right).c_str(),
                  in_short(a.tolerance).c_str(), std::string(name_of(a.verdict)).c_str(),
                  a.reason.empty() ? "" : ": ", a.reason.c_str());
  std::fflush(stdout);
}

/// A question is passed with all of its quantities.
void count(const std::vector<ExamAnswer>& answers, Score& score) {
  if (answers.empty()) return;
  ExamVerdict worst = ExamVerdict::Pass;
  for (const ExamAnswer& a : answers)
    if (a.verdict != ExamVerdict::Pass) worst = a.verdict;
  score.pass += worst == ExamVerdict::Pass;
  score.fail += worst == ExamVerdict::Fail;
  score.said_so += worst == ExamVerdict::SaidSo;
  score.not_applicable += worst == ExamVerdict::NotApplicable;
  if (answers.front().seconds == answers.front().seconds) score.seconds += answers.front().seconds;
}

std::vector<ExamAnswer> graded(const ExamQuestion& question, const std::filesystem::path& folder) {
  const std::filesystem::path file = folder / question.name / "trajectory.csv";
  const Scene s = scene(question.scene, question.set);
  if (std::filesystem::exists(file)) return grade(question, s, read_motion(s.model, file), "graded");
  std::vector<ExamAnswer> answers;
  for (const ExamQuantity& q : question.quantities)
    answers.push_back({.method = "graded",
                       .question = question.name,
                       .quantity = q.what,
                       .right = q.right,
                       .tolerance = q.tolerance,
                       .verdict = ExamVerdict::NotApplicable,
                       .reason = "there is no " + file.string()});
  return answers;
}

bool asked(const ExamArguments& arguments, const ExamQuestion& question) {
  if (arguments.questions.empty()) return question.quick || !arguments.quick;
  for (const std::string& name : arguments.questions)
    if (name == question.name) return true;
  return false;
}

int exam(ExamArguments& arguments) {
  const int ways =
      !arguments.methods.empty() + arguments.all + !arguments.write.empty() + !arguments.grade.empty();
  if (ways != 1)
    refuse("perp exam", "METHOD...", "one of " + std::to_string(ways) + " given",
           "needs methods, or --all, or --write DIR, or --grade DIR: one of these");
  for (const std::string& name : arguments.questions) (void)exam_question(name);
  if (!arguments.write.empty()) {
    write_exam(arguments.write, arguments.quick);
    std::printf("wrote the questions to %s: each a folder, its trajectory.csv is graded by --grade\n",
                arguments.write.c_str());
    return Done;
  }
  if (!arguments.grade.empty()) {
    if (!std::filesystem::is_directory(arguments.grade))
      refuse("perp exam", "--grade", arguments.grade, "needs to be a folder as --write makes it");
    arguments.methods = {"graded"};
  } else if (arguments.all) {
    for (const Method& m : methods()) arguments.methods.emplace_back(m.name);
  } else {
    for (const std::string& name : arguments.methods) (void)method(name);
  }
  if (arguments.csv) std::printf("method,question,quantity,value,right,tolerance,verdict\n");
  std::vector<ExamAnswer> everything;
  std::map<std::string, Score> scores;
  for (const std::string& taker : arguments.methods)
    for (const ExamQuestion& question : exam_questions()) {
      if (!asked(arguments, question)) continue;
      const std::vector<ExamAnswer> answers = arguments.grade.empty()
                                                  ? take(question, taker, arguments.seconds)
                                                  : graded(question, arguments.grade);
      print(answers, arguments.csv);
      count(answers, scores[taker]);
      everything.insert(everything.end(), answers.begin(), answers.end());
    }
  bool said_so = false;
  for (const std::string& taker : arguments.methods) {
    const Score& s = scores[taker];
    said_so = said_so || s.said_so > 0;
    if (!arguments.csv)
      std::printf("%s: %d passed, %d failed, %d said so, %d not applicable, of %d questions in %.1f s\n",
                  taker.c_str(), s.pass, s.fail, s.said_so, s.not_applicable,
                  s.pass + s.fail + s.said_so + s.not_applicable, s.seconds);
  }
  if (!arguments.out.empty()) {
    std::filesystem::create_directories(arguments.out);
    write_exam_csv(std::filesystem::path(arguments.out) / "exam.csv", everything);
    replace_file(std::filesystem::path(arguments.out) / "failures.md", failures_page(everything));
  }
  return said_so ? ToleranceNotReached : Done;
}

}  // namespace

void add_exam_command(CLI::App& perp, int& status) {
  CLI::App* command =
      perp.add_subcommand("exam", "Put questions with known answers to methods, or to motions of others");
  const auto arguments = std::make_shared<ExamArguments>();
  command->add_option("METHOD", arguments->methods, "methods (perp methods)")->check(some_text());
  command->add_flag("--all", arguments->all, "all methods");
  command->add_flag("--quick", arguments->quick, "the quick questions alone");
  command->add_option("--questions", arguments->questions, "these alone")
      ->delimiter(',')
      ->allow_extra_args(false)
      ->check(some_text())
      ->type_name("A,B,...");
  command->add_flag("--csv", arguments->csv, "print method,question,quantity,value,right,tolerance,verdict");
  command->add_option("--out", arguments->out, "folder for exam.csv and failures.md")->check(some_text());
  command
      ->add_option("--write", arguments->write,
                   "write each question's scene and question.json into DIR/QUESTION")
      ->check(some_text())
      ->type_name("DIR");
  command->add_option("--grade", arguments->grade, "grade DIR/QUESTION/trajectory.csv")
      ->check(some_text())
      ->type_name("DIR");
  command
      ->add_option("--budget", arguments->seconds,
                   "CPU seconds after which a run fails its question; 60 if not given")
      ->check(finite_number())
      ->check(CLI::PositiveNumber)
      ->type_name("S");
  command->callback([&status, arguments] { status = exam(*arguments); });
}

}  // namespace perp
