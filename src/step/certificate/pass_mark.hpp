// What a step's answer is measured against: speeds that the answer has no part in.
#pragma once

#include "perp/instant/islands.hpp"
#include "step/implicit/step_problem.hpp"

namespace perp {

/// Speeds of a step from x over [t, t + h], as velocities [m/s]; of a generalized body those of its own coordinates:
///   of bodies        eps |position|/h, √(nuᵀ M nu/m) at the start, and of what loads give, nu := h M^-1 k, at t and, q and nu as they are, at t + h
///   of reactions     |u| at the start and what loads give of it, explicit velocities (prescribed bodies, surfaces, driven joints) at t and
///                    t + h, and those that bring an overlap or an open joint of the start to zero within h
/// A step's island (bodies tied by its reactions) is measured by the largest of its bodies and reactions: nothing in it is of the
/// answer, so that no answer can buy its pass.
class StepSpeeds {
 public:
  /// `s` is the system at x, and stays; `gained` = h M^-1 k there; `near` as in evaluate.
  void begin(const Model& model, const Instant& s, const State& x, const Vector& gained, double h,
             double t_end, double max_correction_speed, const std::vector<int>* near);

  double of_body(std::size_t i) const { return body_[i]; }
  /// What an island's residuals are measured by, and the largest rounding of psi/h in it [m/s].
  struct Mark {
    double speed = 0, rounding = 0;
  };
  /// `lengths`, if any, gets that of each contact, joint row and joint friction of the island, in this order.
  Mark of(const Instant& s, const Island& island, std::vector<double>* lengths = nullptr) const;

  /// Sets what the reaction brings: its length, its rounding, its speed. Of a point that the start does not have, `c` is as a
  /// trial found it.
  void measure(Reaction& r, const ContactInstant* c = nullptr) const;
  /// The same of a contact's moments, whose lever is set.
  void measure_moments(Reaction& r, const MomentInstant& m) const;
  double lever_of(const ContactInstant& c, const MomentInstant& m) const;

 private:
  double of(const ContactInstant& c) const;
  double of(const JointRowInstant& row, double length) const;

  const Model* model_ = nullptr;
  const Instant* start_ = nullptr;
  const State* x_ = nullptr;
  double h_ = 0, cap_ = infinity;
  Vector gained_, scratch_;
  std::vector<double> body_;
  bool varies_ = false;  // with t
  Instant later_;        // at t + h, q and nu of the start
};

/// Metres that a unit of u is worth: 1, or for angles the radius at which the lighter body's mass would have the row's inertia.
double metres_per_unit(const Model& model, const Instant& s, const Reaction& r);

/// How far a body's positions are from zero [m]; of one that turns there, its radius of gyration.
double reach_of(const Body& b, const State& x);

/// √(yᵀ M y/m) of a body [m/s], largest entry of a generalized one; y = M^-1 f.
double speed_of(const Body& b, const Vector& f, const Vector& y);

}  // namespace perp
