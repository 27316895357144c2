#include "scene_texts.hpp"

#include <catch2/catch.hpp>

using namespace perp;
using Catch::Contains;
using Catch::StartsWith;

TEST_CASE("each mistake is said with its place, what was found and what is allowed", "[scene_file]") {
  CHECK_THAT(message_of(with_ball("mas = 1\n")),
             StartsWith("s.toml:6:1: the key 'mas', needs one of name, kind, mass, ") &&
                 Contains("(did you mean mass?)"));
  CHECK(message_of("[[body]]\nkind = \"spatial\"\n") ==
        "s.toml:1:1: a table without the key 'mass', needs it");
  CHECK(message_of("[[body]]\nkind = \"spatail\"\n") ==
        "s.toml:2:8: kind is 'spatail', needs one of spatial, planar, particle, prescribed (did you mean "
        "spatial?)");
  CHECK(message_of("[[body]]\nkind = \"particle\"\nmass = -1\n") ==
        "s.toml:3:8: add_particle: mass is -1, needs to be positive [kg]");
  CHECK(message_of("[[body]]\nkind = \"particle\"\nmass = \"heavy\"\n")
            .starts_with("s.toml:3:9: mass has the name 'heavy', needs one of pi, sin"));
  CHECK(message_of("[[body]]\nkind = \"particle\"\nmass = [1]\n") ==
        "s.toml:3:8: mass is a list of 1, needs a mass: a number or a text with an expression");
  CHECK(message_of("[[body]]\nkind = \"particle\"\nmass = \"1 + (2\"\n") ==
        "s.toml:3:15: mass has the end of the expression, needs ')'");
  CHECK(message_of("[[body]]\nkind = \"particle\"\nmass = \"1/0\"\n") ==
        "s.toml:3:8: mass = inf, needs to be finite");
  CHECK(message_of("[[body]]\nkind = \"particle\"\nmass = inf\n") ==
        "s.toml:3:8: inf, needs to be a finite number that double can hold");
  CHECK(message_of("[[body]]\nkind = \"particle\"\nmass = 1\nposition = [1, 2, 3, 4]\n") ==
        "s.toml:4:12: position is a list of 4, needs a list of 3 numbers, or of 2 in the xy plane");
  CHECK(message_of("gravity = 9.81\n") ==
        "s.toml:1:11: gravity is the number 9.81, needs a list of 3 numbers, or of 2 in the xy plane");
  CHECK(message_of("t_end = -1\n") == "s.toml:1:9: the time -1, needs to be positive [s]");
  CHECK(message_of(with_ball("[[body]]\nname = \"ball\"\nkind = \"particle\"\nmass = 1\n")) ==
        "s.toml:7:8: add_particle: name is ball, is taken already");
  CHECK(
      message_of(with_ball(
          "[[contact]]\na = \"ground\"\nb = \"bal\"\ngap = { kind = \"sphere_on_plane\", radius = 1 }\n")) ==
      "s.toml:8:5: b is the body 'bal', needs one of ground, ball (did you mean ball?)");
  CHECK(message_of(with_ball("[[contact]]\na = \"ground\"\nb = \"ball\"\ngap = { kind = \"sphere_on_plane\", "
                             "radius = -1 }\n")) ==
        "s.toml:9:44: sphere_on_plane: radius is -1, needs to be positive and finite [m]");
  CHECK(message_of(with_ball("[[contact]]\na = \"ground\"\nb = \"ball\"\nmu = -1\ngap = { kind = "
                             "\"sphere_on_plane\", radius = 1 }\n")) ==
        "s.toml:9:6: contact 'contact 1': mu is -1, needs to be >= 0 and finite");
  CHECK_THAT(
      message_of(with_ball("[[joint]]\nkind = \"ball\"\na = \"ground\"\nb = \"ball\"\nfriction = 1\n")),
      StartsWith("s.toml:10:12: joint 'joint 1': friction is 1, needs a joint"));
  CHECK_THAT(message_of(with_ball("[[body]]\nkind = \"prescribed\"\nmotion = { kind = \"function\", position "
                                  "= [\"step(t)\", 0, 0] }\n")),
             StartsWith("s.toml:8:42: the expression \"step(t)\" with a step"));
  CHECK_THAT(
      message_of("[parameters]\nx = 1\n" + with_ball("[[force]]\nbody = \"ball\"\nforce = [\"x\", 0, 0]\n")),
      StartsWith("s.toml:10:9: the parameter 'x', needs another name"));
  CHECK_THAT(message_of("[parameters]\nsin = 1\n"),
             StartsWith("s.toml:2:1: the parameter 'sin', needs a name"));
  CHECK_THAT(message_of("[body]\nkind = \"particle\"\n"),
             StartsWith("s.toml:1:1: body is a table, needs tables, each under the line [[body]]"));
  CHECK_THAT(message_of("mass = 1\n[[body]]\nkind = \"particle\"\nmass = 1\n"),
             StartsWith("s.toml:1:1: the key 'mass', needs one of name, what"));
}

TEST_CASE("what is not TOML is refused with its line and column", "[scene_file]") {
  CHECK_THAT(message_of("name = \n"), StartsWith("s.toml:1:"));
  CHECK_THAT(message_of("\n\nname \"a\"\n"), StartsWith("s.toml:3:"));
  CHECK_THAT(message_of("[[body]]\nkind = \"particle\"\nmass = [1, 2\n"),
             StartsWith("s.toml:4:1: missing array separator"));
  CHECK(message_of("t_end = 1\nt_end = 2\n") ==
        "s.toml:2:9: value (\"t_end\") already exists: value defined twice, needs to be TOML");
  CHECK_THAT(message_of("what = \"a"), StartsWith("s.toml:1:"));
  CHECK_THAT(message_of(std::string("what = \"a\0b\"", 12)), StartsWith("s.toml:1:10: the byte 0, "));
  CHECK_THAT(message_of("\xff\xfe"), StartsWith("s.toml:1:1: the byte 255, "));
  CHECK_THAT(message_of(std::string(100000, '[')),
             StartsWith("s.toml:1:33: tables or lists that nest deeper than 32"));
  CHECK_THAT(message_of("x = " + std::string(100000, '[')), Contains("nest deeper than 32"));
  std::string dots = "a";
  for (int i = 0; i < 100000; ++i) dots += ".a";
  CHECK_THAT(message_of(dots + " = 1"), Contains("nest deeper than 32"));
  CHECK_THAT(message_of(std::string(100'000'001, ' ')), Contains("100 MB at most"));
  CHECK_THAT(message_of("[[body]]\nkind = \"a\\nb\"\n"),
             StartsWith("s.toml:2:8: kind is 'a b', needs one of"));
  CHECK(message_of("") == "read");
}
