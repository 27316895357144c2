// Maps over two parameters: borders that are known in closed form, and what a cell says.
#include <catch2/catch.hpp>
#include <cmath>

#include "perp/io/atlas.hpp"
#include "perp/step/event_driven.hpp"
#include "tests/cli/program.hpp"

namespace perp {
namespace {

/// Cells whose outcome is not the one that `is` says where all places within one cell agree on it.
int wrong(const AtlasRequest& request, const std::vector<AtlasCell>& cells, AtlasOutcome outcome,
          const std::function<bool(double a, double b)>& is) {
  int wrong = 0, judged = 0;
  for (std::size_t k = 0; k < cells.size(); ++k) {
    const int i = static_cast<int>(k) % request.a.count,
              j = static_cast<int>(k) / request.a.count % request.b.count;
    const bool here = is(cells[k].a, cells[k].b);
    bool inside = true;
    for (const int di : {-1, 0, 1})
      for (const int dj : {-1, 0, 1})
        inside = inside && is(request.a.value(i + di), request.b.value(j + dj)) == here;
    if (!inside) continue;
    ++judged;
    if ((cells[k].outcome == outcome) != here) {
      ++wrong;
      UNSCOPED_INFO(cells[k].method << " " << cells[k].a << " " << cells[k].b << " "
                                    << name_of(cells[k].outcome) << " " << cells[k].reason);
    }
  }
  CHECK(judged >= static_cast<int>(cells.size()) / 3);
  return wrong;
}

int silent(const std::vector<AtlasCell>& cells) {
  return static_cast<int>(std::count_if(
      cells.begin(), cells.end(), [](const AtlasCell& c) { return c.verdict == AtlasVerdict::Silent; }));
}

}  // namespace

TEST_CASE("the map of Painleve's rod has its border of jumps within a cell, 8 by 8, and nothing silent",
          "[map]") {
  const AtlasRequest request{.scene = "painleve-rod",
                             .methods = {"lcp", "ncp", "ncp2"},
                             .a = read_axis("mu=1:2.5:8", "--map"),
                             .b = read_axis("theta=0.7:1.4:8", "--map"),
                             .until = 2e-4,
                             .step = 1e-4};
  const std::vector<AtlasCell> cells = atlas(request);
  REQUIRE(cells.size() == 3 * 64);
  CHECK(silent(cells) == 0);
  CHECK(wrong(request, cells, AtlasOutcome::Jumps, [](double mu, double theta) {
          const double t = std::tan(theta);
          return mu > (4 + t * t) / (3 * t);
        }) == 0);
}

TEST_CASE("the map of a block on a slope has its border of sticking at mu = tan theta", "[map]") {
  AtlasRequest request{.scene = "incline-block",
                       .methods = {"lcp", "ncp2"},
                       .a = read_axis("mu=0.1:1.2:8", "--map"),
                       .b = read_axis("theta=0.1:0.8:8", "--map"),
                       .until = 0.2,
                       .step = 1e-2};
  const auto sticks = [](double mu, double theta) { return mu >= std::tan(theta); };
  std::vector<AtlasCell> cells = atlas(request);
  CHECK(silent(cells) == 0);
  CHECK(wrong(request, cells, AtlasOutcome::Sticks, sticks) == 0);
  request.a = read_axis("mu=0.57:0.584:8", "--map");  // zoomed: 2 % across
  request.b = read_axis("theta=0.518:0.529:8", "--map");
  cells = atlas(request);
  CHECK(wrong(request, cells, AtlasOutcome::Sticks, sticks) == 0);
}

TEST_CASE("perp study --map writes cells and pictures that are told apart without colour", "[map]") {
  const Scratch scratch("study-map");
  const Outcome done = run_perp(
      scratch, "study seed-sphere --methods lcp,penalty --map mu=0.1:0.4:3 --map h=0.001:0.1:4 --out " +
                   (scratch / "o"));
  CHECK(done.status == 0);
  CHECK(done.out.find("lcp: ") == 0);
  auto table = columns(scratch / "o/map.csv");
  REQUIRE(table["method"].size() == 24);
  CHECK(table["h"][0] == "0.001");
  CHECK(std::stod(table["h"][3]) == Approx(std::pow(100, 1 / 3.0) * 1e-3));  // geometric
  CHECK(table["mu"][1] == "0.25");
  CHECK(table["verdict"][0] == "right");
  CHECK(std::stod(table["error"][0]) < 1e-3);
  const std::string picture = contents(scratch / "o/lcp-map.svg");
  CHECK(picture.find("</svg>") != std::string::npos);
  CHECK(picture.find("<path") != std::string::npos);  // signs
  CHECK(std::filesystem::exists(scratch / "o/penalty-map.svg"));
  const auto refused = [&](const std::string& arguments) {
    const Outcome bad =
        run_perp(scratch, "study seed-sphere --methods lcp " + arguments + " --out " + (scratch / "p"));
    CHECK(bad.status == 2);
    return bad.err;
  };
  CHECK(refused("--map mu=0.1:0.4:3").find("twice") != std::string::npos);
  CHECK(refused("--map mu=0.1:0.4:3 --map mu=0:1:2").find("another axis") != std::string::npos);
  CHECK(refused("--map mu=0.4:0.1:3 --map h=0.1:1:2").find("NAME=LO:HI:N") != std::string::npos);
  CHECK(refused("--map colour=0:1:3 --map h=0.1:1:2").find("colour") != std::string::npos);
  CHECK(refused("--map mu=0:1:3 --map h=0:1:2").find("above 0") != std::string::npos);
  CHECK(refused("--map mu=0:1:3 --map h=0.1:1:2 --edges 4").find("--edges") != std::string::npos);
}

TEST_CASE("a map's cell tells a run that says it failed from one that is silently absurd", "[map]") {
  const Scratch scratch("map-spring");
  std::ofstream(scratch / "spring.toml")
      << "gravity = [0, 0, 0]\nt_end = 1\n[parameters]\nk = 1e4\n[[body]]\nname = \"p\"\nkind = "
         "\"particle\"\nmass = 1\n"
         "start = { position = [0.1, 0, 0] }\n[[spring]]\na = \"ground\"\nb = \"p\"\nstiffness = \"k\"\n";
  AtlasRequest request{.scene = scratch / "spring.toml",
                       .methods = {"lcp"},
                       .a = read_axis("h=0.001:0.09:4", "--map"),
                       .b = read_axis("k=9e3:1.1e4:2", "--map")};
  const AtlasCell calm = atlas_cell(request, "lcp", 0.001, 1e4), said = atlas_cell(request, "lcp", 0.05, 1e4);
  CHECK(calm.verdict != AtlasVerdict::SaidSo);
  CHECK(said.verdict == AtlasVerdict::SaidSo);
  CHECK_FALSE(said.reason.empty());
  CHECK(silent(atlas(request)) == 0);
}

}  // namespace perp
