// Where the energy of a step goes: works of its impulses and loads, each at the velocity at which its law is posed.
#pragma once

#include "perp/step/stepper.hpp"
#include "step/certificate/step_answer.hpp"

namespace perp {

/// What prescribed bodies do through springs [W].
[[nodiscard]] double power_of_moving_springs(const Model& model, const Instant& s);

/// Sums of work over a step. Regular bodies' works are those at nu_q, the velocity that moves q; a body that an impact within the step
/// changes has all of its works at (nu + nu+)/2, where they are its change of kinetic energy. doc/certificate.md has the list.
class StepEnergy {
 public:
  /// `nu` is a workspace.
  StepEnergy(const Model& model, const Instant& start, const State& x, const Instant& end, const State& moved,
             const StepAnswer& answer, Vector& nu);

  template <int C>
  bool strikes(const WrenchMap<C>& W) const {
    const std::vector<char>& struck = answer_.jumped;
    if (struck.empty()) return false;
    return (W.na > 0 && struck[static_cast<std::size_t>(W.a)] != 0) ||
           (W.nb > 0 && struck[static_cast<std::size_t>(W.b)] != 0);
  }

  void contact(const ContactInstant& c, const Vector3& p, const Vector3& u);     ///< u: that of its law
  void moments(const MomentInstant& m, const Vector3& p, const Vector3& omega);  ///< p [N m s]; of its law
  void joint_row(const JointRowInstant& row, const Acting& r);  ///< `row` where its impulse acts
  void joint_friction(const JointRowInstant& row, double p, double u);

  // over h, with the loads of an instant
  void loads(const Instant& s, double h);
  void moving_springs(const Instant& s, double h) { surface_ += h * power_of_moving_springs(model_, s); }
  void generalized(const Instant& s, double h);  ///< what of their forces has no potential

  /// Work of all impulses on bodies that an impact changes: they only take.
  double struck() const { return struck_; }

  /// The sums, and what they leave of `gained`.
  void fill(double gained, StepReport& report) const;

 private:
  void struck_contact(const ContactInstant& c, const Vector3& p);
  void tangential(const ContactInstant& c, const Vector3& p, const Vector3& u);

  const Model& model_;
  const Instant &start_, &end_;
  const State &x_, &moved_;
  const StepAnswer& answer_;
  const Vector* nu_;  // of works that are not at their law's velocity
  double friction_ = 0, impact_ = 0, load_ = 0, motor_ = 0, surface_ = 0, overlap_ = 0, struck_ = 0;
};

}  // namespace perp
