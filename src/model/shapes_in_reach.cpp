#include "perp/model/shapes_in_reach.hpp"

#include <algorithm>
#include <cmath>

#include "core/index.hpp"
#include "model/pairs/shape_geometry.hpp"

namespace perp {
namespace {

/// About a shape that ends, `by` larger on every side; all of space where its body is nowhere.
BroadPhase::Box box_about(const BodyShape& s, const Pose& X, double by) {
  constexpr double far = 1e150;
  const Pose place = X * s.pose;
  if (!place.p.allFinite() || !place.q.coeffs().allFinite())
    return {Vector3::Constant(-far), Vector3::Constant(far)};
  if (s.shape.kind() == Shape::Kind::Sphere)
    return {place.p.array() - (s.geometry->reach + by), place.p.array() + (s.geometry->reach + by)};
  const Matrix3 R = place.R();
  BroadPhase::Box box;
  for (int i = 0; i < 3; ++i) {
    const Vector3 along = R.row(i);
    box.max()[i] = place.p[i] + along.dot(s.shape.support(along)) + by;
    box.min()[i] = place.p[i] + along.dot(s.shape.support(-along)) - by;
  }
  return box;
}

}  // namespace

const std::vector<int>& ShapesInReach::find(const Model& model, const std::vector<Pose>& X, double margin) {
  found_.clear();
  boxes_.clear();
  shape_of_box_.clear();
  endless_.clear();
  const std::vector<BodyShape>& shapes = model.shapes();
  for (int i = 0; i < static_cast<int>(shapes.size()); ++i) {
    if (!std::isfinite(shapes[at(i)].geometry->reach)) {
      endless_.push_back(i);
      continue;
    }
    boxes_.push_back(box_about(shapes[at(i)], X[at(shapes[at(i)].body.index)], 0.5 * margin));
    shape_of_box_.push_back(i);
  }
  // what has no end and turns: no travel of its body bounds how near it comes
  const auto boundless = [&](int i) {
    const BodyShape& s = shapes[at(i)];
    return s.body != ground && !std::isfinite(s.geometry->lever);
  };
  const auto take = [&](int i, int j) {
    if (!model.may_touch({i}, {j})) return;
    const int number = model.contact_of({i}, {j});
    const ContactView contact = model.contact(number);
    if (boundless(i) || boundless(j) ||
        !(contact.gap.at_least(X[at(contact.a.index)], X[at(contact.b.index)]) > margin))
      found_.push_back(number);
  };
  for (const auto& [i, j] : broad_phase_.overlaps(boxes_)) take(shape_of_box_[at(i)], shape_of_box_[at(j)]);
  for (const int endless : endless_)
    for (int i = 0; i < static_cast<int>(shapes.size()); ++i)
      if (i != endless) take(i, endless);
  std::sort(found_.begin(), found_.end());
  found_.erase(std::unique(found_.begin(), found_.end()), found_.end());
  return found_;
}

std::size_t ShapesInReach::bytes() const {
  return broad_phase_.bytes() + boxes_.capacity() * sizeof(BroadPhase::Box) +
         (shape_of_box_.capacity() + endless_.capacity() + found_.capacity()) * sizeof(int);
}

}  // namespace perp
