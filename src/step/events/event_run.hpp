// One run of a method that locates events: stretches of fixed modes, and what happens between them.
#pragma once

#include <deque>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "perp/step/event_driven.hpp"
#include "step/events/integrator.hpp"
#include "step/events/loads_in_time.hpp"
#include "step/events/switches.hpp"
#include "step/modes/acceleration_problem.hpp"

namespace perp {

/// Errors that the first steps of a stretch may add up to, in tolerances [-].
constexpr double some_steps = 30;
/// What a root of force is where others than the least forces hold, in its `small` [-].
constexpr double feasible_root = 2;

/// What ends a mode: a function g of the state that falls through zero.
struct Root {
  enum Kind {
    Touch,         ///< psi_n of an open contact
    Lift,          ///< c_n of a closed one
    ContactRests,  ///< u_f . d of one that slides, d the direction of u_f at the start of the step
    ContactSlips,  ///< mu c_n - |c_f| of one that sticks; with moments c_n (1 - how far they fill their bound)
    WheelRests,    ///< the same of one that rolls against rolling friction
    WheelRolls,    ///< and of one whose moments hold it
    JointRests,    ///< rate of a joint with friction, times its sign
    JointSlips,    ///< c_max - |c_bf| of one at rest
    Switch         ///< one of Switches, or a time that a load names (index -1)
  };
  Kind kind = Touch;
  int index = 0;     ///< the point, or the joint friction
  double small = 0;  ///< |g| below which g is zero but for rounding
  double vague = 0;  ///< |g| below which it is so where g starts from zero and the integrator's error counts
  double vague_rate = infinity;  ///< the same of its rate, of gaps
  bool armed = false;            ///< it has been above zero in this stretch

  bool of_contact() const { return kind < JointRests; }
  bool far_side() const { return kind == Switch; }  ///< located past its zero, not before
  bool of_force() const {
    return kind == Lift || kind == ContactSlips || kind == WheelRolls || kind == JointSlips;
  }

  /// Whether g, with its rate where that is known, is below zero for sure.
  bool fell(double g, double rate) const { return g < -(armed || rate < -vague_rate ? small : vague); }
};

/// Forces that redundant rows at rest take in place of those of the flow, less these: contacts and moments in world axes.
struct ForceShift {
  std::vector<Vector3> contact, moment;
  Vector joint_reaction, joint_friction;
  bool none() const { return contact.empty(); }
};

/// The system at one state of a stretch: what rows, energies and root functions are made of.
struct EventSample {
  State x;
  Vector nu_dot;
  std::vector<Vector3> force, velocity;  ///< of each closed contact, along n, t, o
  std::vector<Vector3> moment;           ///< and about them; empty where no contact has moments
  Vector joint_force, joint_rate;        ///< of each joint friction
  Vector joint_reaction;                 ///< of each joint equation
  Vector g, g_rate;                      ///< of the roots; rates of gaps and speeds, not of forces
  std::vector<Vector3> normal;           ///< of Touch, zero of other roots
  bool feasible = true;                  ///< forces hold the modes: none pulls, or is outside its bound
  ForceShift shift;                      ///< that these forces have in them
  RowSums row;                           ///< from the start of the step, of a flow that sums up
};

[[nodiscard]] bool triggered(const std::vector<Root>& triggers, Root::Kind kind, int index);
/// Of a contact point in these modes; Slip if it is closed without friction.
[[nodiscard]] ContactMode mode_in(const Modes& modes, const Model& model, int point);
/// How much a unit of normal force accelerates a contact's bodies apart [1/kg].
[[nodiscard]] double mobility(const Model& model, const Instant& instant, const ContactInstant& c);

/// What Trajectory::at needs: the model, and the modes that hold from a row on.
struct EventContinuation {
  Model model;
  MakeIntegrator integrator;
  struct Stretch {
    std::size_t row;
    Modes modes;
    double small_speed;
  };
  std::vector<Stretch> stretches;
  struct End {
    std::size_t row;  ///< the last of the stretch
    std::vector<Root> triggers;
  };
  std::vector<End> ends;  ///< of stretches that an event ended

  /// From the state of a row to t before the next, by an integration of its own.
  State go_on(const State& from, std::size_t row, double t) const;
};

/// State and modes of a run that goes on: adds rows and events to a trajectory.
class EventRun {
 public:
  /// `flow` integrates stretches, `between` from a row to a time before the next.
  EventRun(const Model& model, const EventDrivenOptions& options, const MakeIntegrator& flow,
           const MakeIntegrator& between, Trajectory& out);

  /// Rows up to t_end, or to where `progress` ends it. False, and `report` says why, where it cannot go on.
  bool run(const RunRequest& request);

  StepReport report;  ///< of the last row, or of what failed
  const EventContinuation& continuation() const { return *continuation_; }

 private:
  bool fail(StepStatus status, const std::string& why);
  bool begin();
  bool advance(double t_stop);
  double time_of_quarter_turn() const;
  bool handle_event(const State& x, const std::vector<Root>& triggers);
  bool settle(const std::vector<Root>& triggers);
  Modes closed_modes(const State& x) const;
  AccelerationAnswer accelerations(const State& x, const Modes& closed);
  void arm_roots(const std::vector<Root>& triggers);
  bool jump(bool jam);
  bool jumped() const { return !jump_rows_.empty() || jump_reactions_.size() > 0; }
  void watch_loads(double t_end);
  double just_before_jump() const;
  bool jump_of_loads(const EventSample& before);
  EventSample near_side(const EventSample& found, const std::vector<Root>& triggers);
  double seen_until(const EventSample& a, const EventSample& b);
  bool switch_passed(EventSample& middle, EventSample& end, EventSample& high);
  std::string switch_fault(const EventSample& s) const;
  std::string joints_torn(const State& x) const;
  bool only_marks(const std::vector<Root>& triggers) const;
  void mark(EventSample&& found, const std::vector<Root>& triggers);
  void pass_switches(const std::vector<Root>& triggers);
  void act_at(std::size_t index);
  double joint_rate() const;
  double step_across(double t_stop) const;
  bool carry_across(double t_stop, const std::string& why);
  bool too_many_events();
  void take_modes(const Modes& closed, const Instant& instant, const AccelerationAnswer& answer,
                  const std::vector<Root>& triggers);
  std::vector<Root> list_roots();
  void list_switches();

  EventSample sample(const State& x);
  void read_roots(EventSample& s);
  bool goes_on(const AccelerationAnswer& answer) const;
  bool take_feasible_forces(EventSample& s);
  bool holds(const Modes& modes, const AccelerationProblem& problem, const AccelerationAnswer& answer) const;
  void take_forces(const AccelerationAnswer& answer, EventSample& s) const;
  bool spent() const;
  State half_way(const EventSample& a, const EventSample& b) const;
  State between(const EventSample& a, const EventSample& b, double t) const;
  bool state_at(double t, EventSample& s);
  bool bracket(const EventSample& middle, const EventSample& end, EventSample& high);
  bool fell(std::size_t root, const EventSample& s, double share = 1) const;
  bool any_dips(const EventSample& a, const EventSample& b, EventSample& high);
  bool dips(std::size_t root, EventSample a, EventSample b, EventSample& high, int halvings = 0);
  bool locate(const EventSample& high, EventSample& found, std::vector<Root>& triggers);
  bool solve_root(std::size_t root, const EventSample& low, const EventSample& high, EventSample& found);

  double vague_gap() const;
  bool inelastic(int point, double approach);
  void log_rolling(const Modes& before, int point);
  void log_changes(const Modes& before, const std::vector<Root>& triggers);
  void log(EventKind kind, const std::string& name, ContactMode before, ContactMode after);
  void add_row(const EventSample& from, const EventSample& to, const State& end);
  void add_shift(const ForceShift& shift, double time, RowSums& row) const;
  void add_jump_row();
  void certify(const EventSample& s);
  double moments_miss(const ContactInstant& c, const MomentInstant& m, const EventSample& s, std::size_t i,
                      const Vector3& a, const Vector3& alpha, double w) const;

  const Model& model_;
  const EventDrivenOptions& options_;
  const double atol_;
  Trajectory& out_;
  ModeDynamics dynamics_;
  std::unique_ptr<ModeIntegrator> integrator_, local_;
  AccelerationProblem problem_;
  Instant instant_;
  Scales scales_;
  Modes modes_;
  std::vector<Root> roots_;
  EventSample now_;
  double t_begin_ = 0;  // of the run
  bool restart_ = true;
  bool still_ = false;      // what a step across has left is stopped without restitution
  bool disturbed_ = false;  // the user has changed the state
  LoadsInTime loads_;
  LoadsInTime::Jump jump_;  // the next that is named
  double look_ = infinity, look_until_ = infinity, t_end_ = infinity;
  double unseen_ = 0;  // the longest interval in which loads were not looked at
  Switches switches_;
  double natural_step_ = 0;  // of the integrator, where nothing cut it short
  int carried_ = 0, short_steps_ = 0;
  long evaluations_before_ = 0, feasibility_tests_ = 0;

  std::vector<ContactRow> jump_rows_;  // of the event in hand
  Vector jump_reactions_;              // and of its joint equations; empty without a jump
  double jump_energy_ = 0, jump_friction_ = 0;
  bool ambiguous_ = false;  // its impacts in another order would end otherwise
  struct Jumped {
    int point;
    EventKind kind;
    ContactMode before;
  };
  std::vector<Jumped> jumped_;
  std::vector<int> resting_;  // points whose sliding came to an end
  std::vector<int> held_;     // and whose rolling did
  std::vector<int> closing_;  // points that opened too slowly to rise before they fall
  std::deque<double> event_times_;
  struct Bounces {
    double last = -infinity, interval = infinity;
    int chain = 0;
  };
  std::map<int, Bounces> bounces_;  // by point

  std::shared_ptr<EventContinuation> continuation_;
};

}  // namespace perp
