// include and [[repeat]]: scene files made of parts, run to the bytes of the file that says all of it itself.
#include <catch2/catch.hpp>

#include "tests/cli/program.hpp"

namespace perp {
namespace {

using Catch::Contains;

void write(const std::string& path, const std::string& text) { std::ofstream(path) << text; }

std::string body(const std::string& name, const std::string& x) {
  return "[[body]]\nname = \"" + name + "\"\nkind = \"particle\"\nmass = 1\nposition = [" + x + ", 0, 0]\n";
}

std::string contact(const std::string& name) {
  return "[[contact]]\nname = \"under-" + name + "\"\na = \"ground\"\nb = \"" + name +
         "\"\ngap = { kind = \"particle_on_plane\" }\nmu = 0.1\n";
}

void check_same_run(const Scratch& scratch, const std::string& a, const std::string& b) {
  for (const std::string& file : {a, b}) {
    const Outcome run =
        run_perp(scratch, "run " + (scratch / file) + " --method lcp --step 0.01 --until 0.1 --out " +
                              (scratch / (file + ".d")));
    CAPTURE(file, run.err);
    REQUIRE(run.status == 0);
  }
  for (const std::string table : {"/trajectory.csv", "/contacts.csv", "/report.csv"})
    CHECK(contents(scratch / (a + ".d" + table)) == contents(scratch / (b + ".d" + table)));
}

TEST_CASE("[[repeat]] writes its tables once a number, in order, with expressions of counters and parameters",
          "[scene_parts]") {
  const Scratch scratch("repeat");
  write(scratch / "long.toml", body("first", "9") + body("b0", "0") + body("b1", "0.5") + body("b2", "1") +
                                   contact("b0") + contact("b1") + contact("b2") +
                                   "[[spring]]\na = \"b0\"\nb = \"b1\"\nstiffness = 10\n"
                                   "[[spring]]\na = \"b1\"\nb = \"b2\"\nstiffness = 20\n");
  write(scratch / "short.toml",
        "[parameters]\ncount = 3\ngap = 0.5\n" + body("first", "9") +
            "[[repeat]]\nover = \"i\"\nn = \"count\"\n[[repeat.body]]\nname = \"b${i}\"\n"
            "kind = \"particle\"\nmass = 1\nposition = [\"gap*${i}\", 0, 0]\n"
            "[[repeat.contact]]\nname = \"under-b${i}\"\na = \"ground\"\nb = \"b${i}\"\n"
            "gap = { kind = \"particle_on_plane\" }\nmu = 0.1\n"
            "[[repeat]]\nover = \"i\"\nfrom = 1\nto = \"count - 1\"\n[[repeat.spring]]\n"
            "a = \"b${i - 1}\"\nb = \"b${i}\"\nstiffness = \"10*${i}\"\n");
  check_same_run(scratch, "long.toml", "short.toml");
  CHECK_THAT(run_perp(scratch, "check " + (scratch / "short.toml") + " --set count=5").out,
             Contains("body b4: ") && Contains("springs 4, "));
}

TEST_CASE("repeats in repeats know both counters", "[scene_parts]") {
  const Scratch scratch("repeat-grid");
  write(scratch / "grid.toml",
        "[[repeat]]\nover = \"i\"\nn = 2\n[[repeat.repeat]]\nover = \"j\"\nfrom = 2\nto = "
        "4\n[[repeat.repeat.body]]\n"
        "name = \"b${i}-${j}\"\nkind = \"particle\"\nmass = 1\nposition = [\"${i}\", \"${j}\", \"${10*i + "
        "j}\"]\n");
  const std::string out = run_perp(scratch, "check " + (scratch / "grid.toml")).out;
  for (const char* line :
       {"body b0-2: particle, 1 kg, at (0, 2, 2)", "body b0-4: particle, 1 kg, at (0, 4, 4)",
        "body b1-3: particle, 1 kg, at (1, 3, 13)"})
    CHECK_THAT(out, Contains(line));
  CHECK(out.find("b0-4") < out.find("b1-2"));
  CHECK(out.find("b2") == std::string::npos);
  CHECK(out.find("b0-5") == std::string::npos);
}

TEST_CASE("an included file's tables come first, and the including file's own keys and parameters hold",
          "[scene_parts]") {
  const Scratch scratch("include");
  std::filesystem::create_directories(scratch / "parts");
  write(scratch / "whole.toml", "gravity = [0, 0, -5]\n" + body("a", "1") + body("b", "2") + contact("a"));
  write(scratch / "parts/deep.toml", "[parameters]\nx = 7\ny = 2\ng = -9\n" + body("a", "\"x\""));
  write(scratch / "parts/a.toml",
        "include = \"deep.toml\"\ngravity = [0, 0, \"g\"]\nt_end = 3\n[parameters]\ng = -5\n");
  write(scratch / "s.toml",
        "include = [\"parts/a.toml\"]\n[parameters]\nx = 1\n" + body("b", "\"y\"") + contact("a"));
  check_same_run(scratch, "whole.toml", "s.toml");
  CHECK_THAT(run_perp(scratch, "check " + (scratch / "s.toml")).out, Contains("t_end = 3 s"));
  // and a run of it needs none of the files to go on
  const std::string out = scratch / "o";
  REQUIRE(
      run_perp(scratch, "run " + (scratch / "s.toml") + " --method lcp --step 1e-6 --budget 0 --out " + out)
          .status == 1);
  const std::string text = contents(scratch / "parts/deep.toml");
  write(scratch / "parts/deep.toml", text + "# changed\n");
  const Outcome changed = run_perp(scratch, "run --resume " + out + " --budget 0");
  CHECK(changed.status == 2);
  CHECK_THAT(changed.err, Contains("deep.toml is no longer that of the run"));
  std::filesystem::remove_all(scratch / "parts");
  std::filesystem::remove(scratch / "s.toml");
  CHECK(run_perp(scratch, "run --resume " + out + " --budget 0").status == 1);
}

TEST_CASE("mistakes in parts are placed in the file that makes them", "[scene_parts]") {
  const Scratch scratch("part-mistakes");
  const auto refused = [&](const std::string& text, const std::string& says) {
    write(scratch / "s.toml", text);
    const Outcome outcome = run_perp(scratch, "check " + (scratch / "s.toml"));
    CAPTURE(text, outcome.err);
    CHECK(outcome.status == 2);
    CHECK_THAT(outcome.err, Contains(says));
  };
  write(scratch / "wrong.toml", "[[body]]\nname = \"a\"\nkind = \"particle\"\nmess = 1\n");
  write(scratch / "round.toml", "include = \"round.toml\"\n");
  refused("include = \"wrong.toml\"\n", "wrong.toml:4:1: the key 'mess'");
  refused("include = \"round.toml\"\n", "round.toml:1:11: ");
  refused("include = \"none.toml\"\n", "s.toml:1:11: include = \"none.toml\", ");
  refused("include = 3\n", "s.toml:1:11: include is the number 3");
  const std::string rest = "[[repeat.body]]\nname = \"b${i}\"\nkind = \"particle\"\nmass = 1\n";
  refused("[[repeat]]\nover = \"i\"\n" + rest, "s.toml:1:1: a repeat, needs n, or from and to");
  refused("[[repeat]]\nover = \"i\"\nn = 2\nto = 3\n" + rest, "needs n, or from and to");
  refused("[[repeat]]\nover = \"i\"\nn = 2.5\n" + rest, "s.toml:3:5: n = 2.5, needs a whole number");
  refused("[[repeat]]\nover = \"i\"\nn = 1e9\n" + rest, "s.toml:3:5: n = 1e+09");
  refused("[[repeat]]\nover = \"pi\"\nn = 2\n" + rest, "s.toml:2:8: over is \"pi\"");
  refused("[[repeat]]\nover = \"j\"\nn = 2\n" + rest, "s.toml:5:8: name has ${i}");
  refused("[[repeat]]\nover = \"i\"\nn = 2\n[[repeat.body]]\nname = \"b${i\"\n", "needs a } after ${");
  refused("[[repeat]]\nover = \"i\"\nn = 2\nmass = 1\n" + rest, "s.toml:4:1: the key 'mass'");
  refused("[[repeat]]\nover = \"i\"\nn = 2\n[[repeat.body]]\nname = \"b\"\nkind = \"particle\"\nmass = 1\n",
          "b");
}

}  // namespace
}  // namespace perp
