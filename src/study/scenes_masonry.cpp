// Blocks that hold each other up: a tower, an overhang, an arch.
#include <cmath>

#include "perp/model/gaps.hpp"
#include "study/scene_parts.hpp"

namespace perp {

Scene tower(Parameters& set) {
  const double mu = set.number("mu", 0.5, "friction coefficient [-]", not_negative);
  const int layers = set.count("count", 100, "layers [-]", 1, 1000);
  const int planks = set.count("planks", 1, "of each layer, laid across the layer below [-]", 1, 10);
  const double pitch = 1.0 / planks;
  const Vector3 size(1, planks > 1 ? 0.9 * pitch : 1, 0.2);  // planks of a layer do not touch
  const Quaternion across(Eigen::AngleAxisd(pi / 2, Vector3::UnitZ()));
  Scene s;
  s.id = "C6";
  s.what = "A tower of blocks, or of layers of planks laid crosswise, stands";
  std::vector<BodyId> below, above;
  for (int layer = 0; layer < layers; ++layer) {
    above.clear();
    for (int i = 0; i < planks; ++i) {
      const Quaternion turn = layer % 2 == 1 && planks > 1 ? across : Quaternion::Identity();
      const Vector3 place = turn * Vector3(0, pitch * (i - 0.5 * (planks - 1)), size.z() * (layer + 0.5));
      std::string name = "block-" + std::to_string(layer + 1);
      if (planks > 1) name += "-" + std::to_string(i + 1);
      above.push_back(
          s.model.add_body(Inertia::solid_box(pitch, size), {.pose = {.p = place, .q = turn}, .name = name}));
      if (layer == 0)
        s.model.add_contact(ground, above.back(), box_on_plane(size), {.mu = mu, .name = name + "-floor"});
      for (std::size_t j = 0; j < below.size(); ++j)
        s.model.add_contact(below[j], above.back(), box_on_box(size, size),
                            {.mu = mu, .name = name + "-on-" + std::to_string(j + 1)});
    }
    below = above;
  }
  s.start = s.model.rest();
  stays(s);
  return s;
}

Scene overhang(Parameters& set) {
  const double mu = set.number("mu", 0.5, "friction coefficient [-]", not_negative);
  const double scale = set.number("scale", 0.999, "overhangs over the largest that stand [-]", {0, 1.5});
  const int count = set.count("count", 10, "blocks above the fixed one [-]", 1, 100);
  // depths alternate, so that no two edges lie on each other
  const auto size = [](int i) { return Vector3(1, i % 2 == 0 ? 1 : 0.9, 0.2); };
  Scene s;
  s.id = "C6";
  s.what = "Blocks lie on a fixed one, each pushed out over the one below, the last of ten by 1.46 lengths";
  s.t_end = 5;
  BodyId below = ground;
  double x = 0;
  for (int i = 0; i < count; ++i) {
    x += scale / (2 * (count - i));  // the centre of mass of all from here on up comes to the edge
    const BodyId block =
        s.model.add_body(Inertia::solid_box(1, size(i + 1)),
                         {.pose = {.p = {x, 0, 0.2 * (i + 1)}}, .name = "block-" + std::to_string(i + 1)});
    s.model.add_contact(below, block, box_on_box(size(i), size(i + 1)),
                        {.mu = mu, .name = "joint-" + std::to_string(i + 1)});
    below = block;
  }
  s.start = s.model.rest();
  if (scale <= 1) stays(s);
  return s;
}

Scene arch(Parameters& set) {
  const double mu = set.number("mu", 100, "friction coefficient [-]", not_negative);
  const double thickness =
      set.number("thickness", 0.112, "over the radius of the middle line [-]", {0.01, 1});
  const int count = set.count("count", 60, "voussoirs [-]", 2, 400);
  const double R = 1, inner = R - thickness / 2, outer = R + thickness / 2, part = pi / count;
  // of a sector of a ring: area (outer² - inner²)/2 part, centroid at its middle angle
  const double squares = outer * outer - inner * inner, cubes = std::pow(outer, 3) - std::pow(inner, 3);
  const double centroid = 2 * cubes / (3 * squares) * std::sin(part / 2) / (part / 2);
  const double mass = squares / 2 * part;
  const double J = mass * ((outer * outer + inner * inner) / 2 - centroid * centroid);
  Scene s;
  s.id = "C8";
  s.what = "A semicircular arch of voussoirs stands if its thickness is .1075 of its radius or more [Mil07]";
  s.t_end = 2;
  s.model.set_gravity(down_y);
  const auto along = [](double angle) { return Vector3(std::cos(angle), std::sin(angle), 0); };
  const auto across = [](double angle) { return Vector3(-std::sin(angle), std::cos(angle), 0); };
  // voussoir i from the angle i part on; its axes are the world's, its origin its centroid
  const auto middle = [=](int i) { return Vector3(centroid * along((i + 0.5) * part)); };
  BodyId before = ground;
  for (int i = 0; i <= count; ++i) {
    const BodyId next =
        i < count ? s.model.add_planar_body(
                        mass, J, {.pose = {.p = middle(i)}, .name = "voussoir-" + std::to_string(i + 1)})
                  : ground;
    // joint i at the angle i part; at the end it is the arch that stands on the ground again
    const double angle = i * part;
    const BodyId a = i < count ? before : ground, b = i < count ? next : before;
    const Vector3 normal = i < count ? across(angle) : Vector3(-across(angle));
    const Vector3 origin_a = a == ground ? Vector3::Zero() : middle(i - 1);
    const Vector3 origin_b = middle(i < count ? i : i - 1);
    for (const bool outside : {false, true}) {
      const Vector3 corner = (outside ? outer : inner) * along(angle);
      s.model.add_contact(a, b, point_on_plane(corner - origin_b, {normal, corner - origin_a}),
                          {.mu = mu, .name = "joint-" + std::to_string(i) + (outside ? "-outer" : "-inner")});
    }
    before = next;
  }
  s.start = s.model.rest();
  if (thickness >= 0.1075 && mu >= 1) stays(s);
  return s;
}

}  // namespace perp
