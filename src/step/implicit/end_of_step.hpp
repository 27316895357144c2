// The equations of ncp: everything at the end of the step.
#pragma once

#include "perp/step/ncp_stepper.hpp"
#include "step/implicit/implicit_step.hpp"

namespace perp {

/// (25)-(38) at the end of the step, in nu+ and p.
class EndOfStep final : public StepProblem {
 public:
  EndOfStep(const Model& model, const Instant& start, const std::vector<int>* near, const State& x,
            const StepRequest& request, Directions directions, Instant& end, ContactDerivatives& geometry);

  bool evaluate(const Vector& nu, std::span<Reaction> reactions, Vector& R) override;
  void differentiate(std::span<Reaction> reactions, std::vector<Coupling>& K) override;

  const State& moved() const { return moved_; }

 private:
  bool ends() const { return directions_ == Directions::End; }
  void place(const Vector& nu, Reaction& r) const;
  void contact_slopes(const Motion& motion, Reaction& r, std::vector<Coupling>& K);
  void moment_slopes(const Motion& motion, Reaction& r, std::vector<Coupling>& K);
  void joint_slopes(const Motion& motion, Reaction& r, std::vector<Coupling>& K) const;

  const Model& model_;
  const Instant& start_;
  const std::vector<int>* near_;  // contacts to look at
  const State& x_;
  const StepRequest& request_;
  Directions directions_;
  Instant& end_;
  ContactDerivatives& geometry_;
  State moved_;
  std::vector<LoadDerivative> loads_;
  std::vector<int> active_;
};

}  // namespace perp
