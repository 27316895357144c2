// How the end of a run changes with what the model is made of and with where it starts.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "perp/step/simulate.hpp"

namespace perp {

/// A model and where it starts.
struct ModelAtStart {
  Model model;
  State start;
};

/// The same as a function of parameters theta (m): bodies, contacts and joints as many and in the same order for all of them.
using ParametricModel = std::function<ModelAtStart(const Vector& theta)>;

/// Derivatives of a state, a column a parameter.
struct StateDerivative {
  Matrix q;   ///< (nq, m) of State::q, of quaternions those of their components
  Matrix nu;  ///< (nv, m) of State::nu
};

/// Where a derivative does not exist, or is not one of the motion alone.
struct NoDerivative {
  double t = 0;      ///< [s]
  std::string of;    ///< name of the contact point, joint or body
  std::string what;  ///< a phrase: "grazes: ..."
};

struct SensitivityOptions {
  double t_end = not_set;  ///< [s] > start.t; required
  double h = not_set;      ///< [s]; of methods of fixed steps required
  /// Besides the derivatives by theta those by the start: q ⊕ xi, nu + dnu.
  bool by_start = false;
  double max_correction_speed = infinity;  ///< as SimulateOptions has it [m/s]
  /// (m) change of each parameter that counts as one, in its unit; |theta| of it if not set, or 1 where that is 0. It is moved by 3e-6 of it.
  Vector scale = {};
  /// Called at the start and after every step (`event`: at every row) with the derivatives there.
  std::function<void(const State& x, const StateDerivative& by_parameter)> each = {};
};

struct Sensitivity {
  State end;
  StateDerivative by_parameter;
  StateDerivative by_start;  ///< 2 nv columns: nv of xi [of nu times s], nv of dnu; none unless asked for
  /// Empty where the derivative exists. Else what it says is that of the modes that the run had.
  std::vector<NoDerivative> missing;
  long steps = 0;
  long impacts = 0;  ///< steps, of `event` events, in which velocities jumped
  bool exists() const { return missing.empty(); }
};

/// The run of simulate() from model(theta).start and the derivative of its end,
///   dx(T)/dtheta,   dx(T)/dx(0).
/// `ncp`, `ncp-start`, `ncp2`: the derivative of what the steps compute, by the implicit function theorem. A step's equations
/// F(z; x, theta) = 0 in the modes of its answer z (open, held, sliding, tied to the first half's direction) give
///   F_z dz = -(F_x dx + F_theta dtheta),
/// F_z Newton's own matrix, the right-hand side a central difference of F along (dx, dtheta) at the z that is known: no step is
/// solved again. `event`: the flow of each mode, differenced over the run's own steps, and at every event
///   dx+ = J_x (dx- + f- dt) + J_theta dtheta - f+ dt,   dt = -(g_x dx- + g_theta dtheta)/(g_x f- + g_t)
/// with g that ended the mode and J the jump. doc/methods/sensitivity.md.
///
/// Throws std::invalid_argument for a method that it does not know (lcp, penalty, extrapolated, auto: differences of runs serve there),
/// for contacts with torsion, rolling or friction axes and for options that it cannot take; StepFailure as simulate() does.
[[nodiscard]] Sensitivity sensitivity(const ParametricModel& model, const Vector& theta, Stepper& stepper,
                                      const SensitivityOptions& options);

/// By the start alone.
[[nodiscard]] Sensitivity sensitivity(const Model& model, Stepper& stepper, const State& start,
                                      SensitivityOptions options);

}  // namespace perp
