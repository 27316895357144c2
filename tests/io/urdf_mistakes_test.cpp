// What of a robot's file is said not to be used, and what is refused.
#ifdef PERP_HAS_URDFDOM

#include <catch2/catch.hpp>
#include <fstream>
#include <iterator>
#include <random>

#include "robots.hpp"

using namespace perp;
using Catch::Contains;
using Catch::StartsWith;

namespace {

std::string contents(const std::filesystem::path& path) {
  std::ifstream in(path, std::ios::binary);
  REQUIRE(in);
  return {std::istreambuf_iterator<char>(in), {}};
}

}  // namespace

TEST_CASE("what of a file does not enter is listed with its line", "[urdf]") {
  const std::string text =
      "<robot name=\"r\" kind=\"walker\">\n<material name=\"blue\"><color rgba=\"0 0 1 1\"/></material>\n" +
      xml_link("base", "<visual name=\"shell\"><geometry><sphere radius=\"1\"/></geometry></visual>\n" +
                           inertial(1, 0.1, 0.1, 0.1) +
                           "\n<collision><geometry><mesh filename=\"foot.stl\"/></geometry></collision>") +
      "\n" + xml_link("l", inertial(1, 0.1, 0.1, 0.1)) + xml_link("k", inertial(1, 0.1, 0.1, 0.1)) + "\n" +
      xml_joint("j", "continuous", "base", "l",
                "<limit effort=\"3\" velocity=\"4\"/>\n<calibration rising=\"0\"/><safety_controller "
                "k_velocity=\"1\"/>") +
      "\n" + xml_joint("f", "floating", "l", "k", "<dynamics damping=\"1\"/>") +
      "\n<gazebo reference=\"l\"/>\n<transmission name=\"t\"/>\n</robot>";
  const std::vector<std::string> expected{
      "r.urdf:1: kind in <robot>",
      "r.urdf:2: <material> 'blue'",
      "r.urdf:3: <visual> 'shell' of link 'base'",
      "r.urdf:3: mesh 'foot.stl' of link 'base': foot.stl: No such file or directory, needs a mesh file",
      "r.urdf:3: body 'base' in contacts: it is left without any shape, and meets nothing",
      "r.urdf:7: effort in <limit> of joint 'j'",
      "r.urdf:7: velocity in <limit> of joint 'j'",
      "r.urdf:8: <calibration> of joint 'j'",
      "r.urdf:8: <safety_controller> of joint 'j'",
      "r.urdf:9: <dynamics> of joint 'f', floating",
      "r.urdf:10: <gazebo>",
      "r.urdf:11: <transmission> 't'",
  };
  CHECK(read_urdf(text, "r.urdf").unused == expected);
}

TEST_CASE("what is not a robot is refused with the file and the line", "[urdf]") {
  const std::string heavy = inertial(1, 0.1, 0.1, 0.1);
  struct Bad {
    std::string text, message;
  };
  const std::vector<Bad> bad{
      {"", "r.urdf:1:1: "},
      {"<robot name=\"r\">\n<link name=\"l\">\n</robot>", "r.urdf:"},
      {"<sdf/>", "r.urdf:1:1: the element <sdf>, a URDF file needs to be one <robot>"},
      {robot(""), "r.urdf:1:1: 'No link elements found in urdf file'"},
      {robot(xml_link("l") + "\n" + xml_link("l")), "r.urdf:2:1: 'link 'l' is not unique.'"},
      {robot(xml_link("l") + "\n" + xml_link("k") + "\n" + xml_joint("j", "revolute", "l", "k")),
       "r.urdf:4:1: 'Joint [j] is of type REVOLUTE"},
      {robot(xml_link("l") + "\n" + xml_link("k") + "\n" + xml_joint("j", "hinge", "l", "k")),
       "r.urdf:4:1: 'Joint [j] has no known type [hinge]"},
      {robot(xml_link("l") + "\n" + xml_joint("j", "fixed", "l", "k")), "r.urdf:3:1: "},
      {robot(xml_link("l") + xml_link("k")), "r.urdf:"},
      {robot(xml_link("l") + xml_link("k") + xml_link("m") + xml_joint("j", "fixed", "l", "m") + "\n" +
             xml_joint("i", "fixed", "k", "m")),
       "r.urdf:"},
      {robot(xml_link("l") + "\n" + xml_link("a") + xml_link("b") + xml_joint("j", "fixed", "a", "b") +
             xml_joint("i", "fixed", "b", "a")),
       "r.urdf:3:1: link 'a' in a loop of joints"},
      {robot(xml_link("l", inertial(-1, 0.1, 0.1, 0.1))), "r.urdf:2:1: the mass -1 of link 'l'"},
      {robot("\n" + xml_link("l", inertial(1, 1, 0.1, 0.1))), "r.urdf:3:1: link 'l': "},
      {robot(held("revolute", heavy, "\n<axis xyz=\"0 0 0\"/>" + stops_far)),
       "r.urdf:2:1: joint 'j': joint: axis is 0"},
      {robot(held("revolute", heavy, "<limit lower=\"2\" upper=\"1\" effort=\"1\" velocity=\"1\"/>")),
       "r.urdf:2:1: joint 'j': add_limit"},
      {robot(held("revolute", heavy, "<dynamics friction=\"-1\"/>" + stops_far)), "r.urdf:2:1: joint 'j': "},
      {robot(xml_link("l", heavy + "<collision><geometry><sphere radius=\"-1\"/></geometry></collision>")),
       "r.urdf:2:1: collision shape 'l': Shape::sphere: radius is -1"},
      {robot(xml_link("l", "<inertial><mass value=\"heavy\"/></inertial>")), "r.urdf:2:1: "},
  };
  for (const Bad& b : bad) {
    CAPTURE(b.text);
    try {
      (void)read_urdf(b.text, "r.urdf");
      FAIL("was read");
    } catch (const std::invalid_argument& error) {
      CHECK_THAT(error.what(), StartsWith(b.message));
    }
  }
  std::string deep;
  for (int i = 0; i < 100000; ++i) deep += "<link>";
  CHECK_THROWS_WITH(read_urdf(deep, "r.urdf"), Contains("nest deeper than 100"));
  CHECK_THROWS_WITH(read(xml_link("l", heavy), {{"m", 1}}),
                    Contains("parameter is m, needs to be one of base.fixed"));
  CHECK_THROWS_WITH(read(xml_link("l", heavy), {{"floor", 2}}), Contains("floor is 2, needs to be 0 or 1"));
}

TEST_CASE("a robot's file with bytes changed is read or refused", "[urdf]") {
  const std::string good = contents(robots / "arm.urdf");
  std::mt19937 random(7);
  int refused = 0;
  constexpr int tries = 400;
  for (int i = 0; i < tries; ++i) {
    std::string text = good;
    const std::size_t at = random() % text.size();
    const char letters[] = "<>/\"=-x0 \n\x80";
    switch (random() % 4) {
      case 0:
        text[at] = letters[random() % (sizeof letters - 1)];
        break;
      case 1:
        text.erase(at, 1 + random() % 40);
        break;
      case 2:
        text.insert(at, text.substr(random() % text.size(), random() % 200));
        break;
      default:
        text.resize(at);
    }
    try {
      const Scene s = read_urdf(text, "r.urdf");
      s.model.check("start", s.start);
    } catch (const std::invalid_argument& error) {
      REQUIRE_THAT(error.what(), StartsWith("r.urdf"));
      ++refused;
    }
  }
  CHECK(refused > tries / 4);
  CHECK(refused < tries);
}

#endif
