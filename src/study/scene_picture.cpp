#include "study/scene_picture.hpp"

#include "study/woodpecker_sizes.hpp"

namespace perp {
namespace {

Pose shifted(double x, double y) { return {.p = {x, y, 0}}; }
Pose turned_about_z(const Vector3& p, double angle) {
  return {p, Quaternion(Eigen::AngleAxisd(angle, Vector3::UnitZ()))};
}

/// The pole along y, the sleeve's two sides, and on the spring's end the bird. Sleeve and beak meet the pole where the gaps close, to second
/// order in the angles; the bird's outline is free.
std::vector<ScenePart> woodpecker_picture(const Scene& scene) {
  const auto [r_0, r_M, h_M, l_M, l_G, h_S, l_S] = WoodpeckerSizes();
  const BodyId bird = scene.model.find_body("woodpecker");
  const double side = 0.0008;
  const Vector2 beak(l_G - l_S, h_S);
  const auto on_sleeve = [](const Vector& q) { return turned_about_z({0, q[0], 0}, q[1]); };
  const auto on_spring = [l = l_M, on_sleeve](const Vector& q) {
    return turned_about_z(on_sleeve(q) * Vector3(l, 0, 0), q[2]);
  };
  return {
      {.body = ground, .name = "pole", .shapes = {Shape::box(2 * r_0, 4)}, .poses = {shifted(0, -1.9)}},
      {.body = bird,
       .name = "sleeve",
       .shapes = {Shape::box(side, 2 * h_M), Shape::box(side, 2 * h_M), Shape::box(l_M - r_M, 0.5 * side)},
       .poses = {shifted(-r_M - side / 2, 0), shifted(r_M + side / 2, 0), shifted((l_M + r_M) / 2, 0)},
       .pose = on_sleeve},
      {.body = bird,
       .name = "bird",
       .shapes = {Shape::ellipse(0.006, 0.012), Shape::planar_disc(0.005),
                  Shape::polygon({beak, beak + Vector2(0.009, -0.0015), beak + Vector2(0.009, 0.0025)}),
                  Shape::polygon({{0, 0}, {0.01, -0.003}, {0.01, 0.003}})},
       .poses = {shifted(l_G, 0), shifted(0.0085, 0.019), {}, {}},
       .pose = on_spring}};
}

/// The whole peg, and the hole's other wall, whose upper edge is the mouth's at the origin.
std::vector<ScenePart> peg_picture(const Scene& scene) {
  const double width = 0.1, length = 0.2;  // those of the peg's inertia
  return {{.body = scene.model.find_body("peg"),
           .name = "peg",
           .shapes = {Shape::box(width, length)},
           .poses = {{}}},
          {.body = ground,
           .name = "mouth",
           .shapes = {Shape::box(width, length)},
           .poses = {shifted(-width / 2, -length / 2)}}};
}

}  // namespace

std::vector<ScenePart> picture_of(const Scene& scene) {
  if (scene.name == "woodpecker") return woodpecker_picture(scene);
  if (scene.name == "peg") return peg_picture(scene);
  return {};
}

}  // namespace perp
