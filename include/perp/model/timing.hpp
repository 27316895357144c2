// When a load jumps: so that no step of a run passes over what it does.
#pragma once

#include <functional>
#include <utility>
#include <vector>

#include "perp/core/types.hpp"

namespace perp {

class Model;
struct State;

/// What a load or a motion says of itself as a function of time, where it is made of Timed functions. Nothing said: it may do anything
/// at any time, and a method that chooses its steps looks at it now and then (EventDrivenOptions::look).
struct Timing {
  bool steady = false;             ///< it depends on t through the state alone
  std::vector<double> times = {};  ///< at which it, or a derivative of it, jumps [s], in any order

  /// The first time in (t, until) at which it jumps, infinity if there is none; found by looking every `look` where nothing better
  /// is known [s]. Empty: `times` are all there are.
  std::function<double(double t, double until, double look)> next = {};

  /// Functions of the state, through whose zeros it jumps.
  std::vector<std::function<double(const Model&, const State&)>> switches = {};

  /// The first of them in (t, until), infinity if there is none.
  double first(double t, double until, double look) const;
};

template <class Signature>
class Timed;

/// A function that says when it jumps: one for Model::add_force, JointMotor::effort, PrescribedMotion::twist, JointMotion::rate,
/// as in model.add_force(body, Timed<Wrench(const Model&, const State&)>(push, {.times = {5, 5.01}})).
template <class Result, class... Arguments>
class Timed<Result(Arguments...)> {
 public:
  Timed(std::function<Result(Arguments...)> function, Timing timing)
      : function_(std::move(function)), timing_(std::move(timing)) {}
  Result operator()(Arguments... arguments) const { return function_(arguments...); }
  const Timing& timing() const { return timing_; }

 private:
  std::function<Result(Arguments...)> function_;
  Timing timing_;
};

/// What a function says of its times; null if it is not Timed.
template <class Signature>
const Timing* timing_of(const std::function<Signature>& function) {
  const auto* timed = function.template target<Timed<Signature>>();
  return timed == nullptr ? nullptr : &timed->timing();
}

}  // namespace perp
