#include "perp/io/chart.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <set>
#include <stdexcept>
#include <string>

#include "perp/io/study_files.hpp"
#include "perp/study/work_precision.hpp"

namespace perp {
namespace {

namespace fs = std::filesystem;

std::string contents(const fs::path& path) {
  std::ifstream in(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

/// A folder of the test's own, gone with it.
struct Scratch {
  fs::path path;
  explicit Scratch(const char* name) : path(fs::temp_directory_path() / (std::string("perp-") + name)) {
    fs::remove_all(path);
  }
  ~Scratch() { fs::remove_all(path); }
};

bool has_gnuplot() { return std::system("command -v gnuplot >/dev/null") == 0; }

bool contains(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

Chart chart() {
  Chart c{.title = "a_b^c & \"d\"", .x_label = "h [s]", .y_label = "error [m]", .lines = {}};
  c.lines.push_back({.label = "first", .x = {0.1, 0.01, 0.001}, .y = {1e-2, 1e-4, 1e-6}});
  c.lines.push_back(
      {.label = "second", .x = {0.1, 0.01}, .y = {1e-1, not_set}, .colour = 1, .missing = {0.001}});
  c.lines.push_back({.label = "", .x = {0.1, 0.01}, .y = {0.0, 1e-2}, .dashed = true, .colour = 1});
  c.slopes.push_back({.line = 0, .order = 2});
  c.floors.push_back({.y = 0.03, .colour = 1});
  return c;
}

StudyRun run(const char* method, int level, double h, double q, double limit, double seconds,
             int failed = 0) {
  StudyRun r{.method = method, .parameter = "edges=8", .level = level};
  r.h = h, r.error_q = q, r.error_limit = limit, r.seconds = seconds, r.failed = failed;
  return r;
}

/// A method that floats above a floor and converges to its own limit, with one run that failed.
ConvergenceTable table() {
  ConvergenceTable t{.scene = "s", .runs = {}, .orders = {}};
  t.runs.push_back(run("lcp", 0, 0.1, 0.5, 0.4, 1e-3));
  t.runs.push_back(run("lcp", 0, 0.08, 0.6, 0.3, 3e-3));
  t.runs.push_back(run("lcp", 1, 0.05, not_set, not_set, 4e-3, 1));
  t.runs.push_back(run("lcp", 2, 0.025, 0.3, 0.1, 8e-3));
  OrderRow exact{.method = "lcp", .parameter = "edges=8"}, limit = exact;
  exact.q.floor = 0.3;
  exact.q.note = "stalls at 0.3";
  limit.reference = OrderReference::Limit;
  limit.expected = 1;
  limit.q.order = 0.98;
  limit.q.points = 3;
  limit.v.note = "too few points for an order";
  limit.failed = 1;
  t.orders = {exact, limit};
  return t;
}

}  // namespace

TEST_CASE("a chart leaves its data and a script that draws the picture again", "[chart]") {
  const Scratch scratch("chart");
  const std::string why = write_chart(chart(), scratch.path, "picture");
  CHECK(contents(scratch.path / "picture.csv") ==
        "first: h [s],first: error [m],second: h [s],second: error [m],h [s],error [m]\n"
        "0.1,0.01,0.1,0.1,,\n"
        "0.01,1e-04,,,0.01,0.01\n"
        "0.001,1e-06,,,,\n");
  const std::string script = contents(scratch.path / "picture.gnuplot");
  CHECK(contains(script, "set logscale xy"));
  CHECK(contains(script, "set title \"a\\\\_b\\\\^c \\\\& \\\"d\\\"\""));  // letters, not typesetting
  CHECK(contains(script, "using 3:4"));
  CHECK(contains(script, palette(0)));
  if (!has_gnuplot()) {
    CHECK(why == "gnuplot is not installed");
    return;
  }
  CHECK(why.empty());
  const std::string svg = contents(scratch.path / "picture.svg");
  CHECK(contains(svg, "</svg>"));
  for (const char* text : {"first", "second", "error [m]", "0.03"}) CHECK(contains(svg, text));
  fs::remove(scratch.path / "picture.svg");
  CHECK(std::system(("cd " + scratch.path.string() + " && gnuplot picture.gnuplot").c_str()) == 0);
  CHECK(contents(scratch.path / "picture.svg") == svg);
}

TEST_CASE("a slope's triangle has the steepness of its order and stays under its line", "[chart]") {
  const Scratch scratch("chart-slope");
  (void)write_chart(chart(), scratch.path, "picture");
  const std::string script = contents(scratch.path / "picture.gnuplot");
  double x0, y0, x1, y1, x2, y2;
  const std::size_t at = script.find("polygon from ");
  REQUIRE(at != std::string::npos);
  REQUIRE(std::sscanf(script.c_str() + at, "polygon from %lf,%lf to %lf,%lf to %lf,%lf", &x0, &y0, &x1, &y1,
                      &x2, &y2) == 6);
  CHECK(y1 == Approx(y0));
  CHECK(x2 == Approx(x1));
  CHECK(std::log(y2 / y1) / std::log(x1 / x0) == Approx(2));
  CHECK(y0 < x0 * x0);  // the line is err = h^2
  CHECK(y2 < x2 * x2);
}

TEST_CASE("the first seven colours differ, then they come again", "[chart]") {
  std::set<std::string> seen;
  for (int i = 0; i < 7; ++i) seen.insert(palette(i));
  CHECK(seen.size() == 7);
  CHECK(palette(7) == palette(0));
}

TEST_CASE("a chart that cannot be drawn is refused", "[chart]") {
  const Scratch scratch("chart-refused");
  for (const char* name : {"", "../up", "a b", ".hidden", "a;b"})
    CHECK_THROWS_AS(write_chart(chart(), scratch.path, name), std::invalid_argument);
  Chart uneven = chart();
  uneven.lines[0].x.pop_back();
  CHECK_THROWS_AS(write_chart(uneven, scratch.path, "picture"), std::invalid_argument);
}

TEST_CASE(
    "study.csv and orders.csv have the interface's columns first, and empty cells for what is not known",
    "[chart]") {
  const Scratch scratch("study-files");
  table().write_csv(scratch.path / "study.csv");
  write_orders_csv(scratch.path / "orders.csv", {table()});
  const std::string study = contents(scratch.path / "study.csv"),
                    orders = contents(scratch.path / "orders.csv");
  CHECK(study.rfind("scene,method,parameter,h,rtol,error_q,error_v,seconds,steps,iterations,failed,error_"
                    "limit,message,reference,bar_q,bar_v,error_path,error_p\n"
                    "s,lcp,edges=8,0.1,,0.5,,0.001,0,0,0,0.4,,exact,0,0,,\n",
                    0) == 0);
  CHECK(contains(study, "s,lcp,edges=8,0.05,,,,0.004,0,0,1,,,exact,0,0,,\n"));
  CHECK(orders ==
        "scene,method,parameter,reference,order,order_v,points,expected,failed,note,bar,h_least,h_most,"
        "slopes,why,order_path,order_p\n"
        "s,lcp,edges=8,exact,,,0,,0,stalls at 0.3,0,,,,,,\n"
        "s,lcp,edges=8,limit,0.98,,3,1,1,velocity: too few points for an order,,,,,,,\n");
}

TEST_CASE("a convergence chart shows the floor, the limit beside it, its slope and the run that failed",
          "[chart]") {
  const Chart c = convergence_chart(table());
  REQUIRE(c.lines.size() == 3);
  CHECK(c.lines[0].label == "lcp, edges=8");
  CHECK(c.lines[0].x == std::vector<double>{0.1, 0.05, 0.025});
  CHECK(c.lines[0].y[0] == 0.6);  // the largest of the level
  CHECK(std::isnan(c.lines[0].y[1]));
  CHECK(c.lines[0].missing == std::vector<double>{0.05});
  CHECK(c.lines[1].dashed);
  CHECK(c.lines[1].colour == c.lines[0].colour);
  CHECK(c.lines[1].y[0] == 0.4);
  CHECK(c.lines[2].label == "against own limit");
  REQUIRE(c.floors.size() == 1);
  CHECK(c.floors[0].y == 0.3);
  REQUIRE(c.slopes.size() == 1);
  CHECK(c.slopes[0].line == 1);
  CHECK(c.slopes[0].order == 1);
}

TEST_CASE("a work chart has a level's largest error over its mean CPU time, without levels that failed",
          "[chart]") {
  const Chart c = work_chart(table());
  REQUIRE(c.lines.size() == 1);
  CHECK(c.lines[0].x == std::vector<double>{2e-3, 8e-3});
  CHECK(c.lines[0].y == std::vector<double>{0.6, 0.3});
}

}  // namespace perp
