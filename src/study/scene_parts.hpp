// What the built-in scenes are written with: parameters that are checked as they are read, and the list of the scenes.
#pragma once

#include <numbers>
#include <string>
#include <string_view>
#include <vector>

#include "perp/study/scene.hpp"
#include "study/reference_motion.hpp"

namespace perp {

inline constexpr double g = 9.81;  ///< [m/s^2] of all scenes
using std::numbers::pi;
inline const Vector3 down_y(0, -g, 0);  ///< gravity of planar scenes

/// Values that a parameter may have.
struct Allowed {
  double low = -infinity, high = infinity;
  bool open = false;  ///< without `low` itself
};
inline constexpr Allowed any{};
inline constexpr Allowed not_negative{0};
inline constexpr Allowed positive{0, infinity, true};
inline constexpr Allowed fraction{0, 1};
inline constexpr Allowed acute{0, 1.57};  ///< an angle short of a right one [rad]

/// A scene's parameters: each read names its default, its meaning and what it may be, and is remembered.
class Parameters {
 public:
  Parameters(std::string_view scene, const SceneParameters& set) : scene_(scene), set_(set) {}

  /// Throws std::invalid_argument for a value that is not allowed or not finite.
  double number(std::string_view name, double otherwise, std::string_view what, Allowed allowed = any);
  int count(std::string_view name, int otherwise, std::string_view what, int low, int high);

  /// All that were read. Throws std::invalid_argument if one was set that the scene does not have.
  std::vector<SceneParameter> all() const;

 private:
  std::string_view scene_;
  const SceneParameters& set_;
  std::vector<SceneParameter> read_;
};

/// exact() of a scene: `place(model, x, t)` puts the bodies of a model at rest where they are at t.
template <class Place>
std::function<State(double)> exact_by(const Model& model, Place place) {
  return [=](double t) {
    State x = model.rest();
    x.t = t;
    place(model, x, Real(t));
    return x;
  };
}

/// Gives a scene that is in equilibrium from the start its exact().
void stays(Scene& s);

/// A box of the ground that is open above, its floor at z = 0, its walls `half` [m] from the z axis: five half spaces.
void add_box_around(Model& model, double half, const std::string& material);

/// Where a body is and how fast, in extended precision: of a particle, and of one that stays in the xy plane.
struct ParticleMotion {
  RealVector3 x, v;
  void put(const Model& model, State& state, BodyId particle) const;
};
struct PlanarMotion {
  Real x, y, angle, vx, vy, omega;
  void put(const Model& model, State& state, BodyId body) const;
};

/// A body whose centre hangs at the distance c below a hinge at (x, y) that moves at (vx, vy).
PlanarMotion hanging(Real x, Real y, Real vx, Real vy, Real c, Real angle, Real omega);

/// Makes a scene: all but name and parameters, which the registry knows.
using SceneMaker = Scene (*)(Parameters&);

Scene seed_sphere(Parameters&);  // scenes_spheres.cpp
Scene oblique_sphere(Parameters&);
Scene turntable(Parameters&);
Scene incline_block(Parameters&);  // scenes_particles.cpp
Scene cross_incline(Parameters&);
Scene bouncing_ball(Parameters&);
Scene shaker(Parameters&);
Scene three_balls(Parameters&);
Scene roller_in_cylinder(Parameters&);  // scenes_curved.cpp
Scene ball_on_sphere(Parameters&);
Scene bead_in_ring(Parameters&);
Scene bowl(Parameters&);
Scene friction_pendulum(Parameters&);  // scenes_joints.cpp
Scene spring_block(Parameters&);
Scene double_pendulum(Parameters&);
Scene slider_crank(Parameters&);  // scenes_linkages.cpp
Scene four_bar(Parameters&);
Scene parallelogram(Parameters&);
Scene bennett(Parameters&);      // scenes_bennett.cpp
Scene dzhanibekov(Parameters&);  // scenes_rotation.cpp
Scene heavy_top(Parameters&);
Scene free_spin(Parameters&);
Scene woodpecker(Parameters&);     // scenes_woodpecker.cpp
Scene rocking_block(Parameters&);  // scenes_corners.cpp
Scene painleve_rod(Parameters&);
Scene rolling_ellipse(Parameters&);  // scenes_rolling.cpp
Scene rattleback(Parameters&);
Scene euler_disk(Parameters&);
Scene spun_sphere(Parameters&);  // scenes_moments.cpp
Scene coasting_wheel(Parameters&);
Scene tower(Parameters&);  // scenes_masonry.cpp
Scene overhang(Parameters&);
Scene arch(Parameters&);
Scene card(Parameters&);  // scenes_jamming.cpp
Scene wedge(Parameters&);
Scene peg(Parameters&);
Scene table(Parameters&);  // scenes_boxes.cpp
Scene stack(Parameters&);
Scene pile(Parameters&);
Scene sunk_box(Parameters&);
Scene creep(Parameters&);
Scene sliding_cube(Parameters&);
Scene dominoes(Parameters&);  // scenes_shapes.cpp
Scene stairs(Parameters&);
Scene card_house(Parameters&);
Scene coin(Parameters&);
Scene cone(Parameters&);
Scene tetrahedra(Parameters&);
Scene chute(Parameters&);
Scene feeder(Parameters&);  // scenes_feeding.cpp
Scene fixture(Parameters&);

}  // namespace perp
