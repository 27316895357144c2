// Which contacts are worth a look: lower bounds of gaps, kept from step to step.
#pragma once

#include <utility>
#include <vector>

#include "perp/model/shapes_in_reach.hpp"

namespace perp {

/// A gap of known levers (Gap::levers) shrinks by no more than its bodies move: between two configurations by at most
///   |dp_A| + |dp_B| + lever_a angle_A + lever_b angle_B.
/// A contact seen at the gap g is therefore not nearer than `margin` until the bodies have travelled g - margin; a heap, ordered by that
/// mark, gives up the ones that are due. Pairs of shapes are found by the broad phase. Purely of configurations: any sequence of them is
/// answered rightly.
class NearContacts {
 public:
  static constexpr std::size_t worth_it = 64;  ///< contacts of a model that may touch; fewer are all near

  /// The longest lever of the model's contacts that have one [m].
  double lever(const Model& model);

  /// Contacts of which a point may have a gap of `margin` at most at the poses X and time t; ascending. All those without levers are among
  /// them. Of fewer than worth_it all are.
  const std::vector<int>& find(const Model& model, const std::vector<Pose>& X, double t, double margin);

  /// Whether the last find() left any out; then what it did not return is further than its margin.
  bool selective() const { return selective_; }
  /// How far a gap may have shrunk between the poses of the last find() and Y.
  double travel_to(const Model& model, const std::vector<Pose>& Y) const;

 private:
  void reset(const Model& model);

  std::uint64_t revision_ = 0;
  bool selective_ = false;
  double lever_ = 0;                             // largest of the model
  double travelled_ = 0;                         // bound on what gaps have shrunk since reset
  std::vector<Pose> X_;                          // of the last find
  std::vector<int> always_;                      // contacts without levers
  std::vector<std::pair<double, int>> waiting_;  // heap: (travelled_ at which to look again, contact)
  std::vector<int> watched_, near_;              // out of the heap; the answer
  std::vector<ContactPoint> points_;
  ShapesInReach shapes_;
};

}  // namespace perp
