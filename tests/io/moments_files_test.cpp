// Torsion, rolling and friction axes in scene files, and their moments in a run's files.
#include <catch2/catch.hpp>
#include <filesystem>
#include <fstream>

#include "perp/io/run_files.hpp"
#include "perp/step/ncp_stepper.hpp"
#include "perp/step/simulate.hpp"
#include "scene_texts.hpp"

using namespace perp;
using Catch::Contains;

namespace {

std::string contact(const std::string& keys) {
  return with_ball("position = [0, 0, 0.1]\nangular_velocity = [0, 0, 30]\n") +
         "[[contact]]\na = \"ground\"\nb = \"ball\"\nname = \"floor\"\n"
         "gap = { kind = \"sphere_on_plane\", radius = 0.1 }\n" +
         keys;
}

}  // namespace

TEST_CASE("torsion, rolling and friction axes are read from a scene file and printed to the same bytes",
          "[scene_file][moments]") {
  const Scene s = read_scene(contact("mu = 0.3\ntorsion = \"2 cm\"\nrolling = 0.001\n"), "s.toml");
  CHECK(s.model.contacts()[0].torsion == 0.02);
  CHECK(s.model.contacts()[0].rolling == 0.001);
  const Scene axes = read_scene(
      contact("friction_axes = { mu = [0.2, 0.6], axes_of = \"b\", t = [0, 1, 0.3] }\n"), "s.toml");
  REQUIRE(axes.model.contacts()[0].friction_axes);
  CHECK(axes.model.contacts()[0].mu == 0.2);
  CHECK(axes.model.contacts()[0].friction_axes->mu.y() == 0.6);
  CHECK(axes.model.contacts()[0].friction_axes->of == FrictionAxes::Of::B);
  CHECK(axes.model.contacts()[0].friction_axes->t == Vector3(0, 1, 0.3));
  for (const Scene* scene : {&s, &axes}) {
    const std::string text = write_scene(*scene);
    CHECK(write_scene(read_scene(text, "t.toml")) == text);
  }
  CHECK_THAT(message_of(contact("torsion = -1\n")), Contains("s.toml:13:11") && Contains("torsion is -1"));
  CHECK_THAT(message_of(contact("rolling = \"1 kg\"\n")), Contains("rolling has the unit 'kg'"));
  CHECK_THAT(message_of(contact("mu = 0.1\nfriction_axes = { mu = [1, 2] }\n")), Contains("mu is 0.1"));
  CHECK_THAT(message_of(contact("friction_axes = { mu = [1, 2], of = \"a\" }\n")), Contains("of"));
}

TEST_CASE("a pair of materials gives its contacts torsion and rolling", "[scene_file][moments]") {
  const std::string text =
      with_ball("position = [0, 0, 0.1]\n") +
      "[[shape]]\nbody = \"ball\"\nkind = \"sphere\"\nradius = 0.1\nmaterial = \"rubber\"\n"
      "[[shape]]\nbody = \"ground\"\nkind = \"half_space\"\nmaterial = \"floor\"\n"
      "[[material_pair]]\na = \"floor\"\nb = \"rubber\"\nmu = 0.5\ntorsion = 0.01\nrolling = 0.002\n";
  const Scene s = read_scene(text, "s.toml");
  REQUIRE(s.model.contact_count() == 1);
  CHECK(s.model.contact(0).law.torsion == 0.01);
  CHECK(s.model.contact(0).law.rolling == 0.002);
}

TEST_CASE("contacts.csv has the moments' impulse on b where contacts have moments, and not where none has",
          "[run_files][moments]") {
  const auto folder = std::filesystem::temp_directory_path() / "perp-moments-files";
  const auto first_rows = [&](const std::string& keys) {
    std::filesystem::remove_all(folder);
    const Scene s = read_scene(contact(keys), "s.toml");
    NcpStepper ncp;
    write_run(folder, s.model, simulate(s.model, ncp, s.start, {.t_end = 0.02, .h = 0.01}));
    std::ifstream in(folder / "contacts.csv");
    std::vector<std::string> rows(2);
    for (std::string& row : rows) std::getline(in, row);
    std::filesystem::remove_all(folder);
    return rows;
  };
  const std::string plain = "t,contact,a,b,gap,nx,ny,nz,pn,px,py,pz,fx,fy,fz,mode";
  const auto with = first_rows("mu = 0.3\ntorsion = 0.02\n"), without = first_rows("mu = 0.3\n");
  CHECK(without[0] == plain);
  CHECK(with[0] == plain + ",tx,ty,tz");
  const std::string tz = with[1].substr(with[1].rfind(',') + 1);
  CHECK(std::stod(tz) == Approx(-0.02 * 9.81 * 0.01).epsilon(1e-9));
}
