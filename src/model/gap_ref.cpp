#include "perp/model/gap_ref.hpp"

#include "model/pairs/shape_geometry.hpp"

namespace perp {

int GapRef::points() const { return listed_ != nullptr ? listed_->points() : ShapePair(*a_, *b_).points(); }

double GapRef::lever_a() const { return listed_ != nullptr ? listed_->lever_a() : a_->lever; }
double GapRef::lever_b() const { return listed_ != nullptr ? listed_->lever_b() : b_->lever; }

const Recipe& GapRef::recipe() const {
  static const Recipe none{};
  return listed_ != nullptr ? listed_->recipe() : none;
}

void GapRef::operator()(const Pose& X_WA, const Pose& X_WB, double t, std::span<ContactPoint> out) const {
  listed_ != nullptr ? (*listed_)(X_WA, X_WB, t, out) : ShapePair(*a_, *b_).evaluate(X_WA, X_WB, out);
}

void GapRef::differentiate(const Pose& X_WA, const Pose& X_WB, double t,
                           std::span<ContactDerivative> out) const {
  listed_ != nullptr ? listed_->differentiate(X_WA, X_WB, t, out)
                     : ShapePair(*a_, *b_).differentiate(X_WA, X_WB, out);
}

double GapRef::at_least(const Pose& X_WA, const Pose& X_WB) const {
  return listed_ != nullptr ? -infinity : ShapePair(*a_, *b_).at_least(X_WA, X_WB);
}

}  // namespace perp
