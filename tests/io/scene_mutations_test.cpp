// Good scene files, each spoilt in one place: the reader says where, or the scene runs.
#include <catch2/catch.hpp>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>
#include <random>
#include <sstream>

#include "perp/io/scene_file.hpp"
#include "perp/step/lcp_stepper.hpp"
#include "perp/step/simulate.hpp"

using namespace perp;

namespace {

struct Good {
  std::string name, text;
};

std::vector<Good> good_files() {
  std::vector<Good> files;
  const std::filesystem::path scenes =
      std::filesystem::path(PERP_TEST_FOLDER) / ".." / ".." / "examples" / "scenes";
  for (const char* name : {"box-on-belt", "marble-off-table", "shaken-pendulum"}) {
    std::ifstream in(scenes / (std::string(name) + ".toml"), std::ios::binary);
    REQUIRE(in);
    files.push_back({name, {std::istreambuf_iterator<char>(in), {}}});
  }
  for (const char* name :
       {"seed-sphere", "friction-pendulum", "spring-block", "shaker", "stack", "heavy-top", "bead-in-ring"})
    files.push_back({name, write_scene(scene(name))});
  return files;
}

/// "KEY = VALUE" of one line, and the tables in whose part of the file it stands.
struct Line {
  std::string key, value;
  bool in_parameters = false;
  std::size_t header = 0;  ///< line of its [[...]]; 0 at the top
};

/// Of each line, from 1; those that are no "KEY = VALUE" have an empty key.
std::vector<Line> lines_of(const std::string& text) {
  std::vector<Line> lines(1);
  std::istringstream in(text);
  Line where;
  for (std::string line; std::getline(in, line);) {
    Line now = where;
    const std::size_t equals = line.find(" = ");
    if (line.starts_with("[")) {
      where.header = lines.size();
      where.in_parameters = line.starts_with("[parameters]");
    } else if (equals != std::string::npos && line[0] != '#') {
      now.key = line.substr(0, equals);
      now.value = line.substr(equals + 3, line.find('#', equals) - equals - 3);
    }
    lines.push_back(now);
  }
  return lines;
}

std::string with_line(const std::string& text, std::size_t number, const std::string& replacement) {
  std::istringstream in(text);
  std::string out, line;
  for (std::size_t i = 1; std::getline(in, line); ++i) {
    if (i != number)
      out += line + "\n";
    else if (!replacement.empty())
      out += replacement + "\n";
  }
  return out;
}

struct Verdict {
  bool read = false;
  std::string message;
  std::size_t line = 0;
};

/// Reads; a scene that can be read must also run, or stop in a step that says why.
Verdict answer_to(const std::string& text) {
  Verdict answer;
  try {
    const Scene s = read_scene(text, "m.toml");
    answer.read = true;
    LcpStepper stepper;
    if (s.model.nv() > 0) static_cast<void>(simulate(s.model, stepper, s.start, {.t_end = 2e-3, .h = 1e-3}));
  } catch (const StepFailure&) {
  } catch (const std::invalid_argument& error) {
    answer.message = error.what();
    std::size_t column = 0;
    if (std::sscanf(error.what(), "m.toml:%zu:%zu: ", &answer.line, &column) != 2) answer.line = 0;
  }
  return answer;
}

/// A value whose unit is of something else than the key measures; empty for keys that take no number.
std::string wrong_unit(const std::string& key) {
  static const std::map<std::string, std::string> values = {{"mass", "\"1 m\""},
                                                            {"t_end", "\"1 kg\""},
                                                            {"mu", "\"1 s\""},
                                                            {"e", "\"1 rad\""},
                                                            {"friction", "\"1 kg\""},
                                                            {"stiffness", "\"1 kg\""},
                                                            {"damping", "\"1 N\""},
                                                            {"length", "\"1 deg\""},
                                                            {"angle", "\"1 mm\""},
                                                            {"gravity", "[0, 0, \"1 m\"]"},
                                                            {"position", "[0, 0, \"1 m/s\"]"},
                                                            {"velocity", "[0, \"1 m\", 0]"},
                                                            {"angular_velocity", "[0, 0, \"1 deg\"]"},
                                                            {"point", "[\"1 s\", 0, 0]"},
                                                            {"point_a", "[\"1 kg\", 0, 0]"},
                                                            {"axis", "[0, 0, \"1 m\"]"}};
  const auto it = values.find(key);
  return it == values.end() ? "" : it->second;
}

struct Mutant {
  std::string what, text;
  std::size_t line = 0;  ///< where it must be refused
  std::string mentions;  ///< and what of
};

/// Valid TOML with one wrong key, type, unit, reference, or one key too few.
std::vector<Mutant> wrong_scenes(const Good& good) {
  std::vector<Mutant> mutants;
  const std::vector<Line> lines = lines_of(good.text);
  for (std::size_t i = 1; i < lines.size(); ++i) {
    const auto& [key, value, in_parameters, header] = lines[i];
    if (key.empty() || in_parameters) continue;
    const auto add = [&](const char* what, const std::string& line, std::size_t where,
                         const std::string& mentions) {
      mutants.push_back(
          {good.name + ": " + what + " in '" + key + "'", with_line(good.text, i, line), where, mentions});
    };
    const bool needed =
        key == "kind" || key == "mass" || key == "a" || key == "b" || key == "gap" || key == "stiffness";
    add("wrong key", key + "_x = " + value, i, "'" + key + "_x'");
    add("wrong type", key + " = true", i, key + " is true or false");
    if (const std::string unit = wrong_unit(key); !unit.empty())
      add("wrong unit", key + " = " + unit, i, key + " has the unit '");
    if (key == "a" || key == "b")
      add("wrong reference", key + " = \"nobody\"", i, "'nobody', needs one of ground, ");
    if (key == "kind") add("wrong word", "kind = \"unheard\"", i, "'unheard', needs one of ");
    if (needed) add("missing key", "", header, "without the key '" + key + "'");
    if (key == "mass") add("wrong value", "mass = -1", i, "mass is -1");
  }
  return mutants;
}

}  // namespace

TEST_CASE("a scene file with a wrong key, type, unit or reference is refused at its line and by its key",
          "[scene_file]") {
  int tried = 0;
  for (const Good& good : good_files()) {
    REQUIRE(answer_to(good.text).message == "");
    for (const Mutant& mutant : wrong_scenes(good)) {
      const Verdict answer = answer_to(mutant.text);
      CAPTURE(mutant.what, answer.message, mutant.mentions);
      CHECK_FALSE(answer.read);
      CHECK(answer.line == mutant.line);
      CHECK(answer.message.find(mutant.mentions) != std::string::npos);
      ++tried;
    }
  }
  CHECK(tried >= 200);
}

TEST_CASE("a scene file with a few bytes changed is refused at a line that it has, or runs", "[scene_file]") {
  std::mt19937 random(7);
  const auto below = [&](std::size_t n) {
    return std::uniform_int_distribution<std::size_t>(0, n - 1)(random);
  };
  const std::string bytes = "[]{}\"'=.,#\\-+eE0 9\n\t\x01\xff\x80_abxz";
  int tried = 0, refused = 0;
  for (const Good& good : good_files()) {
    for (int k = 0; k < 30; ++k) {
      std::string text = good.text;
      switch (k % 5) {
        case 0:
          text.erase(below(text.size()), 1);
          break;
        case 1:
          text.insert(below(text.size()), 1, bytes[below(bytes.size())]);
          break;
        case 2:
          text[below(text.size())] = bytes[below(bytes.size())];
          break;
        case 3:
          text.resize(below(text.size()));
          break;
        default: {  // a piece moved somewhere else
          const std::size_t from = below(text.size()), length = 1 + below(60);
          const std::string piece = text.substr(from, length);
          text.insert(below(text.size()), piece);
        }
      }
      const Verdict answer = answer_to(text);
      CAPTURE(good.name, k, text, answer.message);
      if (!answer.read) {
        const auto count = static_cast<std::size_t>(std::count(text.begin(), text.end(), '\n'));
        CHECK(answer.line >= 1);
        CHECK(answer.message.find('\n') == std::string::npos);
        CHECK(answer.line <= count + 1);
        ++refused;
      }
      ++tried;
    }
  }
  CHECK(tried == 300);
  CHECK(refused > 100);
}
