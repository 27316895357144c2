// The page of where methods fail: the exam's questions of part C, methods side by side.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <sstream>

#include "perp/io/exam.hpp"
#include "perp/version.hpp"

namespace perp {
namespace {

std::string in_short(double x) {
  char text[32];
  std::snprintf(text, sizeof text, "%.2g", x);
  return x == x ? text : "-";
}

bool of_part_c(const std::string& question) {
  return question.size() > 1 && question[0] == 'C' && std::isdigit(question[1]);
}

/// The answer that decides: the first that is not passed, else the first.
const ExamAnswer* deciding(const std::vector<ExamAnswer>& answers, const std::string& question,
                           const std::string& method) {
  const ExamAnswer* found = nullptr;
  for (const ExamAnswer& a : answers)
    if (a.question == question && a.method == method &&
        (found == nullptr || (found->verdict == ExamVerdict::Pass && a.verdict != ExamVerdict::Pass)))
      found = &a;
  return found;
}

std::string cell(const ExamAnswer* a) {
  if (a == nullptr) return "";
  switch (a->verdict) {
    case ExamVerdict::Pass:
      return "right";
    case ExamVerdict::SaidSo:
      return "**said so**";
    case ExamVerdict::NotApplicable:
      return "-";
    default:
      return "**" + a->quantity + " " + in_short(a->value) + "**";
  }
}

std::string without_bars(std::string text) {
  for (std::size_t at = 0; (at = text.find('|', at)) != std::string::npos; at += 2)
    text.replace(at, 1, "\\|");
  return text;
}

}  // namespace

std::string failures_page(const std::vector<ExamAnswer>& answers) {
  std::vector<std::string> methods;
  for (const ExamAnswer& a : answers)
    if (std::find(methods.begin(), methods.end(), a.method) == methods.end()) methods.push_back(a.method);
  std::ostringstream out;
  out << "# Where methods fail\n\nWritten by `perp exam METHOD... --out DIR` (perp " << version
      << "), which puts each question to every method with one step and one tolerance; DIR/exam.csv has all "
         "numbers. *right*: "
         "within the tolerance. *said so*: a step failed and said why. Otherwise the quantity that is wrong, "
         "and what it came "
         "to: [m, rad], [m/s, rad/s] or [J].\n\n| question | step [s] |";
  for (const std::string& m : methods) out << " `" << m << "` |";
  out << "\n|---|---|";
  for (std::size_t i = 0; i < methods.size(); ++i) out << "---|";
  out << "\n";
  std::ostringstream reasons;
  for (const ExamQuestion& question : exam_questions()) {
    if (!of_part_c(question.name)) continue;
    const bool asked = std::any_of(answers.begin(), answers.end(),
                                   [&](const ExamAnswer& a) { return a.question == question.name; });
    if (!asked) continue;
    out << "| " << question.name << ": " << question.why << " | " << in_short(question.step) << " |";
    for (const std::string& m : methods) {
      const ExamAnswer* a = deciding(answers, question.name, m);
      out << " " << cell(a) << " |";
      if (a == nullptr || a->verdict == ExamVerdict::Pass) continue;
      reasons << "- " << question.name << ", `" << m << "`: ";
      if (!a->reason.empty())
        reasons << without_bars(a->reason);
      else
        reasons << a->quantity << " is " << in_short(a->value) << ", right is " << in_short(a->right)
                << " to " << in_short(a->tolerance);
      reasons << "\n";
    }
    out << "\n";
  }
  out << "\n## The measured reasons\n" << reasons.str();
  return out.str();
}

}  // namespace perp
