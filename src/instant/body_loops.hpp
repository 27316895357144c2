// Whether contacts and joints close loops of bodies: only then can their reactions be redundant.
#pragma once

#include <vector>

#include "perp/instant/islands.hpp"

namespace perp {

/// Bodies tied one by one, an edge each contact point and each joint; what no force moves counts as one body. Along a tree of edges
/// rows are independent: those of a last edge are so on its last body alone.
class BodyLoops {
 public:
  void begin(const Model& model);
  /// Ties a and b; true if that closes a loop, or if rows on one of them may repeat each other by themselves.
  bool close(const Model& model, int a, int b);

  /// Whether the island's contacts and joints close a loop.
  bool in(const Model& model, const Instant& instant, const Island& island);

 private:
  int root(int body);

  std::vector<int> parent_;   // of a body; of one not tied yet itself
  std::vector<int> touched_;  // the others
};

}  // namespace perp
