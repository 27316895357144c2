#include "io/sweep_tables.hpp"

#include <algorithm>
#include <map>

#include "io/gnuplot.hpp"
#include "io/sweep_plan.hpp"
#include "perp/core/errors.hpp"
#include "perp/io/chart.hpp"
#include "perp/io/csv_file.hpp"

namespace perp {
namespace {

void write_runs(const SweepRequest& request, const SweepJournal::Contents& runs,
                const std::filesystem::path& path) {
  std::vector<std::string> header{"method"};
  for (const SweepAxis& axis : request.axes) header.push_back(axis.name);
  header.emplace_back("t");
  for (const std::string& ask : request.ask) header.push_back(ask);
  for (const char* name : {"pass", "failed", "message"}) header.emplace_back(name);
  CsvFile csv(path, header);
  for (const auto& [number, answer] : runs) {
    const SweepRun run = sweep_run(request, number);
    csv.cell(request.methods[run.method]);
    for (const double value : run.values) csv.cell(value);
    csv.cell(answer.t);
    for (const double value : answer.answers) csv.cell(value);
    request.pass.empty() || answer.failed ? csv.cell("") : csv.cell(answer.passed ? 1 : 0);
    csv.cell(answer.failed ? 1 : 0).cell(answer.message).end_row();
  }
  csv.finish();
}

/// Of the axes those that are not drawn.
std::vector<std::size_t> grid(const SweepRequest& request) {
  std::vector<std::size_t> axes;
  for (std::size_t i = 0; i < request.axes.size(); ++i)
    if (!request.axes[i].drawn) axes.push_back(i);
  return axes;
}

/// How many passed, by method and by the parameters that are not drawn.
void write_shares(const SweepRequest& request, const SweepJournal::Contents& runs,
                  const std::filesystem::path& path) {
  struct Count {
    long n = 0, passed = 0;
  };
  const std::vector<std::size_t> axes = grid(request);
  std::map<std::pair<std::size_t, std::vector<double>>, Count> counts;
  for (const auto& [number, answer] : runs) {
    const SweepRun run = sweep_run(request, number);
    std::vector<double> place;
    for (const std::size_t i : axes) place.push_back(run.values[i]);
    Count& count = counts[{run.method, place}];
    if (answer.failed) continue;
    ++count.n;
    count.passed += answer.passed;
  }
  std::vector<std::string> header{"method"};
  for (const std::size_t i : axes) header.push_back(request.axes[i].name);
  for (const char* name : {"n", "passed", "share", "low", "high"}) header.emplace_back(name);
  CsvFile csv(path, header);
  for (const auto& [place, count] : counts) {
    const Share share = wilson(count.passed, count.n);
    csv.cell(request.methods[place.first]);
    for (const double value : place.second) csv.cell(value);
    csv.cell(static_cast<int>(count.n)).cell(static_cast<int>(count.passed));
    csv.cell(share.share).cell(share.low).cell(share.high).end_row();
  }
  csv.finish();
}

/// A panel for each thing asked, a colour for each method.
std::string script(const SweepRequest& request) {
  const bool shares = !request.pass.empty() && !request.axes.front().drawn;
  const std::size_t panels = std::max<std::size_t>(1, request.ask.size() + (shares ? 1 : 0));
  std::string text =
      "# Draws sweep.svg from sweep.csv and shares.csv:  gnuplot sweep.gnuplot\nset terminal svg size 900," +
      std::to_string(60 + 280 * panels) +
      " dynamic enhanced font \"Helvetica,15\" background \"white\"\nset output \"sweep.svg\"\n"
      "set datafile separator \",\"\nset border 3 linecolor \"#666666\"\nset tics nomirror out\n"
      "set grid linecolor \"#dddddd\"\nset key outside right center samplen 1\nset offsets graph 0.02, "
      "graph 0.02, graph 0.05, graph 0.05\nset multiplot layout " +
      std::to_string(panels) + ",1\nset xlabel " + in_gnuplot_quotes(request.axes.front().name) + "\n";
  const auto panel = [&](const std::string& label, const auto& series) {
    text += "set ylabel " + in_gnuplot_quotes(label) + "\n";
    const char* separator = "plot ";
    for (std::size_t m = 0; m < request.methods.size(); ++m) {
      text += separator + series(m) + " linecolor \"" + palette(static_cast<int>(m)) + "\" title " +
              in_gnuplot_quotes(request.methods[m]);
      separator = ", \\\n     ";
    }
    text += "\n";
  };
  for (std::size_t i = 0; i < request.ask.size(); ++i)
    panel(request.ask[i], [&](std::size_t m) {
      return "\"sweep.csv\" every ::1 using (strcol(1) eq \"" + request.methods[m] +
             "\" ? $2 : NaN):" + std::to_string(request.axes.size() + 3 + i) +
             " with points pointtype 7 pointsize 0.5";
    });
  const auto column = [n = grid(request).size()](std::size_t k) { return std::to_string(n + 1 + k); };
  if (shares)
    panel("share with " + request.pass, [&](std::size_t m) {
      return "\"shares.csv\" every ::1 using (strcol(1) eq \"" + request.methods[m] +
             "\" ? $2 : NaN):" + column(3) + ":" + column(4) + ":" + column(5) +
             " with yerrorbars pointtype 7 pointsize 0.6";
    });
  return text + (request.ask.empty() && !shares ? "plot 1/0 notitle\n" : "") + "unset multiplot\n";
}

}  // namespace

std::string write_sweep(const SweepRequest& request, const SweepJournal::Contents& runs,
                        const std::filesystem::path& folder) {
  write_runs(request, runs, folder / "sweep.csv");
  std::error_code none_there;
  if (request.pass.empty())
    std::filesystem::remove(folder / "shares.csv", none_there);
  else
    write_shares(request, runs, folder / "shares.csv");
  replace_file(folder / "sweep.gnuplot", script(request));
  std::filesystem::remove(folder / "sweep.svg", none_there);
  const std::string failed = run_gnuplot(folder, "sweep.gnuplot");
  if (!failed.empty()) std::filesystem::remove(folder / "sweep.svg", none_there);
  return failed;
}

}  // namespace perp
