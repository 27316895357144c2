// Spheres that lie in a box: where the families pile and chute begin.
#pragma once

#include <vector>

#include "contact_assembly.hpp"

namespace perp {

struct SpherePacking {
  Vector3 box = Vector3::Zero();  ///< walls x = 0, box.x; y = 0, box.y; floor z = 0; open above [m]
  std::vector<Vector3> centre;    ///< lowest first
  std::vector<double> radius;
};

/// `count` spheres let down into an open box, about as high as it is wide, until they lie: radii in [1/ratio, 1] times `largest`, as much volume of
/// each size. Displacements alone, no dynamics: all sink a little, overlaps are taken away, the lighter gives way, again
/// and again, sinking less and less. Spheres end up to some hundredths of a radius in each other, the deeper the more.
[[nodiscard]] SpherePacking pack_spheres(Random& random, int count, double largest, double ratio);

}  // namespace perp
