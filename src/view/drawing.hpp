// A run made ready to be drawn, by a page or as glTF: every body with its solids and motion, prescribed bodies and the ground too.
#pragma once

#include <string>
#include <vector>

#include "perp/view/recorded_run.hpp"
#include "perp/view/solids.hpp"

namespace perp {

struct DrawnBody {
  std::string name;
  std::string kind;  ///< spatial, planar, particle, prescribed, ground
  int colour = 0;    ///< number in the palette
  std::vector<Solid> solids;
  std::vector<double> t;  ///< of `moments`; one moment stands still
  std::vector<Moment> moments;
};

struct DrawnJoint {
  std::string name;
  int body = 0;                      ///< in Drawing::bodies
  Vector3 anchor = Vector3::Zero();  ///< in the body's axes
  Vector3 axis = Vector3::Zero();    ///< likewise; zero: it has none
};

struct Drawing {
  std::vector<DrawnBody> bodies;
  std::vector<DrawnJoint> joints;
  bool flat = false;                 ///< all that moves, moves in the xy plane
  Vector3 up = Vector3::UnitZ();     ///< against gravity
  Vector3 centre = Vector3::Zero();  ///< of what moves
  double radius = 1;                 ///< of a ball about `centre` that holds it, and its solids
  Vector3 low = Vector3::Constant(-1), high = Vector3::Constant(1);  ///< the box of the same
  std::vector<std::string> unseen;  ///< bodies that have no pose: generalized ones
  /// Where the contact points of RecordedRun::contacts are, likewise; empty without a scene.
  std::vector<std::vector<Vector3>> contact_points;
};

[[nodiscard]] Drawing drawing_of(const RecordedRun& run);

}  // namespace perp
