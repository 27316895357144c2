// The equations of one implicit step in the modes of its answer, at a model and a start of one's choice.
#pragma once

#include <memory>

#include "step/impacts/impact_in_step.hpp"
#include "step/implicit/implicit_step.hpp"
#include "step/sensitivity/held_laws.hpp"

namespace perp {

/// What the answer says of a step, the same at all its neighbours.
struct StepModes {
  StepAnswer answer;
  StepRequest request;
  std::vector<HeldMode> first, second;
  std::vector<int> source;  ///< of each reaction of the second stage, in the first
  std::vector<char> whole;  ///< of each of the first: an impact finds all of its impulse in the second
  Rebound rebound = Rebound::Newton;
  bool two_stages() const { return answer.scheme == Scheme::Halves || !answer.struck.empty(); }
  bool strikes(const WrenchMap<3>& W) const;
};

/// One neighbour. Unknowns of the first stage are nu_q (which moves q) and p_1, of the second nu+ and p_2.
class StepSide {
 public:
  Instant end;
  std::vector<Reaction> first, second;  ///< p as they are to be differentiated at
  Vector R;                             ///< of the stage evaluated last

  /// Takes model and x, which have to outlive the next calls, and what is evaluated there. False if a point of the answer is not there.
  bool begin(const Model& model, const State& x, const StepModes& modes, const Instant& start);
  /// The same; evaluates x first, contacts' frames being those of `like`.
  bool begin_like(const Model& model, const State& x, const StepModes& modes, const Instant& like);
  /// The same where `end` has been evaluated at x.q, of other velocities.
  bool go_on(const Model& model, const State& x, const StepModes& modes);
  const Instant& start() const { return *start_; }
  /// R and u of the first stage at nu_q; false if something is not finite.
  bool evaluate_first(const Vector& nu_q);
  /// K and the reactions' slopes there.
  void differentiate_first(std::vector<Coupling>& K) { problem_->differentiate(first, K); }
  /// Places the second stage's reactions and gives R and u at nu+, p_1 and nu_q those of evaluate_first. False if a point is not there.
  bool evaluate_second(const Vector& nu_end);
  const State& moved() const;

 private:
  bool place(Reaction& r) const;
  bool place_second(std::size_t i, const Vector& nu_end);
  void momentum(Vector& out);

  Instant own_start_;
  const Instant* start_ = nullptr;
  const Model* model_ = nullptr;
  const State* x_ = nullptr;
  const StepModes* modes_ = nullptr;
  Vector nu_q_;
  Instant scratch_;
  ContactDerivatives geometry_;
  std::unique_ptr<StepProblem> problem_;
};

}  // namespace perp
