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

/// Makes a scene: all but name and parameters, which the registry knows.
using SceneMaker = Scene (*)(Parameters&);

// scenes_spheres.cpp
Scene seed_sphere(Parameters&);
Scene oblique_sphere(Parameters&);
Scene turntable(Parameters&);
// scenes_particles.cpp
Scene incline_block(Parameters&);
Scene cross_incline(Parameters&);
Scene shaker(Parameters&);
Scene bead_in_ring(Parameters&);
// scenes_planar.cpp
Scene roller_in_cylinder(Parameters&);
Scene friction_pendulum(Parameters&);
Scene spring_block(Parameters&);
Scene double_pendulum(Parameters&);
// scenes_rotation.cpp
Scene dzhanibekov(Parameters&);
// scenes_boxes.cpp
Scene stack(Parameters&);
Scene creep(Parameters&);

}  // namespace perp
