// One step of a method, and the certificate that comes with it.
#pragma once

#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "perp/model/model.hpp"

namespace perp {

enum class StepStatus {
  Solved,     ///< all residuals within the stepper's tolerance; the state moved
  Inexact,    ///< solved less well than the tolerance asks; the state did not move
  NotSolved,  ///< the step's problem has no solution, or none was found; the state did not move
  NotFinite,  ///< a gap, a load or the answer is not finite; the state did not move
};

enum class ContactMode { Open, Stick, Slip };

[[nodiscard]] std::string_view name_of(
    StepStatus status);  ///< "solved", "inexact", "not-solved", "not-finite"
[[nodiscard]] std::string_view name_of(ContactMode mode);  ///< "open", "stick", "slip"

/// How far the step's own equations are from holding, one number for each of the model's five parts (largest entry), recomputed
/// from the step's data: doc/certificate.md has each method's equations. NaN: the method does not pose that part in this step.
struct Residuals {
  double newton_euler = 0;  ///< (25) [N s, N m s]
  double kinematic = 0;     ///< (26) [m, rad]
  double joints = 0;        ///< (28) or the method's form of it [m, rad]
  double normal = 0;        ///< (32), as a velocity [m/s]
  double friction = 0;      ///< (36)-(38), as a velocity [m/s]
};

/// What one step says of itself, in numbers. Energies [J]; `NaN` where a failed step has no value, or a method has no such part.
///
/// The works are each made of their own impulses and the velocities at which the method poses their laws; none is a remainder but
///   energy_left = energy - (that at the start) - energy_friction - energy_impact - energy_load - energy_motor - energy_surface
///                 - energy_overlap,
/// which falls at the method's order where motion is regular. doc/certificate.md says what counts as what.
struct StepFigures {
  double t = 0;  ///< at the end of the step [s]
  double h = 0;  ///< step taken [s]
  StepStatus status = StepStatus::NotSolved;
  std::string_view solver = "none";  ///< who answered: "lemke", ...; "none" if nothing touched
  int iterations = 0;                ///< its pivots or Newton iterations
  Residuals residuals = {};
  double gap_min = infinity;   ///< min psi_n(q+, t+), nonlinear [m]
  double joint_error = 0;      ///< max |psi_b(q+, t+)|, nonlinear [m, rad]
  double projection = 0;       ///< by how much q+ was moved onto the joints after (26) [m, rad]
  double energy = not_set;     ///< Model::energy at the end
  double energy_friction = 0;  ///< work of the friction impulses, <= 0 where they dissipate
  double energy_impact = 0;    ///< what closing contacts and impacts take: work of normal impulses, <= 0
  double energy_load =
      not_set;  ///< of forces, dampers, and what of a generalized body's force has no potential
  double energy_motor = not_set;    ///< of motors, and of prescribed motions of joints
  double energy_surface = not_set;  ///< of prescribed bodies and their surfaces, through contacts and joints
  double energy_overlap = not_set;  ///< of impulses that push overlaps out and draw joints shut
  double energy_left = not_set;     ///< what none of these accounts for

  /// Whether the state moved; it does only if the step reached its tolerance.
  bool advanced() const { return status == StepStatus::Solved; }
};

/// One contact point in reach during a step. World axes.
struct ContactRow {
  int contact = 0;                             ///< in Model::contacts()
  int point = 0;                               ///< among all points of the model
  double gap = not_set;                        ///< at the end of the step [m]; NaN of a contact out of reach
  double p_n = 0;                              ///< normal impulse >= 0 [N s]
  Vector3 normal = Vector3::Zero();            ///< from a to b
  Vector3 position = Vector3::Zero();          ///< where the impulse acts [m]
  Vector3 impulse = Vector3::Zero();           ///< on b over the step, normal and friction [N s]
  Vector3 moment = Vector3::Zero();            ///< of torsion and rolling on b, likewise [N m s]
  Vector3 force = Vector3::Constant(not_set);  ///< at the end of the step, of methods that know it [N]
  ContactMode mode = ContactMode::Open;        ///< Slip for a closed contact without friction
  int half =
      0;  ///< 0: the whole step; 1, 2: a half of it, of methods whose steps have two, in StepReport::halves
};

/// A joint's part in a step: one for each of its coordinates, or a single one if it has none. World axes.
struct JointImpulse {
  int joint = 0;                           ///< in Model::joints()
  int coordinate = -1;                     ///< in JointGeometry::coordinates; -1: it has none
  double value = not_set, rate = not_set;  ///< of the coordinate at the end of the step [rad, m; rad/s, m/s]
  Vector3 impulse =
      Vector3::Zero();               ///< of the joint's equations on b over the step, at its anchor c_B [N s]
  Vector3 moment = Vector3::Zero();  ///< and their moment on b about c_B [N m s]
  double friction = 0;               ///< impulse of the joint's dry friction along its freedom [N s, N m s]
  ContactMode mode = ContactMode::Slip;  ///< Stick where friction holds; Slip where there is none
};

struct StepReport : StepFigures {
  std::string message;               ///< empty if advanced(), else why not
  std::vector<ContactRow> contacts;  ///< those in reach, in the model's order
  std::vector<JointImpulse> joints;  ///< of all joints, in the model's order
  /// Of methods that find a contact's impulse in two halves (`ncp2`), each with a normal and a law of its own: those of each half,
  /// by point, the first before the second. `contacts` has their sums. Empty of other methods.
  std::vector<ContactRow> halves;

  /// The row of the contact `name` (of a patch: NAME.0, NAME.1, ...). One that was out of reach has zero impulse, is Open,
  /// and its gap was not computed (NaN). Throws std::invalid_argument for a name that the model does not have.
  ContactRow contact(std::string_view name) const;

  /// The first row of the joint `name` (of a coordinate: NAME.COORDINATE, where the joint has several). Throws
  /// std::invalid_argument for a name that the model does not have.
  JointImpulse joint(std::string_view name) const;

  std::shared_ptr<const PointNames> point_names;
  std::shared_ptr<const std::vector<std::string>> joint_names;  ///< of the rows of `joints`
};

struct StepRequest {
  double h = 0;                            ///< > 0 [s]
  double t_end = not_set;                  ///< exact time at the end; x.t + h if not set
  double max_correction_speed = infinity;  ///< an overlap is pushed out at this speed at most [m/s]
  /// How deep the first state of the run overlapped, or how far its joints were open [m, rad]: to push that out may give energy.
  double first_overlap = infinity;
  bool keep_energy =
      true;  ///< a step that gains energy from nothing, and goes on doing so as h shrinks, does not advance
};

struct StepAnswer;

/// Energy that a step has from nothing, and the energies by which that is much or little [J].
struct StepGain {
  double from_nothing = 0, measure = 0;
};

/// A method. It keeps workspaces, so one Stepper serves one thread. Its answer is that of its arguments; `lcp`, `ncp` and `ncp2` begin with
/// what the last step found, so that the last bits, and which of several sets of reactions is found, depend on the steps before.
class Stepper {
 public:
  virtual ~Stepper() = default;
  virtual std::string_view name() const = 0;            ///< as in `perp run --method NAME`
  virtual int order() const = 0;                        ///< in smooth motion
  virtual int edges() const { return 0; }               ///< of its friction polygon; 0: the circular cone
  virtual bool halves() const { return false; }         ///< whether it fills StepReport::halves
  virtual bool knows_moments() const { return false; }  ///< of contacts: torsion and rolling

  /// One step from x. Strong guarantee: x moves only if the report says advanced().
  /// Throws std::invalid_argument unless h > 0 is finite and x fits the model.
  [[nodiscard]] StepReport step(const Model& model, State& x, double h);

  /// The same, filling a report that is used again, so that nothing is allocated.
  void step(const Model& model, State& x, const StepRequest& request, StepReport& report);

  /// Whether this method knows the friction of all of the model's contacts.
  bool knows(const Model& model) const { return knows_moments() || model.contact_with_moments() == nullptr; }
  /// Throws std::invalid_argument naming a contact whose friction it does not know.
  void need_known_laws(const Model& model) const;

  /// What the last step of x found, for Certificate; null of methods that do not keep it. For tests.
  virtual const StepAnswer* answer() const { return nullptr; }

 protected:
  virtual void advance(const Model& model, State& x, const StepRequest& request, StepReport& report) = 0;

  /// Whether a step that was solved may stand (step/certificate/step_gain.hpp): false, and the report says why, if it gains energy from nothing.
  bool keeps_energy(const Model& model, const State& x, const StepRequest& request, const StepGain& gain,
                    StepReport& report);
  /// The same method without memory of steps before.
  virtual std::unique_ptr<Stepper> anew() const { return nullptr; }

 private:
  StepGain halved(const Model& model, const State& x, const StepRequest& request, int parts, bool& advanced);

  StepGain gain_;  // of the last step
};

}  // namespace perp
