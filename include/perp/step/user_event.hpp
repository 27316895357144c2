// What a run looks out for besides what its method needs to know.
#pragma once

#include <functional>
#include <string>

#include "perp/model/model.hpp"
#include "perp/model/recipe.hpp"
#include "perp/model/state.hpp"

namespace perp {

enum class AfterEvent { GoOn, Stop };

/// An event of the user's: a time at which g(t, q, nu) goes through zero.
///
/// `event` locates it as exactly as its own events. Methods of fixed steps look for it in the cubics between their states
/// (Trajectory::at) and, where something is to be done, take the step again to the time found, so that it is done to a state of
/// the method's own, as near to the zero as the method's order has it. g is looked at eight times a step, by `event` every
/// EventDrivenOptions::look: of two zeros of one g that are nearer to each other neither may be seen. A g that starts from its zero,
/// or is left there by `then`, is on the side to which it goes; a g that only touches zero does not pass it.
struct UserEvent {
  std::string name = {};                                        ///< in Event::contact and events.csv
  std::function<double(const Model&, const State&)> when = {};  ///< g; required
  int direction = 0;                                            ///< 1: rising, -1: falling, 0: either
  /// What is done then, and whether the run goes on: it may change q and nu, and the run goes on from there, as after an impact
  /// if what it set is against a contact or a joint. Empty: the time is written down.
  std::function<AfterEvent(const Model&, State&)> then = {};
  Recipe recipe =
      {};  ///< how a scene file says it: "stop" or "mark", and the expression; empty of functions of one's own
};

/// For UserEvent::then.
inline AfterEvent stop_run(const Model& /*model*/, State& /*x*/) { return AfterEvent::Stop; }

}  // namespace perp
