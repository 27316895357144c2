// Scenes drawn at random from a seed, as scene files would say them: bodies of all kinds, today's gaps, joints of all kinds with
// loops, stops, motors, springs and dry friction, prescribed bodies. Lengths 1e-4 to 1e3 m, masses 1e-6 to 1e6 kg, mu 0 to 3, e 0 to 1.
#pragma once

#include <cstdint>

#include "scene.hpp"

namespace checker {

struct RandomScene {
  Scene scene;
  double h = 0;   // [s]
  int steps = 0;  // of a method of fixed steps; the others run as long
  double until() const { return h * steps; }
};

[[nodiscard]] RandomScene random_scene(std::uint64_t seed);

/// The same numbers everywhere, whatever the standard library.
class Random {
 public:
  explicit Random(std::uint64_t seed) : state_(seed * 0x9e3779b97f4a7c15ULL + 1) {}
  std::uint64_t next();
  double uniform(double from = 0, double to = 1);
  double decades(double from, double to);  // 10^uniform
  bool chance(double share) { return uniform() < share; }
  int below(int n) { return static_cast<int>(uniform() * n); }
  Vector3d direction();
  Quaterniond turn();
  template <class T>
  const T& one_of(const std::vector<T>& all) {
    return all[static_cast<std::size_t>(below(static_cast<int>(all.size())))];
  }

 private:
  std::uint64_t state_;
};

}  // namespace checker
