#include "perp/model/broad_phase.hpp"

#include <catch2/catch.hpp>
#include <random>

#include "perp/core/types.hpp"

using namespace perp;

namespace {

using Box = BroadPhase::Box;
using Pairs = std::vector<std::pair<int, int>>;

Pairs all_pairs(const std::vector<Box>& boxes) {
  Pairs pairs;
  for (int j = 0; j < static_cast<int>(boxes.size()); ++j)
    for (int i = 0; i < j; ++i)
      if (boxes[static_cast<std::size_t>(i)].intersects(boxes[static_cast<std::size_t>(j)]))
        pairs.emplace_back(i, j);
  return pairs;
}

}  // namespace

TEST_CASE("the broad phase finds the boxes that overlap and no others, whatever their sizes",
          "[broad_phase]") {
  std::mt19937 random(1);
  std::uniform_real_distribution<double> uniform(-1, 1);
  BroadPhase broad_phase;
  std::size_t found = 0;
  for (int trial = 0; trial < 60; ++trial) {
    std::vector<Box> boxes;
    const double spread = trial % 3 == 0 ? 4 : 0;  // powers of ten between sizes
    for (int i = 0; i < 5 * trial; ++i) {
      const Vector3 centre(uniform(random), trial % 2 == 0 ? 0 : uniform(random), uniform(random));
      const double size = 0.1 * std::pow(10, -spread * std::abs(uniform(random)));
      const Vector3 half = size * Vector3(1 + 0.5 * uniform(random), 1, trial % 5 == 0 ? 100 : 1);
      boxes.emplace_back(centre - half, centre + half);
      if (i % 7 == 0) boxes.push_back(boxes.back());  // the same again
    }
    const Pairs pairs = broad_phase.overlaps(boxes);
    CHECK(pairs == all_pairs(boxes));
    found += pairs.size();
  }
  CHECK(found > 10000);
}

TEST_CASE("boxes that touch overlap, and boxes in one place are all found", "[broad_phase]") {
  BroadPhase broad_phase;
  CHECK(broad_phase.overlaps({}).empty());
  const std::vector<Box> touching = {{Vector3(0, 0, 0), Vector3(1, 1, 1)},
                                     {Vector3(1, 0, 0), Vector3(2, 1, 1)}};
  CHECK(broad_phase.overlaps(touching) == Pairs{{0, 1}});
  const std::vector<Box> one_place(40, touching[0]);
  CHECK(broad_phase.overlaps(one_place).size() == 40 * 39 / 2);
}

TEST_CASE("what the broad phase looks at and keeps grows as the number of boxes", "[broad_phase]") {
  std::mt19937 random(2);
  std::uniform_real_distribution<double> uniform(0, 1);
  BroadPhase broad_phase;
  std::vector<double> per_box;
  for (const int n : {100, 1000, 10000}) {
    const double edge = std::cbrt(n);  // a box a cell
    std::vector<Box> boxes;
    for (int i = 0; i < n; ++i) {
      const Vector3 x(edge * uniform(random), edge * uniform(random), edge * uniform(random));
      boxes.emplace_back(x.array() - 0.5, x.array() + 0.5);
    }
    per_box.push_back(static_cast<double>(broad_phase.overlaps(boxes).size()) / n);
    if (n == 10000) CHECK(static_cast<double>(broad_phase.bytes()) < 300.0 * n);
  }
  CHECK(per_box[2] / per_box[0] < std::pow(100, 0.1));
}
