#include "perp/model/point_names.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <limits>

#include "core/index.hpp"
#include "model/pairs/shape_geometry.hpp"
#include "perp/core/errors.hpp"

namespace perp {
void PairNumbers::add(int most_points) {
  const long long all = points_ + static_cast<long long>(most_points) * shapes();
  constexpr int most_shapes = 65000;  // whose pairs an int counts
  if (all > std::numeric_limits<int>::max() / 2 || shapes() >= most_shapes)
    refuse("add_shape", "shape", std::to_string(shapes() + 1) + " shapes",
           "pairs of them have more contact points than can be numbered");
  row_.push_back({points_, most_points});
  points_ = static_cast<int>(all);
}

PairNumbers::Pair PairNumbers::pair(int number) {
  int j = static_cast<int>((1 + std::sqrt(1 + 8.0 * number)) / 2);
  while (pair(0, j) > number) --j;
  while (pair(0, j + 1) <= number) ++j;
  return {number - pair(0, j), j};
}

PairNumbers::Pair PairNumbers::pair_of_point(int point) const {
  const auto after =
      std::upper_bound(row_.begin(), row_.end(), point, [](int p, const Row& row) { return p < row.first; });
  const auto row = after - 1;  // the last that begins there: those of no points are passed by
  return {(point - row->first) / row->each, static_cast<int>(row - row_.begin())};
}

std::string PointNames::pair_name(const PairNumbers::Pair& pair) const {
  const NamedShape &a = shapes_[at(pair.i)], &b = shapes_[at(pair.j)];
  return b.body < a.body ? b.name + "|" + a.name : a.name + "|" + b.name;
}

int PointNames::points_of(const PairNumbers::Pair& pair) const {
  const ShapePair shapes(*shapes_[at(pair.i)].geometry, *shapes_[at(pair.j)].geometry);
  return shapes.known() ? shapes.points() : 0;
}

std::string PointNames::operator[](std::size_t point) const {
  if (point < listed_.size()) return listed_[point];
  const int found = static_cast<int>(point - listed_.size());
  const PairNumbers::Pair pair = pairs_.pair_of_point(found);
  const std::string name = pair_name(pair);
  return points_of(pair) == 1 ? name : name + "|" + std::to_string(found - pairs_.first_point(pair));
}

int PointNames::find(std::string_view name) const {
  const auto listed = std::find(listed_.begin(), listed_.end(), name);
  if (listed != listed_.end()) return static_cast<int>(listed - listed_.begin());
  const std::size_t first = name.find('|');
  if (first == std::string_view::npos) return -1;
  const std::size_t second = name.find('|', first + 1);
  const auto shape = [&](std::string_view wanted) {
    const auto it =
        std::find_if(shapes_.begin(), shapes_.end(), [&](const NamedShape& s) { return s.name == wanted; });
    return it == shapes_.end() ? -1 : static_cast<int>(it - shapes_.begin());
  };
  const int a = shape(name.substr(0, first)), b = shape(name.substr(first + 1, second - first - 1));
  if (a < 0 || b < 0 || a == b) return -1;
  const PairNumbers::Pair pair{std::min(a, b), std::max(a, b)};
  int slot = 0;
  if (second != std::string_view::npos)
    std::from_chars(name.data() + second + 1, name.data() + name.size(), slot);
  if (slot < 0 || slot >= points_of(pair)) return -1;
  const std::size_t point = listed_.size() + at(pairs_.first_point(pair) + slot);
  return (*this)[point] == name ? static_cast<int>(point) : -1;
}

std::string PointNames::known() const {
  std::string all;
  for (const std::string& name : listed_) all += (all.empty() ? "" : ", ") + name;
  if (shapes_.size() < 2) return all;
  return all + (all.empty() ? "" : ", ") + "or of two shapes, as " + pair_name({0, 1}) + "|0";
}

}  // namespace perp
