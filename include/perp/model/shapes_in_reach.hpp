// Which of a model's shapes may meet.
#pragma once

#include <vector>

#include "perp/model/broad_phase.hpp"
#include "perp/model/model.hpp"

namespace perp {

/// Contacts of two shapes (by their numbers, Model::contact) of which a point may have a gap of `margin` at most: boxes about the shapes,
/// grown by half of that, meet by the broad phase; shapes that have no end are held against every other.
class ShapesInReach {
 public:
  /// At the bodies' poses X; ascending, and good until the next call. None that may be that near is left out.
  const std::vector<int>& find(const Model& model, const std::vector<Pose>& X, double margin);

  std::size_t bytes() const;  ///< that it keeps

 private:
  BroadPhase broad_phase_;
  std::vector<BroadPhase::Box> boxes_;
  std::vector<int> shape_of_box_, endless_;
  std::vector<int> found_;
};

}  // namespace perp
