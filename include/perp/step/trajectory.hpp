// A run: states, and what every step said of itself.
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "perp/step/stepper.hpp"

namespace perp {

enum class EventKind {
  Touch,     ///< a contact closes without a jump of velocities
  Lift,      ///< it opens
  Stick,     ///< sliding ends
  Slip,      ///< sliding begins
  Reverse,   ///< sliding goes on the other way
  Stop,      ///< a joint's limit closes
  Impact,    ///< velocities jump
  Zeno,      ///< infinitely many events, or too many: carried across
  Painleve,  ///< CP1 had no solution, or several
  Load,      ///< a load or a motion jumps, or a derivative of it
  User       ///< a UserEvent
};

[[nodiscard]] std::string_view name_of(EventKind kind);  ///< "touch", "lift", ...

/// What happened at one time to one contact point or joint.
struct Event {
  double t = 0;
  EventKind kind = EventKind::Touch;
  std::string contact;                     ///< name of the contact point or the joint; empty: of none alone
  ContactMode before = ContactMode::Open;  ///< of a joint: Stick or Slip
  ContactMode after = ContactMode::Open;
};

/// An event of the user's: where `when` goes through zero. Methods that locate events find it as exactly as their own; those of steps
/// of fixed size in the cubics between their states (Trajectory::at), where it is at most an eighth of a step from the next.
struct UserEvent {
  std::string name = {};  ///< in Event::contact
  std::function<double(const Model&, const State&)> when = {};
  int direction = 0;  ///< 1: rising, -1: falling, 0: either
  /// What then: it may change q and nu (of fixed steps: of the state at the end of the step), and says whether the run goes on.
  /// Empty: the time is marked and the run goes on.
  std::function<bool(const Model&, State&)> then = {};

  bool passes(double before, double after) const {
    return (direction >= 0 && before < 0 && after >= 0) || (direction <= 0 && before > 0 && after <= 0);
  }
};

/// States at t_0 .. t_n and the reports of the n steps between them. Stored flat: what a step adds is copied into space
/// reserved at the start.
class Trajectory {
 public:
  Trajectory() = default;
  /// Starts with x; makes room for `steps` more.
  Trajectory(const State& x, std::size_t steps);
  void reserve_rows(std::size_t contacts, std::size_t joints);  ///< rows of all steps together

  void add(const State& x, const StepReport& report);

  std::size_t size() const { return t_.size(); }         ///< states, the first included
  std::size_t steps() const { return figures_.size(); }  ///< size() - 1
  double t(std::size_t i) const { return t_[i]; }
  State state(std::size_t i) const;  ///< throws std::out_of_range past size()
  State front() const { return state(0); }
  State back() const { return state(size() - 1); }

  const StepFigures& figures(std::size_t step) const { return figures_[step]; }
  StepReport report(std::size_t step) const;  ///< of the step to state(step + 1)

  /// The state at any time of the run. Of methods that choose their steps: integrated anew from the last state before t, to the run's
  /// own tolerance; just after an event if t is one. Of runs of fixed steps: by cubics between their states, order 4 in q and 3 in nu
  /// besides the method's own error. Throws std::invalid_argument for a time outside the run, and for rows without a model.
  State at(double t) const;

  std::vector<Event> events;  ///< in order of time, of methods that locate them
  long evaluations = 0;       ///< of the right-hand side, of methods that have one
  /// How far steps carried across (event zeno without a name, solver inelastic-step) may be from the motion [m, m/s], added up: each
  /// compared with two of half its size. Other steps keep the tolerance.
  double carried_error = 0;
  /// The longest interval in which nobody looked at loads that may depend on time and name no times [s]; 0 if there are none.
  double unseen = 0;

  /// How at() goes on from state i to t.
  std::function<State(const State& from, std::size_t i, double t)> between;
  std::shared_ptr<const Model> model;  ///< of runs of fixed steps: what at() needs

 private:
  std::size_t nq_ = 0, nv_ = 0, windings_ = 0;
  std::vector<double> t_, q_, nu_, winding_;
  std::vector<StepFigures> figures_;
  std::vector<ContactRow> contacts_;
  std::vector<JointImpulse> joints_;
  std::vector<std::size_t> contacts_end_, joints_end_;  // of each step, in the two above
  std::shared_ptr<const std::vector<std::string>> point_names_, joint_names_;
};

/// What simulate() asks of a method that chooses its steps.
struct RunRequest {
  double t_end = not_set;
  double h = not_set;  ///< rows at its multiples too, if set
  std::function<bool(double t)> progress = {};
  std::vector<UserEvent> events = {};
};

/// A method that chooses its steps by a tolerance: it takes whole runs.
class AdaptiveStepper : public Stepper {
 public:
  virtual double tolerance() const = 0;

  /// From run.back() to t_end, adding rows and events. The report is that of the step at which it ended: if not advanced(), t_end was
  /// not reached.
  [[nodiscard]] virtual StepReport run(const Model& model, Trajectory& run, const RunRequest& request) = 0;
};

/// Whether a method is one of those.
[[nodiscard]] bool chooses_steps(const Stepper& stepper);

}  // namespace perp
