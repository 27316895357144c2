#include "perp/step/methods.hpp"

#include "perp/core/errors.hpp"
#include "perp/step/extrapolated.hpp"
#include "perp/step/lcp_stepper.hpp"
#include "perp/step/ncp2_stepper.hpp"

namespace perp {

const std::vector<Method>& methods() {
  static const std::vector<Method> all = {
      {"lcp", 1, false, true, "the 2003 time-stepping LCP: linearised gaps, polygonal friction",
       [](const MethodOptions& o) -> std::unique_ptr<Stepper> {
         return std::make_unique<LcpStepper>(LcpStepperOptions{.edges = o.edges, .reactions = o.reactions});
       }},
      {"lcp-ap", 1, false, true, "Anitescu and Potra's LCP: velocity-level gaps, a solution always exists",
       [](const MethodOptions& o) -> std::unique_ptr<Stepper> {
         return std::make_unique<LcpStepper>(
             LcpStepperOptions{.edges = o.edges, .anitescu_potra = true, .reactions = o.reactions});
       }},
      {"ncp", 1, false, false,
       "the fully implicit step: nonlinear gaps, circular cones, everything at the end",
       [](const MethodOptions& o) -> std::unique_ptr<Stepper> {
         return std::make_unique<NcpStepper>(NcpStepperOptions{.reactions = o.reactions});
       }},
      {"ncp-start", 1, false, false, "nonlinear gaps and circular cones, directions of impulses at the start",
       [](const MethodOptions& o) -> std::unique_ptr<Stepper> {
         return std::make_unique<NcpStepper>(
             NcpStepperOptions{.directions = Directions::Start, .reactions = o.reactions});
       }},
      {"ncp2", 2, false, false, "second order: a nonsmooth RATTLE with circular cones",
       [](const MethodOptions& o) -> std::unique_ptr<Stepper> {
         return std::make_unique<Ncp2Stepper>(Ncp2StepperOptions{.reactions = o.reactions});
       }},
      {"event", 0, true, false,
       "the instantaneous model integrated by SUNDIALS to a tolerance, events located",
       [](const MethodOptions& o) -> std::unique_ptr<Stepper> {
         return std::make_unique<EventDriven>(EventDrivenOptions{
             .rtol = o.tolerance, .integrator = o.integrator, .impacts = o.impacts, .look = o.look});
       }},
      {"extrapolated", 0, true, false,
       "contact steps extrapolated to order 4, 6, 8 or a tolerance, events located",
       [](const MethodOptions& o) -> std::unique_ptr<Stepper> {
         return std::make_unique<Extrapolated>(ExtrapolatedOptions{
             .order = o.order, .rtol = o.tolerance, .impacts = o.impacts, .look = o.look});
       }},
      {"penalty", 1, false, false,
       "the compared other: springs and dampers for contacts, friction regularised; k and slip speed of its "
       "own",
       [](const MethodOptions& o) -> std::unique_ptr<Stepper> {
         return std::make_unique<PenaltyStepper>(o.penalty);
       }},
  };
  return all;
}

void MethodOptions::set(std::string_view method, std::string_view key, double value) {
  if (method != "penalty")
    refuse("method " + std::string(method), "setting", key, "needs the method penalty: others have none");
  if (key == "stiffness")
    penalty.stiffness = value;
  else if (key == "damping")
    penalty.damping = value;
  else if (key == "slip_speed")
    penalty.slip_speed = value;
  else if (key == "explicit" && (value == 0 || value == 1))
    penalty.explicit_forces = value == 1;
  else if (key == "explicit")
    refuse("method penalty", "explicit", value, "needs to be 0 or 1");
  else
    refuse("method penalty", "setting", key, "needs to be stiffness, damping, slip_speed or explicit");
  (void)PenaltyStepper(penalty);  // refuses values that it cannot take
}

const Method& method(std::string_view name) {
  std::string known;
  for (const Method& m : methods()) {
    if (m.name == name) return m;
    known.append(known.empty() ? "" : ", ").append(m.name);
  }
  refuse("method", "name", name, "needs to be one of: " + known);
}

std::unique_ptr<Stepper> make_stepper(std::string_view name, const MethodOptions& options) {
  return method(name).make(options);
}

}  // namespace perp
