// Which of many boxes overlap.
#pragma once

#include <Eigen/Geometry>
#include <span>
#include <utility>
#include <vector>

namespace perp {

/// All pairs of boxes along the axes that have a point in common, without looking at all pairs: a tree, halved at the median of the boxes'
/// centres along their longest spread, is crossed with itself. Boxes of all sizes may be among each other. O(n log n) for boxes of which
/// each overlaps a few; 170 bytes a box.
class BroadPhase {
 public:
  using Box = Eigen::AlignedBox3d;

  /// Pairs (i, j) of numbers of boxes, i < j, in ascending order of j, then i; good until the next call.
  const std::vector<std::pair<int, int>>& overlaps(std::span<const Box> boxes);

  std::size_t bytes() const;  ///< of the tree and of the pairs found last

 private:
  static constexpr int few = 4;  // boxes that are not parted further
  struct Node {
    Box box;
    int first, last;  // in order_
    int right;        // second child; the first is the next node; 0: none
  };

  int build(std::span<const Box> boxes, int first, int last);
  void within(std::span<const Box> boxes, int node);
  void across(std::span<const Box> boxes, int a, int b);
  void take(std::span<const Box> boxes, int i, int j);

  std::vector<int> order_;
  std::vector<Node> nodes_;
  std::vector<std::pair<int, int>> pairs_;
};

}  // namespace perp
