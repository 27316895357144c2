#include <catch2/catch.hpp>

#include "perp/perp.hpp"
#include "tests/cli/program.hpp"

namespace perp {
namespace {

TEST_CASE("perp --version and --help, of the program and of a command, end with status 0", "[program]") {
  const Scratch scratch("program-help");
  CHECK(run_perp(scratch, "--version").out == std::string("perp ") + version + "\n");
  CHECK(run_perp(scratch, "--help").out.find("scenes") != std::string::npos);
  CHECK(run_perp(scratch, "run --help").out.find("--method") != std::string::npos);
  for (const char* arguments : {"--version", "--help", "run --help", "scenes --help", "methods --help"}) {
    CHECK(run_perp(scratch, arguments).status == 0);
  }
}

TEST_CASE("a standard output that cannot be written is an internal error", "[program]") {
  const Scratch scratch("program-full");
  const int raw = std::system((PERP_PROGRAM " scenes --csv >/dev/full 2>" + (scratch / "stderr")).c_str());
  CHECK(WEXITSTATUS(raw) == 3);
  CHECK(contents(scratch / "stderr").substr(0, 6) == "perp: ");
}

TEST_CASE("perp scenes --csv has a row for each built-in scene, with values that perp run takes back",
          "[scenes]") {
  const Scratch scratch("scenes");
  const Outcome done = run_perp(scratch, "scenes --csv");
  REQUIRE(done.status == 0);
  CHECK(done.out.substr(0, done.out.find('\n')) == "name,id,until,exact,methods,parameters");
  auto table = columns(scratch / "stdout");
  CHECK(table["name"] == scene_names());
  std::string every;
  for (const Method& method : methods()) every += (every.empty() ? "" : " ") + std::string(method.name);
  const auto those = [&](const Scene& s) -> std::string {
    return s.model.contact_with_moments() == nullptr ? every
                                                     : "lcp lcp-ap ncp ncp-start ncp2 event extrapolated";
  };
  for (std::size_t i = 0; i < table["name"].size(); ++i) {
    const Scene s = scene(table["name"][i]);
    CHECK(std::stod(table["until"][i]) == s.t_end);
    CHECK(table["exact"][i] == (s.exact ? "yes" : "no"));
    CHECK(table["methods"][i] == those(s));
    std::istringstream settings(table["parameters"][i]);
    for (std::string setting; settings >> setting;) {
      const std::size_t equals = setting.find('=');
      const double value = std::stod(setting.substr(equals + 1));
      CHECK_NOTHROW(scene(s.name, {{setting.substr(0, equals), value}}));
    }
  }
}

TEST_CASE("perp methods --csv lists the methods that perp run takes", "[methods]") {
  const Scratch scratch("methods");
  REQUIRE(run_perp(scratch, "methods --csv").status == 0);
  auto table = columns(scratch / "stdout");
  REQUIRE(table["name"].size() == methods().size());
  for (std::size_t i = 0; i < methods().size(); ++i) {
    CHECK(table["name"][i] == methods()[i].name);
    CHECK(std::stoi(table["order"][i]) == methods()[i].order);
  }
}

}  // namespace
}  // namespace perp
