// Is a run what its method says that it is? Every step that advanced is computed again from the scene's text and the run's files:
// momentum, how positions follow velocities, gaps, joints, cones, energies; each in the method's own equations as doc/methods has
// them.
#pragma once

#include "run_files.hpp"

namespace checker {

/// One thing that does not hold.
struct Fault {
  std::size_t step = 0;
  std::string part;  // momentum, kinematic, joints, normal, friction, cone, energy, not-a-number, says-...
  std::string of;    // body, contact or joint
  double value = 0, allowed = 0;
};

struct Judgement {
  std::vector<Fault> faults;
  std::size_t steps = 0, loaded = 0, sliding = 0, impacts = 0;
  std::size_t wrong_steps() const;
};

/// Pass marks, relative to the speeds of a step's start, its loads and prescribed motions; what is added up rounds.
struct Marks {
  double speed = 1e-9;  // of the speeds of an island [-]
  double rounding = 64 * std::numeric_limits<double>::epsilon();
  double most = 4e-6;  // of the speeds: what rounding may come to
};

[[nodiscard]] Judgement judge(const Scene& scene, const Run& run, const std::string& method,
                              double event_tolerance = 1e-10, const Marks& marks = {});

/// One step in numbers that all parts share.
class Step {
 public:
  Step(const Scene& scene, const Run& run, std::size_t index, const std::vector<double>& coordinates,
       const std::string& method, const Marks& marks);

  const Scene& scene;
  const std::string& method;
  const Marks& marks;
  const std::size_t index;
  const double h;
  const State &x, &y;
  const StepRow& row;
  const std::vector<ContactRow>& contacts;
  const std::vector<JointReport>& joint_rows;
  State u;                               // what leads from x to y, bodies where x has them
  std::vector<double> values, values_y;  // joint coordinates at x and y
  std::vector<Touch> at_x, at_y;
  std::vector<JointState> joints_x, joints_y;
  std::vector<Wrench> load_x;
  std::vector<int> island;    // of each body; -1 of what does not move
  std::vector<double> speed;  // of each island [m/s]
  std::vector<char>
      struck;  // of each island: something loaded came in faster than loads make it, or rebounds
  std::vector<char> follows;  // of each island: the velocities at the end are those that moved it
  bool has_loaded = false, has_sliding = false, has_impact = false;

  double speed_of(int body) const;  // of the island
  double speed_of(const Touch& c) const;
  const JointReport* joint(std::size_t j) const;  // its first row
  /// Inverse mass along all directions at a contact, world axes [1/kg].
  Matrix3d mobility(const Touch& c, const State& at) const;
  /// |impulse| as a speed of the body: force/m, sqrt(moment J^-1 moment/m).
  double linear_speed(int body, const Vector3d& impulse) const;
  double angular_speed(int body, const Vector3d& moment_in_body) const;
  const Touch* touch(const std::vector<Touch>& all, const std::string& name) const;
  double allowed(double speed, double added_up) const;  // both [m/s]
  /// How a speed that is a difference of places over h rounds [m/s].
  double place_rounding() const { return place_rounding_; }
  /// Whether places were moved onto the joints after the step (lcp).
  bool projected() const { return row.of.contains("projection") && row.of.at("projection") > 0; }
  void fault(const std::string& part, const std::string& of, double value, double allowed);
  std::vector<Fault> faults;

 private:
  bool closed(const std::string& contact) const;
  void find_islands();
  void find_speeds();
  void find_strikes();
  double place_rounding_ = 0;
};

/// Impulses on a body as they add up, about its centre of mass, world axes.
struct Sum {
  Vector3d linear = Vector3d::Zero(), angular = Vector3d::Zero();
  double linear_size = 0, angular_size = 0;  // of the terms, as speeds
};
/// What contacts, joints and joint friction of the step give to each body, all acting where `at` has them.
[[nodiscard]] std::vector<Sum> reactions(const Step& s, const State& at, const std::vector<Touch>& touches,
                                         const std::vector<JointState>& joints);

void judge_numbers(Step& s);   // not-a-number, energies, what report.csv says of gaps and joints
void judge_balance(Step& s);   // lcp, ncp: momentum, kinematic; sets `follows`
void judge_contacts(Step& s);  // lcp, ncp, ncp2
void judge_joints(Step& s);    // all
void judge_halves(Step& s);    // ncp2: momentum
void judge_event(Step& s, const Run& run, double tolerance);

}  // namespace checker
