#include "io/scene_events.hpp"

#include <algorithm>
#include <functional>
#include <tuple>

#include "io/observables.hpp"
#include "io/scene_text.hpp"
#include "perp/core/errors.hpp"

namespace perp {
namespace {

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
  const auto when = observed(written, all);
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
