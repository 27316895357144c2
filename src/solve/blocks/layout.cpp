#include "solve/blocks/layout.hpp"

#include <algorithm>

namespace perp {
namespace {

// in the order of BlockKind
constexpr std::array<BlockLayout, 10> layouts{{
    {1, true, {0}},                 // HalfLine
    {2, true, {0, 1}},              // Planar
    {3, true, {0, 1, 2}},           // Cone
    {1, false, {1}},                // Interval
    {3, true, {0, 1, 4}},           // PlanarRolling
    {4, true, {0, 1, 2, 3}},        // Torsional
    {5, true, {0, 1, 2, 4, 5}},     // Rolling
    {6, true, {0, 1, 2, 3, 4, 5}},  // TorsionalRolling
    {2, false, {1, 2}},             // Disc
    {3, false, {1, 2, 3}},          // Ball
}};

}  // namespace

const BlockLayout& layout_of(BlockKind kind) { return layouts[static_cast<size_t>(kind)]; }

int column_rows(const FrictionProblem& problem) {
  for (Eigen::Index i = 0; i < problem.blocks(); ++i) {
    const BlockLayout& layout = layout_of(problem.kind(i));
    if (layout.place[static_cast<size_t>(layout.rows) - 1] >= 3) return 6;
  }
  return 3;
}

double semi_axis(const FrictionProblem& problem, Eigen::Index i, int place) {
  if (!layout_of(problem.kind(i)).contact || place == 1) return problem.mu(i);
  if (place == 2) return problem.mu_o.size() > 0 ? problem.mu_o(i) : problem.mu(i);
  return place == 3 ? problem.torsion(i) : problem.rolling(i);
}

int block_rows(BlockKind kind) { return layout_of(kind).rows; }

}  // namespace perp
