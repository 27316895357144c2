// What steppers share: the system at the start of a step, an answer, and the report that certifies it.
#pragma once

#include "perp/instant/instant.hpp"
#include "perp/instant/near_contacts.hpp"
#include "perp/step/stepper.hpp"
#include "step/certificate/step_answer.hpp"

namespace perp {

/// `evaluate` at the start of a step; the end of the last one is used again when the run goes on from there. Of many contacts only
/// those that could be reached at the speeds of the step are looked at, and a step that went further is told so.
class StartInstant {
 public:
  const Instant& at(const Model& model, const State& x, double h);
  const Instant& instant() const { return instant_; }  ///< what `at` gave last
  /// The contacts that `at` looked at, for `evaluate` at other configurations in the step; null: all.
  const std::vector<int>* near() const { return contacts_.selective() ? &near_ : nullptr; }
  /// Whether the step went so far that a contact may have been missed; `at` then looks further.
  bool widen(const Model& model, const Instant& end);
  /// The next step starts from x, of that energy, where `instant` has just been filled: takes it, giving the old one back.
  void go_on_from(const Model& model, const State& x, double energy, Instant& instant);
  /// Model::energy of the state that `at` was asked about last.
  double energy(const Model& model);

 private:
  void evaluate_near(const Model& model);

  std::uint64_t revision_ = 0;
  State x_;
  Instant instant_;
  NearContacts contacts_;
  std::vector<int> near_;
  double h_ = 0, margin_ = 0;  // at which near_ was found
  double energy_ = not_set;    // of x_
};

/// Impulses and velocities that a method found for a step, over all contacts and joints of an Instant.
struct Answer {
  Vector nu;                     ///< nu+ (nv)
  Vector impulse;                ///< W_n p_n + W_f p_f + W_b p_b + W_bf p_bf (nv)
  Eigen::Matrix3Xd p;            ///< (3, contacts): along n, t, o of each
  Eigen::Matrix3Xd moments;      ///< and about them [N m s]; no columns where no contact has moments
  Vector reactions;              ///< p_b of each joint row
  Vector joint_friction;         ///< p_bf of each joint friction
  std::vector<char> slips;       ///< of each contact
  Vector w;                      ///< of each contact: speed that a unit of p_n gives [1/kg]; NaN: not known
  double normal_residual = 0;    ///< [m/s]
  double friction_residual = 0;  ///< [m/s]
  double speed_scale = 0;  ///< largest speed that enters the step's equations, w_nn p_n among them [m/s]
  int iterations = 0;
  std::string_view solver = "none";

  void clear(const Instant& instant, const Vector& nu_free);
};

/// A report's row of contact c with impulse p along n, t, o: the only place where rows are made of impulses.
[[nodiscard]] ContactRow contact_row(const ContactInstant& c, const Vector3& p, ContactMode mode);

// A report's rows of joints: one for each coordinate, what the joint does in each of its rows.
void begin_joints(const Model& model, StepReport& report);  ///< without impulses
void add_joint_reaction(const JointRowInstant& row, double p, StepReport& report);
void add_joint_friction(const JointRowInstant& along, double p, ContactMode mode, StepReport& report);
void end_joints(const Instant& end, const Vector& nu, StepReport& report);  ///< where the coordinates are

/// Whether contact c is closed but for rounding in a step of these speeds.
bool touches(const ContactInstant& c, double h, double speed);

/// Whether contact c, as it is at the start x of a step of these speeds, is open and meets faster than loads, which alone change
/// velocities by `gained`, make it: an impact. Its law is for all of its impulse at once: friction of an impulse in two parts, each
/// with a law of its own, need not be that of their sum, however small the step.
bool strikes(const ContactInstant& c, const State& x, const Vector& gained, double h, double speed);

/// Whether contact c, open or closed, meets that fast.
bool approaches(const ContactInstant& c, const State& x, const Vector& gained, double speed);

/// Whether contact c opens at x, faster than loads could close it again in a step or two: it has no part in the impact of another
/// contact. To hold it at u_n+ >= 0 beside restitution there would add energy, p_n u_n-/2.
bool separates(const ContactInstant& c, const State& x, const Vector& gained, double speed);

/// Solver, gaps and joints at the end, contact rows for `active`, joint rows.
void record(const Model& model, const Instant& start, const Answer& answer, std::span<const int> active,
            const Instant& end, StepReport& report);

/// The answer's impulses as the certificate reads them, with the gap terms of their laws.
void list_impulses(const Model& model, const Instant& start, const Answer& answer,
                   std::span<const int> active, const Vector& gap_term, std::vector<Acting>& all);

}  // namespace perp
