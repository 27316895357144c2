// Functions of the state whose zeros a run looks for besides those of its modes: loads jump there, or the user wants to know.
#pragma once

#include <string>
#include <vector>

#include "perp/step/user_event.hpp"
#include "step/events/loads_in_time.hpp"

namespace perp {

struct Scales;

/// Switches of loads, and after them the user's events, each with the side of its zero on which the run is.
class Switches {
 public:
  Switches() = default;
  Switches(const LoadsInTime& loads, const std::vector<UserEvent>& events);

  std::size_t size() const { return all_.size(); }
  bool empty() const { return all_.empty(); }
  bool of_user(std::size_t i) const { return all_[i].event != none; }
  const std::string& name(std::size_t i) const { return all_[i].name; }
  const UserEvent& event(std::size_t i) const { return events_[all_[i].event]; }
  /// Whether passing it, from the side on which it is, is an event that does something; one that counts at all.
  bool acts(std::size_t i) const { return counts(i) && (!of_user(i) || event(i).then); }
  bool counts(std::size_t i) const { return !of_user(i) || event(i).direction * all_[i].sign <= 0; }

  /// g times the sign that it has: it falls through zero where it is passed. 0 where the side is not known.
  double value(std::size_t i, const Model& model, const State& x) const {
    return all_[i].sign == 0 ? 0 : all_[i].sign * g(i, model, x);
  }
  double g(std::size_t i, const Model& model, const State& x) const { return all_[i].when(model, x); }
  bool known(std::size_t i) const { return all_[i].sign != 0; }

  /// At a state of the run: the largest that each has been, which its rounding is measured by; sides that are not known, of the user's
  /// events only where |g| is more than `vague` of that [-].
  void measure(const Model& model, const State& x, const Scales& scales, double vague);
  double scale(std::size_t i) const { return all_[i].scale; }

  void pass(std::size_t i) { all_[i].sign = -all_[i].sign; }
  void forget(std::size_t i) { all_[i].sign = 0; }
  void learn(std::size_t i, double g) { all_[i].sign = g < 0 ? -1 : 1; }

 private:
  static constexpr std::size_t none = static_cast<std::size_t>(-1);
  struct Switch {
    std::function<double(const Model&, const State&)> when;
    std::string name;
    std::size_t event = none;
    double sign = 0, scale = 0;
  };
  std::vector<Switch> all_;
  std::vector<UserEvent> events_;
};

}  // namespace perp
