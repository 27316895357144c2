#include "perp/step/auto_method.hpp"

#include <algorithm>

#include "perp/core/errors.hpp"

namespace perp {
namespace {

constexpr int few_points = 32;  // of contacts: events among more of them come one after the other
constexpr std::size_t many_contacts = 5000;  // whose points are not counted one by one
constexpr int many_points = 400;  // of contacts: the second stage of ncp2 costs as much as the first

/// Whether the contact's gap is linear in q and its directions stay: a particle, which cannot turn, on a plane that stands.
bool linear(const Model& model, const Contact& c) {
  if (c.stop.joint >= 0 || c.own || c.tangents > 1) return c.stop.joint >= 0;
  const auto stands = [&](BodyId b) { return model.body(b).kind == BodyKind::Ground; };
  const auto particle = [&](BodyId b) { return model.body(b).kind == BodyKind::Particle; };
  const std::string_view maker = c.gap.recipe().maker;
  const bool plane = maker.size() > 9 && maker.substr(maker.size() - 9) == "_on_plane";
  return plane && stands(c.a) && particle(c.b);
}

}  // namespace

MethodChoice choose_method(const Model& model, bool with_step) {
  int points = 0;
  if (model.touching_contacts() > many_contacts)
    points = model.contact_points();
  else
    model.each_point([&](int) { ++points; });
  const std::string count = std::to_string(points) + " contact points";
  if (!with_step) {
    if (points > few_points)
      refuse("--method auto", "--step", "not given",
             "is needed: the scene has " + count + ", and events would be many");
    return {"event", count + ": events are few, and no step bounds the accuracy"};
  }
  const auto& contacts = model.contacts();
  const bool all_linear =
      model.shapes().empty() &&
      std::all_of(contacts.begin(), contacts.end(), [&](const Contact& c) { return linear(model, c); });
  if (points > 0 && model.joints().empty() && all_linear)
    return {"lcp", "all gaps are linear and friction keeps its line: lcp gives what ncp gives, cheaper"};
  if (points > many_points)
    return {"ncp", count + ": a step of one stage, circular cones, gaps that do not drift"};
  return {"ncp2", points == 0 ? "no contacts: the second order costs little more"
                              : count + ": order 2 between events, circular cones, nonlinear gaps"};
}

}  // namespace perp
