#include "io/scene_events.hpp"

#include <algorithm>
#include <functional>
#include <tuple>

#include "io/scene_text.hpp"
#include "perp/core/errors.hpp"

namespace perp {
namespace {

/// What an expression may name.
struct Observable {
  std::string name;
  std::function<double(const Model&, const State&)> value;
};

void add_generalized(const Body& body, std::vector<Observable>& all) {
  for (int i = 0; i < body.nv; ++i) {
    all.push_back({body.name + ".q" + std::to_string(i + 1),
                   [k = body.q0 + i](const Model&, const State& x) { return x.q[k]; }});
    all.push_back({body.name + ".v" + std::to_string(i + 1),
                   [k = body.v0 + i](const Model&, const State& x) { return x.nu[k]; }});
  }
}

void add_orientation(BodyId b, const std::string& name, std::vector<Observable>& all) {
  for (int k = 0; k < 3; ++k)
    all.push_back({name + ".w" + "xyz"[k],
                   [b, k](const Model& m, const State& x) { return m.angular_velocity(x, b)[k]; }});
  for (int k = 0; k < 4; ++k)
    all.push_back({name + ".q" + "wxyz"[k], [b, k](const Model& m, const State& x) {
                     const Quaternion q = m.pose(x, b).q;
                     return k == 0 ? q.w() : q.vec()[k - 1];
                   }});
}

void add_body(BodyId b, const Body& body, std::vector<Observable>& all) {
  const bool planar = body.kind == BodyKind::Planar;
  for (int k = 0; k < (planar ? 2 : 3); ++k) {
    all.push_back(
        {body.name + "." + "xyz"[k], [b, k](const Model& m, const State& x) { return m.position(x, b)[k]; }});
    all.push_back({body.name + ".v" + "xyz"[k],
                   [b, k](const Model& m, const State& x) { return m.velocity(x, b)[k]; }});
  }
  if (planar) {
    all.push_back({body.name + ".angle", [b](const Model& m, const State& x) { return m.angle(x, b); }});
    all.push_back(
        {body.name + ".omega", [b](const Model& m, const State& x) { return m.angular_velocity(x, b).z(); }});
  } else if (body.kind != BodyKind::Particle) {
    add_orientation(b, body.name, all);
  }
}

void add_joint(JointId joint, const JointGeometry& geometry, std::vector<Observable>& all) {
  const int n = static_cast<int>(geometry.coordinates.size());
  for (int i = 0; i < n; ++i) {
    const std::string own(geometry.coordinates[static_cast<std::size_t>(i)].name);
    const std::string name = n == 1 ? geometry.name : geometry.name + "." + own;
    all.push_back({name + ".coordinate",
                   [joint, i](const Model& m, const State& x) { return m.coordinate(x, joint, i); }});
    all.push_back({name + ".rate",
                   [joint, i](const Model& m, const State& x) { return m.coordinate_rate(x, joint, i); }});
  }
}

std::vector<Observable> observables_of(const Model& model) {
  std::vector<Observable> all{{"t", [](const Model&, const State& x) { return x.t; }}};
  for (int i = 1; i < static_cast<int>(model.bodies().size()); ++i) {
    const Body& body = model.body({i});
    if (body.kind == BodyKind::Generalized)
      add_generalized(body, all);
    else
      add_body({i}, body, all);
  }
  for (int i = 0; i < static_cast<int>(model.joints().size()); ++i) add_joint({i}, model.joint({i}), all);
  return all;
}

/// The function that `when` writes, of what it uses alone; its text, with the values of parameters.
std::pair<std::function<double(const Model&, const State&)>, std::string> read_when(const SceneTable& table,
                                                                                    const Model& model) {
  const std::vector<Observable> all = observables_of(model);
  std::vector<std::string> names;
  for (const Observable& q : all) names.push_back(q.name);
  const Expression written = table.expression("when", names, Dimension::None);
  if (written.constant())
    table.refuse("when", "\"" + written.text() + "\", which never changes",
                 "needs t, or a coordinate of a body or a joint, as BODY.x");
  std::vector<Observable> used;
  for (std::size_t i = 0; i < all.size(); ++i)
    if (written.uses(i)) used.push_back(all[i]);
  names.clear();
  for (const Observable& q : used) names.push_back(q.name);
  const Expression g(written.text(), {}, names);
  const auto when = [g, used](const Model& m, const State& x) {
    std::vector<double> now;
    now.reserve(used.size());
    for (const Observable& q : used) now.push_back(q.value(m, x));
    return g(now);
  };
  return {when, written.text()};
}

}  // namespace

UserEvent read_event(const SceneTable& table, const Model& model, const std::vector<UserEvent>& before) {
  table.allow({"name", "when", "direction", "then"});
  UserEvent event;
  event.name = table.has("name") ? table.name() : "event-" + std::to_string(before.size() + 1);
  if (std::any_of(before.begin(), before.end(), [&](const UserEvent& e) { return e.name == event.name; }))
    table.refuse("name", "the event '" + event.name + "' a second time", "needs a name of its own");
  std::string text;
  std::tie(event.when, text) = read_when(table, model);
  const double direction = table.number("direction", Dimension::None, 0);
  if (direction != -1 && direction != 0 && direction != 1)
    table.refuse("direction", "the direction " + shortest(direction),
                 "needs to be 1 (rising), -1 (falling) or 0 (either)");
  event.direction = static_cast<int>(direction);
  const bool stops = table.has("then") && table.word("then", {"stop", "mark"}) == 0;
  if (stops) event.then = stop_run;
  event.recipe = {stops ? "stop" : "mark", {}, {text}};
  return event;
}

std::string write_event(const UserEvent& event) {
  std::string text =
      "name = " + in_quotes(event.name) + "\nwhen = " + in_quotes(event.recipe.texts.front()) + "\n";
  if (event.direction != 0) text += "direction = " + std::to_string(event.direction) + "\n";
  return text + "then = " + in_quotes(event.recipe.maker) + "\n";
}

}  // namespace perp
