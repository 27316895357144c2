#include "io/scene_events.hpp"

#include <array>

#include "io/scene_text.hpp"

namespace perp {
namespace {

/// A coordinate of a body by its name in trajectory.csv.
struct NamedCoordinate {
  std::string name;
  std::function<double(const Model&, const State&)> value;
};

void add_generalized(const Body& body, std::vector<NamedCoordinate>& all) {
  for (int i = 0; i < body.nv; ++i) {
    all.push_back({body.name + ".q" + std::to_string(i + 1),
                   [k = body.q0 + i](const Model&, const State& x) { return x.q[k]; }});
    all.push_back({body.name + ".v" + std::to_string(i + 1),
                   [k = body.v0 + i](const Model&, const State& x) { return x.nu[k]; }});
  }
}

std::vector<NamedCoordinate> coordinates_of(const Model& model) {
  std::vector<NamedCoordinate> all{{"t", [](const Model&, const State& x) { return x.t; }}};
  for (int i = 1; i < static_cast<int>(model.bodies().size()); ++i) {
    const BodyId b{i};
    const Body& body = model.body(b);
    const bool planar = body.kind == BodyKind::Planar;
    if (body.kind == BodyKind::Generalized) {
      add_generalized(body, all);
      continue;
    }
    for (int k = 0; k < (planar ? 2 : 3); ++k) {
      const std::string axis(1, "xyz"[k]);
      all.push_back(
          {body.name + "." + axis, [b, k](const Model& m, const State& x) { return m.position(x, b)[k]; }});
      all.push_back(
          {body.name + ".v" + axis, [b, k](const Model& m, const State& x) { return m.velocity(x, b)[k]; }});
      if (planar || body.kind == BodyKind::Particle) continue;
      all.push_back({body.name + ".w" + axis,
                     [b, k](const Model& m, const State& x) { return m.angular_velocity(x, b)[k]; }});
    }
    if (!planar) continue;
    all.push_back({body.name + ".angle", [b](const Model& m, const State& x) { return m.angle(x, b); }});
    all.push_back(
        {body.name + ".omega", [b](const Model& m, const State& x) { return m.angular_velocity(x, b).z(); }});
  }
  return all;
}

}  // namespace

UserEvent read_event(const SceneTable& table, const Model& model, std::size_t number) {
  table.allow({"name", "when", "direction", "then"});
  const std::vector<NamedCoordinate> all = coordinates_of(model);
  std::vector<std::string> names;
  for (const NamedCoordinate& c : all) names.push_back(c.name);
  const Expression when = table.expression("when", names, Dimension::None);
  std::vector<NamedCoordinate> used(all.size());
  for (std::size_t i = 0; i < all.size(); ++i)
    if (when.uses(i)) used[i] = all[i];

  UserEvent event;
  event.name = table.has("name") ? table.name() : "event-" + std::to_string(number);
  event.when = [when, used](const Model& m, const State& x) {
    std::vector<double> now(used.size());
    for (std::size_t i = 0; i < used.size(); ++i)
      if (used[i].value) now[i] = used[i].value(m, x);
    return when(now);
  };
  const double direction = table.number("direction", Dimension::None, 0);
  if (direction != -1 && direction != 0 && direction != 1)
    table.refuse("direction", "the direction " + written(std::array{direction}), "needs to be -1, 0 or 1");
  event.direction = static_cast<int>(direction);
  const bool stops = table.has("then") && table.word("then", {"stop", "mark"}) == 0;
  if (stops) event.then = [](const Model&, State&) { return false; };
  return event;
}

}  // namespace perp
