// The methods by name: what `perp methods` lists and `--method` takes.
#pragma once

#include <memory>
#include <string_view>
#include <vector>

#include "perp/solve/friction_solver.hpp"
#include "perp/step/event_driven.hpp"
#include "perp/step/penalty_stepper.hpp"

namespace perp {

/// What may be chosen for a method from outside; each uses what concerns it.
struct MethodOptions {
  int edges = 8;                                    ///< of the friction polygon, in linear methods
  double tolerance = 1e-10;                         ///< rtol = atol of methods that choose their steps
  int order = 0;                                    ///< of `extrapolated`: ExtrapolatedOptions::order
  Integrator integrator = Integrator::Arkode;       ///< of `event`
  double look = not_set;                            ///< EventDrivenOptions::look [s], of `extrapolated` too
  ImpactOrder impacts = ImpactOrder::Simultaneous;  ///< of methods that choose their steps
  Reactions reactions = Reactions::Any;             ///< that methods with steps of fixed size report
  PenaltyOptions penalty = {};                      ///< of `penalty`

  /// The setting `key` of a method: of penalty stiffness, damping, slip_speed, explicit (0 or 1). Throws std::invalid_argument for a
  /// method without settings, another key, or a value that it cannot take.
  void set(std::string_view method, std::string_view key, double value);
};

struct Method {
  std::string_view name;
  int order;              ///< in smooth motion; 0: that of a tolerance
  bool adaptive;          ///< it chooses its steps by a tolerance: an AdaptiveStepper
  bool polygonal;         ///< whether `edges` matters to it
  std::string_view what;  ///< one phrase
  std::unique_ptr<Stepper> (*make)(const MethodOptions&);
};

/// All methods, in the order of design: linear ones first.
[[nodiscard]] const std::vector<Method>& methods();

/// The method `name`. Throws std::invalid_argument for a name that is none, listing those that are.
[[nodiscard]] const Method& method(std::string_view name);

[[nodiscard]] std::unique_ptr<Stepper> make_stepper(std::string_view name, const MethodOptions& options = {});

}  // namespace perp
