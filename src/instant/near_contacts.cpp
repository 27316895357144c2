#include "perp/instant/near_contacts.hpp"

#include <algorithm>
#include <cmath>
#include <functional>

#include "core/index.hpp"

namespace perp {
namespace {

/// The levers of a contact that count: a body that never moves has none.
bool levers_of(const Model& model, const Contact& contact, double& largest) {
  largest = 0;
  if (contact.stop.joint >= 0) return false;
  for (const auto& [body, lever] :
       {std::pair(contact.a, contact.gap.lever_a()), std::pair(contact.b, contact.gap.lever_b())}) {
    if (model.body(body).kind == BodyKind::Ground || model.body(body).kind == BodyKind::Particle) continue;
    largest = std::max(largest, lever);
  }
  return std::isfinite(largest) && std::isfinite(contact.gap.lever_b());
}

}  // namespace

void NearContacts::reset(const Model& model) {
  revision_ = model.revision();
  selective_ = model.touching_contacts() >= worth_it;
  lever_ = travelled_ = 0;
  X_.clear();
  always_.clear();
  waiting_.clear();
  watched_.clear();
  near_.clear();
  for (std::size_t i = 0; i < model.contacts().size(); ++i) {
    double lever = 0;
    const bool known = selective_ && levers_of(model, model.contacts()[i], lever);
    (known ? watched_ : always_).push_back(static_cast<int>(i));
    if (known) lever_ = std::max(lever_, lever);
  }
  for (const BodyShape& s : model.shapes())
    if (const double lever = GapRef(*s.geometry, *s.geometry).lever_a(); selective_ && std::isfinite(lever))
      lever_ = std::max(lever_, lever);
  if (!selective_) model.each_contact([&](int i) { near_.push_back(i); });
}

double NearContacts::lever(const Model& model) {
  if (revision_ != model.revision()) reset(model);
  return lever_;
}

double NearContacts::travel_to(const Model& model, const std::vector<Pose>& Y) const {
  double furthest = 0;
  for (std::size_t i = 0; i < Y.size(); ++i) {
    if (model.bodies()[i].kind == BodyKind::Ground) continue;
    const double angle = lever_ > 0 ? rotation_vector(X_[i].q.conjugate() * Y[i].q).norm() : 0;
    furthest = std::max(furthest, (Y[i].p - X_[i].p).norm() + lever_ * angle);
  }
  return 2 * furthest;
}

const std::vector<int>& NearContacts::find(const Model& model, const std::vector<Pose>& X, double t,
                                           double margin) {
  if (revision_ != model.revision()) reset(model);
  if (!selective_) return near_;
  if (!X_.empty()) travelled_ += travel_to(model, X);
  X_ = X;
  const auto later = std::greater<std::pair<double, int>>();
  while (!waiting_.empty() && waiting_.front().first <= travelled_ + margin) {
    std::pop_heap(waiting_.begin(), waiting_.end(), later);
    watched_.push_back(waiting_.back().second);
    waiting_.pop_back();
  }
  near_ = always_;
  std::size_t kept = 0;
  for (const int i : watched_) {
    const Contact& contact = model.contacts()[at(i)];
    points_.resize(at(contact.gap.points()));
    contact.gap(X[at(contact.a.index)], X[at(contact.b.index)], t, points_);
    double least = infinity;
    for (const ContactPoint& c : points_) least = std::isnan(c.gap) ? -infinity : std::min(least, c.gap);
    // kept in sight up to a few margins, so that the heap is not asked at every step
    if (least <= margin) near_.push_back(i);
    if (least <= 4 * margin) {
      watched_[kept++] = i;
    } else {
      waiting_.emplace_back(travelled_ + least, i);
      std::push_heap(waiting_.begin(), waiting_.end(), later);
    }
  }
  watched_.resize(kept);
  std::sort(near_.begin(), near_.end());
  const std::vector<int>& shapes = shapes_.find(model, X, margin);  // whose numbers come after
  near_.insert(near_.end(), shapes.begin(), shapes.end());
  return near_;
}

}  // namespace perp
