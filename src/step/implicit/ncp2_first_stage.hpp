// The first stage of ncp2: where the step leads, and what it costs.
#pragma once

#include "step/implicit/implicit_step.hpp"

namespace perp {

/// Loads without gyroscopic terms at (q, nu, t); `s` holds those of another nu. Where they do not vary they cost nothing.
void loads_at(const Model& model, const Instant& s, State& at_nu, Instant& scratch, Vector& f);

/// T(nu) y for h: a spatial body's angular part turned by exp(-h w/2).
void carry(const Model& model, const Vector& nu, double h, Vector& y);

/// The first stage in nu_½ and p_1. Its momentum equation is used as
///   T(nu_½)^-1 M nu_½ - M nu_l - h/2 f(q_l, nu_½) = W(q_l) p_1.
class FirstStage final : public StepProblem {
 public:
  FirstStage(const Model& model, const Instant& start, const std::vector<int>* near, const State& x,
             const StepRequest& request, Instant& end, Instant& scratch, ContactDerivatives& geometry);

  bool evaluate(const Vector& nu, std::span<Reaction> reactions, Vector& R) override;
  void differentiate(std::span<Reaction> reactions, std::vector<Coupling>& K) override;

  const State& moved() const { return moved_; }

  /// M nu_l + h/2 f(q_l, nu_½, t_l) + W(q_l) p_1 at the guess evaluated last: T(nu_½)^-1 M nu_½ without Newton's residual.
  void kick(const std::vector<Reaction>& reactions, Vector& y) const;

 private:
  void place(const Vector& nu, Reaction& r) const;
  void slopes(const Motion& motion, Reaction& r) const;
  void moment_slopes(const Motion& motion, Reaction& r) const;

  const Model& model_;
  const Instant& start_;
  const std::vector<int>* near_;  // contacts to look at
  const State& x_;
  const StepRequest& request_;
  Instant &end_, &scratch_;
  ContactDerivatives& geometry_;
  State moved_, half_;
  Vector momentum_, load_;
  std::vector<LoadDerivative> loads_;
  std::vector<int> active_;
};

}  // namespace perp
