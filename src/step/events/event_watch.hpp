// The user's events: on which side of their zeros a run is, and where it passes them.
#pragma once

#include <string>
#include <vector>

#include "perp/step/stepper.hpp"
#include "perp/step/user_event.hpp"

namespace perp {

struct Scales;

/// Throws std::invalid_argument for an event without `when`, or a direction that is none.
void check_events(const std::vector<UserEvent>& events);

/// A sentence about a g that is not a number.
[[nodiscard]] std::string not_a_number(const std::string& event, double t);

/// How much g varies over the model's length, speed and time, by differences at x, or |g| where that is more: what its zeros are
/// measured by.
[[nodiscard]] double variation(const UserEvent& event, const Model& model, const State& x,
                               const Scales& scales);

/// Does to x what an event does. Where that changed it `report` is of the row that follows, of length 0: the change of energy is
/// the work of a load. Throws std::invalid_argument for what no state of the model may be, and for another time.
struct EventDone {
  bool changed = false, goes_on = true;
};
EventDone act(const UserEvent& event, const Model& model, State& x, StepReport& report);

/// Takes away, as an impact does, velocities that joints do not allow; `report`, that of act(), has its energy. False if none were found
/// that they allow. For methods whose steps start from velocities that fit.
[[nodiscard]] bool meet_joints(const Model& model, State& x, StepReport& report);

/// A run's events between states that are a step of fixed size apart, by looking at the cubics between them.
class EventWatch {
 public:
  /// `before`: of a run that is taken up again, a time back from `start` [s], to see from where a g comes that is at its zero now.
  EventWatch(const Model& model, const std::vector<UserEvent>& events, const State& start, double before = 0);

  struct Found {
    double t = 0;
    std::size_t index = 0;  ///< in the list of events
  };
  /// What comes to pass in (a.t, b.t], in order of time, up to the first that does something. Throws std::domain_error where a g is not
  /// a number.
  std::vector<Found> find(const State& a, const State& b);

  /// x is the state at which an event was found, taken by the method itself: g is off its zero by the error of the cubics.
  void arrived(std::size_t index, const State& x);

  const UserEvent& event(std::size_t index) const { return events_[index]; }

 private:
  struct Side {
    double sign = 0;   // 0: at the zero, not yet known to which side it goes
    double small = 0;  // |g| up to which that is so
    double noise = 0;  // |g| that says nothing
  };
  struct Change {
    double t = 0;
    std::size_t index = 0;
    double sign = 0;  // from then on
    bool counts = false;
  };
  double pass(std::size_t index, double sign, const State& a, const State& b, double low, double high) const;
  std::vector<Change> changes(std::size_t index, const State& a, const std::vector<State>& states) const;

  const Model& model_;
  const std::vector<UserEvent>& events_;
  std::vector<Side> sides_;
};

}  // namespace perp
