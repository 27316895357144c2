// Names of contact points, of which pairs of shapes have too many to write them all down.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "perp/model/body_shapes.hpp"

namespace perp {

/// Pairs of n shapes, each with a range of numbers of its own for its points: those of shape j with the shapes before it follow each
/// other, all with as many as the largest of them needs.
class PairNumbers {
 public:
  void add(int most_points);  ///< a shape, of whose pairs with those before it none has more points
  int shapes() const { return static_cast<int>(row_.size()); }
  int pairs() const { return shapes() * (shapes() - 1) / 2; }
  int points() const { return points_; }

  static int pair(int i, int j) { return j * (j - 1) / 2 + i; }  ///< i < j
  struct Pair {
    int i, j;
  };
  static Pair pair(int number);
  int first_point(const Pair& pair) const {
    const Row& row = row_[static_cast<std::size_t>(pair.j)];
    return row.first + pair.i * row.each;
  }
  Pair pair_of_point(int point) const;

  friend bool operator==(const PairNumbers&, const PairNumbers&) = default;

 private:
  struct Row {
    int first, each;
    friend bool operator==(const Row&, const Row&) = default;
  };
  std::vector<Row> row_;
  int points_ = 0;
};

/// By number of the point, as Model and StepReport count them.
class PointNames {
 public:
  /// A contact's own name of one point, or NAME.0, NAME.1, ...; of shapes BODY.SHAPE|BODY.SHAPE, or that and |0, |1, ...
  std::string operator[](std::size_t point) const;
  std::size_t size() const { return listed_.size() + static_cast<std::size_t>(pairs_.points()); }
  int find(std::string_view name) const;  ///< the number; -1: none has it
  std::string known() const;              ///< for a message: all listed ones, and what shapes' are like

  friend bool operator==(const PointNames& a, const PointNames& b) {
    return a.listed_ == b.listed_ && a.shapes_ == b.shapes_ && a.pairs_ == b.pairs_;
  }

 private:
  friend class Model;
  struct NamedShape {
    std::string name;  // BODY.SHAPE
    int body;
    std::shared_ptr<const ShapeGeometry> geometry;
    friend bool operator==(const NamedShape& a, const NamedShape& b) {
      return a.name == b.name && a.body == b.body;
    }
  };
  std::string pair_name(const PairNumbers::Pair& pair) const;
  int points_of(const PairNumbers::Pair& pair) const;

  std::vector<std::string> listed_;
  std::vector<NamedShape> shapes_;
  PairNumbers pairs_;
};

}  // namespace perp
