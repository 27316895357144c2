#include "perp/step/sensitivity.hpp"

#include "perp/core/errors.hpp"
#include "perp/step/event_driven.hpp"
#include "step/certificate/step_answer.hpp"
#include "step/sensitivity/event_tangent.hpp"
#include "step/sensitivity/parameters_along.hpp"

namespace perp {
namespace {

/// Columns of a tangent as the answer has them.
void give(const Model& model, const State& x, const StateTangent& tangent, Eigen::Index parameters,
          Sensitivity& out) {
  StateDerivative all = in_coordinates(model, x, tangent);
  out.end = x;
  out.by_parameter = {all.q.leftCols(parameters), all.nu.leftCols(parameters)};
  out.by_start = {all.q.rightCols(all.q.cols() - parameters), all.nu.rightCols(all.nu.cols() - parameters)};
}

/// Carries the tangent along with the steps of a run.
class TangentSink final : public RunSink {
 public:
  TangentSink(const Model& model, const Stepper& stepper, const SensitivityOptions& options, const State& x,
              ParametersAlong& along, Eigen::Index parameters, Sensitivity& out)
      : model_(model),
        stepper_(stepper),
        options_(options),
        along_(along),
        parameters_(parameters),
        out_(out),
        before_(x),
        tangent_(along.start(x)),
        step_(model) {
    tell();
  }

  void step(const State& x, const StepReport& report) override {
    ++out_.steps;
    if (!stepper_.answer()->struck.empty()) ++out_.impacts;
    alive_ = alive_ && step_.step(before_, x, report, *stepper_.answer(), options_.max_correction_speed,
                                  along_.at(before_, tangent_), tangent_, out_.missing);
    before_ = x;
    if (alive_)
      tell();
    else if (tangent_.xi.size() > 0)
      tangent_.xi.setConstant(not_set), tangent_.nu.setConstant(not_set);
  }

  void end() { give(model_, before_, tangent_, parameters_, out_); }

 private:
  void tell() {
    if (!options_.each) return;
    StateDerivative all = in_coordinates(model_, before_, tangent_);
    options_.each(before_, {all.q.leftCols(parameters_), all.nu.leftCols(parameters_)});
  }

  const Model& model_;
  const Stepper& stepper_;
  const SensitivityOptions& options_;
  ParametersAlong& along_;
  Eigen::Index parameters_;
  Sensitivity& out_;
  State before_;
  StateTangent tangent_;
  StepTangent step_;
  bool alive_ = true;
};

void need_differentiable(const Stepper& stepper, const Model& model) {
  const std::string_view name = stepper.name();
  if (name != "ncp" && name != "ncp-start" && name != "ncp2" && name != "event")
    refuse("sensitivity", "stepper", name, "needs to be one of: ncp, ncp-start, ncp2, event");
  if (const Contact* c = model.contact_with_moments(); c != nullptr)
    refuse("sensitivity", "model", c->name,
           "has torsion, rolling or friction axes; contacts need to be without");
}

}  // namespace

Sensitivity sensitivity(const ParametricModel& model, const Vector& theta, Stepper& stepper,
                        const SensitivityOptions& options) {
  const ModelAtStart here = model(theta);
  need_differentiable(stepper, here.model);
  here.model.check("sensitivity", here.start);
  State x = here.start;
  here.model.follow_turns(x);
  ParametersAlong along(model, theta, options.scale, here.model,
                        options.by_start ? Eigen::Index{2} * here.model.nv() : 0);
  Sensitivity out;
  if (const auto* event = dynamic_cast<EventDriven*>(&stepper)) {
    StateTangent tangent = along.start(x);
    const State end = carry_through_events(here.model, *event, x, options, along, theta.size(), tangent, out);
    give(here.model, end, tangent, theta.size(), out);
    return out;
  }
  TangentSink sink(here.model, stepper, options, x, along, theta.size(), out);
  (void)simulate(
      here.model, stepper, x,
      {.t_end = options.t_end, .h = options.h, .max_correction_speed = options.max_correction_speed}, sink);
  sink.end();
  return out;
}

Sensitivity sensitivity(const Model& model, Stepper& stepper, const State& start,
                        SensitivityOptions options) {
  options.by_start = true;
  return sensitivity([&](const Vector&) { return ModelAtStart{model, start}; }, Vector(), stepper, options);
}

}  // namespace perp
