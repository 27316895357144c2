// Values for a few of a model's contact points, of which there may be very many.
#pragma once

#include <cstddef>
#include <unordered_map>
#include <vector>

namespace perp {

/// A value for every contact point of a model, the same for all but those that were set. Of up to `few` points it is an array; beyond, as
/// where every pair of ten thousand shapes has a number, only what was set is kept.
template <class T>
class PointTable {
 public:
  static constexpr int few = 1 << 14;

  explicit PointTable(T otherwise = T()) : otherwise_(std::move(otherwise)) {}

  /// Of `points` points, none of them set.
  void reset(int points) {
    if (points != points_) {
      points_ = points;
      dense_.assign(points <= few ? static_cast<std::size_t>(points) : 0, otherwise_);
    } else if (!dense_.empty()) {
      for (const int p : set_) dense_[static_cast<std::size_t>(p)] = otherwise_;
    }
    sparse_.clear();
    set_.clear();
  }

  bool empty() const { return points_ == 0; }
  int size() const { return points_; }
  const std::vector<int>& points_set() const { return set_; }

  const T& operator[](std::size_t point) const {
    if (points_ <= few) return dense_[point];
    const auto found = sparse_.find(static_cast<int>(point));
    return found == sparse_.end() ? otherwise_ : found->second;
  }

  void set(int point, const T& value) {
    set_.push_back(point);
    if (points_ <= few)
      dense_[static_cast<std::size_t>(point)] = value;
    else
      sparse_[point] = value;
  }

 private:
  T otherwise_;
  int points_ = 0;
  std::vector<T> dense_;
  std::unordered_map<int, T> sparse_;
  std::vector<int> set_;
};

}  // namespace perp
