// A run: states, and what every step said of itself.
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "perp/step/stepper.hpp"
#include "perp/step/user_event.hpp"

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
  std::string
      contact;  ///< name of the contact point, joint, loaded body or user's event; empty: of none alone
  ContactMode before = ContactMode::Open;  ///< of a joint: Stick or Slip
  ContactMode after = ContactMode::Open;
  bool ambiguous = false;  ///< one of impacts in sequence (Impact::ambiguous)
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

  /// The state at any time of the run, the last one of that time where velocities jump. Of methods that choose their steps: integrated
  /// anew from the last row before t, to the run's own tolerance. Of fixed steps: cubics through both ends of a step with their
  /// rates, within O(h^4) in q and O(h^3) in nu of the smooth motion through these; across an impact within the step O(h). Throws
  /// std::invalid_argument for a time outside the run, and for rows that were put together without `between`.
  State at(double t) const;

  std::vector<Event> events;    ///< in order of time: of methods that locate them, and the user's
  bool locates_events = false;  ///< whether the method does
  std::string stopped_by;       ///< the user's event that ended the run; empty if none did
  long evaluations = 0;         ///< of the right-hand side, of methods that have one
  /// The longest interval in which a method that chooses its steps did not look at loads and motions that change with time, and do more
  /// than jump at times that they name [s]; 0 if there are none.
  double unseen = 0;

  /// How at() comes from state i to t, which is before state i + 1.
  std::function<State(const Trajectory& run, std::size_t i, double t)> between;

 private:
  std::size_t nq_ = 0, nv_ = 0, windings_ = 0;
  std::vector<double> t_, q_, nu_, winding_;
  std::vector<StepFigures> figures_;
  std::vector<ContactRow> contacts_, halves_;
  std::vector<JointImpulse> joints_;
  std::vector<std::size_t> contacts_end_, halves_end_, joints_end_;  // of each step, in those above
  std::shared_ptr<const PointNames> point_names_;
  std::shared_ptr<const std::vector<std::string>> joint_names_;
};

/// What simulate() asks of a method that chooses its steps.
struct RunRequest {
  double t_end = not_set;
  double h = not_set;  ///< rows at its multiples too, if set
  std::function<bool(double t)> progress = {};
  std::vector<UserEvent> events = {};
};

/// A method that takes whole runs, since it chooses its steps by a tolerance, or cuts steps of fixed size at events.
class AdaptiveStepper : public Stepper {
 public:
  virtual double tolerance() const = 0;
  virtual bool chooses() const { return true; }  ///< false: steps are of the size that the run is asked for

  /// From run.back() to t_end, adding rows and events. The report is that of the step at which it ended: if not advanced(), t_end was
  /// not reached.
  [[nodiscard]] virtual StepReport run(const Model& model, Trajectory& run, const RunRequest& request) = 0;
};

/// Whether a method chooses its steps by a tolerance.
[[nodiscard]] bool chooses_steps(const Stepper& stepper);
/// Whether it is an AdaptiveStepper.
[[nodiscard]] bool takes_whole_runs(const Stepper& stepper);

}  // namespace perp
