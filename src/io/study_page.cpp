#include "io/study_page.hpp"

#include <cmath>
#include <cstdio>
#include <fstream>
#include <iterator>

#include "io/study_motion.hpp"
#include "perp/core/errors.hpp"
#include "perp/io/study_files.hpp"
#include "perp/version.hpp"

namespace perp {
namespace {

constexpr double agrees = 0.1;  // an observed order this close to the expected one

constexpr const char* style = R"(
:root { color-scheme: light; }
body { font: 16px/1.5 Helvetica, Arial, sans-serif; color: #222; background: #fff; max-width: 1180px; margin: 2.5em auto; padding: 0 1.5em; }
h1 { font-weight: 600; font-size: 1.7em; margin: 0 0 .2em; }
h2 { font-weight: 600; font-size: 1.3em; margin: 2.2em 0 .2em; border-top: 1px solid #ddd; padding-top: 1em; }
p { margin: .3em 0; } .quiet { color: #666; font-size: .92em; }
nav a { margin-right: 1em; } a { color: #0072B2; }
.charts { display: grid; grid-template-columns: repeat(auto-fit, minmax(430px, 1fr)); gap: 1em; margin: 1em 0; }
.charts svg { width: 100%; height: auto; }
table { border-collapse: collapse; font-size: .92em; margin: .6em 0; font-variant-numeric: tabular-nums; }
th, td { text-align: left; padding: .22em .9em .22em 0; border-bottom: 1px solid #e8e8e8; vertical-align: top; }
th { color: #666; font-weight: 500; } td.n { text-align: right; }
.agrees { color: #00704f; font-weight: 600; } .differs { color: #b34a00; font-weight: 600; }
.good, .bad { padding: .7em 1em; margin: 1em 0; border-left: 4px solid #009E73; background: #f1f9f6; }
.bad { border-color: #D55E00; background: #fdf3ec; }
details { margin: .6em 0; } summary { cursor: pointer; color: #0072B2; }
)";

std::string escaped(std::string_view text) {
  std::string result;
  for (const char c : text) switch (c) {
      case '<':
        result += "&lt;";
        break;
      case '>':
        result += "&gt;";
        break;
      case '&':
        result += "&amp;";
        break;
      case '"':
        result += "&quot;";
        break;
      default:
        result += c;
    }
  return result;
}

std::string format(const char* pattern, double value) {
  if (std::isnan(value)) return "";
  char text[40];
  std::snprintf(text, sizeof text, pattern, value);
  return text;
}

/// A table's row: cells in HTML, numbers to the right.
class Row {
 public:
  Row& text(std::string_view words) { return add("<td>", escaped(words)); }
  Row& number(const char* pattern, double value) { return add("<td class=n>", format(pattern, value)); }
  Row& html(const std::string& words) { return add("<td class=n>", words); }
  std::string end() const { return "<tr>" + row_ + "</tr>\n"; }

 private:
  Row& add(const char* begin, const std::string& words) {
    row_ += begin + words + "</td>";
    return *this;
  }
  std::string row_;
};

std::string head(std::initializer_list<const char*> names) {
  std::string row;
  for (const char* name : names) row += "<th>" + escaped(name) + "</th>";
  return "<table>\n<tr>" + row + "</tr>\n";
}

/// The picture itself, its identifiers made its own: several stand in one page.
std::string picture(const std::filesystem::path& file, const std::string& name) {
  std::ifstream in(file, std::ios::binary);
  std::string svg{std::istreambuf_iterator<char>(in), {}};
  const std::size_t begin = svg.find("<svg");
  if (begin == std::string::npos) return "<p class=quiet>" + escaped(name) + ": no picture</p>\n";
  svg.erase(0, begin);
  for (const char* mark : {"id=\"", "id='", "href=\"#", "href='#", "url(#"}) {
    const std::string own = mark + name + "-";
    for (std::size_t at = 0; (at = svg.find(mark, at)) != std::string::npos; at += own.size())
      svg.replace(at, std::string_view(mark).size(), own);
  }
  return svg + "\n";
}

std::string failures(const StudyPage& page) {
  const StudyOutcome& outcome = page.outcome;
  std::string rows;
  for (const ConvergenceTable& table : outcome.tables)
    for (const StudyRun& run : table.runs)
      if (run.failed)
        rows += Row()
                    .text(table.scene)
                    .text(run.method)
                    .text(run.parameter)
                    .number("%.6g", run.h)
                    .number("%.0f", run.steps)
                    .text(run.message)
                    .end();
  const int there = outcome.before + outcome.made;
  std::string text;
  if (outcome.left() > 0)
    text += "<p class=bad>" + std::to_string(outcome.left()) + " of " + std::to_string(outcome.planned) +
            " runs have not been made yet: orders are of the others.</p>\n";
  if (rows.empty())
    return text + "<p class=good>All steps of " + std::to_string(there) +
           " runs reached their tolerance.</p>\n";
  return text + "<div class=bad><p>In " + std::to_string(outcome.failed) + " of " + std::to_string(there) +
         " runs a step did not reach its tolerance, and the run ended there.</p>\n" +
         head({"scene", "method", "", "h [s]", "steps before", "what it said"}) + rows + "</table></div>\n";
}

std::string order_cell(const OrderRow& row) {
  const std::string order = format("%.3f", row.q.order);
  if (!row.q.known() || std::isnan(row.expected)) return order;
  const bool close = std::abs(row.q.order - row.expected) <= agrees;
  return std::string("<span class=") + (close ? "agrees>" : "differs>") + order + "</span>";
}

std::string remark(const StudyRun& run, const ConvergenceTable& table) {
  return run.failed ? "failed" : run.error_q <= table.bar_q && table.bar_q > 0 ? "within the bar" : "";
}

/// A link to the motion where it is there, and in any case the command that makes it.
std::string motion_line(const StudyRequest& request, const ScenePlan& plan, const std::string& asked,
                        const std::filesystem::path& folder) {
  const std::string name = plan.scene().name;
  const std::filesystem::path place = motion_folder(folder, name);
  std::string command;
  for (const std::string& word : motion_command(motion_of(request, asked, plan.t_end()), place)) {
    const bool plain =
        word.find_first_not_of("abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789-_=+./,:") ==
        std::string::npos;
    std::string quoted = word;
    for (std::size_t i = 0; !plain && (i = quoted.find('\'', i)) != std::string::npos; i += 4)
      quoted.replace(i, 1, "'\\''");
    command += (command.empty() ? "" : " ") + (plain ? word : "'" + quoted + "'");
  }
  const bool there = std::filesystem::exists(place / "view.html");
  return "<p class=quiet>" +
         (there ? "<a href=\"" + place.filename().string() + "/view.html\">The motion</a>, by"
                : std::string("The motion:")) +
         " <code>" + escaped(command) + "</code></p>\n";
}

std::string scene_section(const ScenePlan& plan, const ConvergenceTable& table, const std::string& motion,
                          const std::filesystem::path& folder) {
  const Scene& scene = plan.scene();
  const std::string name = chart_name(table.scene);
  std::string text =
      "<h2 id=\"" + name + "\">" + escaped(table.scene) + "</h2>\n<p>" + escaped(scene.what) + "</p>\n";
  text += "<p class=quiet>T = " + shortest(plan.t_end()) + " s";
  for (const SceneParameter& p : scene.parameters) text += ", " + escaped(p.name) + " = " + shortest(p.value);
  text += "; " + escaped(table.words) + "</p>\n" + motion + "<div class=charts>\n";
  for (const char* kind : {"-convergence", "-work"})
    text += picture(folder / (name + kind + ".svg"), name + kind);
  text += "</div>\n" + head({"method", "", "reference", "order", "expected", "order of velocity", "points",
                             "fitted h [s]", "local slopes", "note", "why not as expected"});
  for (const OrderRow& row : table.orders)
    text += Row()
                .text(row.method)
                .text(row.parameter)
                .text(name_of(row.reference))
                .html(order_cell(row))
                .number("%g", row.expected)
                .number("%.3f", row.v.order)
                .number("%.0f", row.q.points)
                .text(std::isnan(row.q.h_least)
                          ? ""
                          : format("%.3g", row.q.h_least) + " to " + format("%.3g", row.q.h_most))
                .text(local_slopes(row.q))
                .text(note_of(row))
                .text(row.why)
                .end();
  text += "</table>\n<details><summary>all " + std::to_string(table.runs.size()) + " runs</summary>\n";
  text += head({"method", "", "h [s]", "error_q", "error_v", "against own limit", "CPU [s]", "steps",
                "iterations", ""});
  for (const StudyRun& run : table.runs)
    text += Row()
                .text(run.method)
                .text(run.parameter)
                .number("%.6g", run.h)
                .number("%.3e", above_bar(run.error_q, table.bar_q))
                .number("%.3e", above_bar(run.error_v, table.bar_v))
                .number("%.3e", run.error_limit)
                .number("%.2e", run.seconds)
                .number("%.0f", run.steps)
                .number("%.0f", run.iterations)
                .text(remark(run, table))
                .end();
  return text + "</table></details>\n";
}

}  // namespace

std::string chart_name(const std::string& scene) {
  std::string name = scene;
  for (char& c : name) {
    const bool plain = (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_';
    if (!plain) c = '-';
  }
  return name;
}

std::string write_page(const StudyPage& page, const std::filesystem::path& folder) {
  std::string text =
      "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n<title>perp "
      "study</title>\n<style>";
  text += style;
  text += "</style>\n</head>\n<body>\n<h1>Accuracy and cost</h1>\n<p>";
  for (const std::string& name : page.request.methods)
    text += escaped(name) + (&name == &page.request.methods.back() ? "" : ", ");
  text += " on";
  for (const ConvergenceTable& table : page.outcome.tables)
    text += " <a href=\"#" + chart_name(table.scene) + "\">" + escaped(table.scene) + "</a>";
  text += "</p>\n" + failures(page);
  for (std::size_t i = 0; i < page.scenes.size(); ++i)
    text += scene_section(*page.scenes[i], page.outcome.tables[i],
                          motion_line(page.request, *page.scenes[i], page.request.scenes[i], folder), folder);
  text += "<h2>Machine</h2>\n";
  for (const std::string& machine : page.machines) text += "<p>" + escaped(machine) + "</p>\n";
  text +=
      "<p class=quiet>CPU seconds of the thread, the best of repeated runs. study.csv and orders.csv beside "
      "this page hold "
      "its numbers, and each chart's data and script are there. Written by perp " +
      std::string(version) + ".</p>\n</body>\n</html>\n";
  return text;
}

}  // namespace perp
