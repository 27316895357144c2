#include "step/certificate/step_gain.hpp"

#include <algorithm>
#include <cmath>

#include "perp/core/errors.hpp"
#include "step/certificate/certificate.hpp"
#include "step/implicit/implicit_step.hpp"
#include "step/modes/modes.hpp"

namespace perp {
namespace {

constexpr double much =
    0.01;  // of the energies in the step: what an error of the method is below at a step that suits

/// What loads do along h (nu_q - (nu + nu+)/2) of the bodies that an impact changes.
double displaced(const Model& model, const Instant& start, const State& x, const State& moved,
                 const StepAnswer& answer) {
  double work = 0;
  for (std::size_t i = 0; i < answer.jumped.size(); ++i) {
    const Body& b = model.bodies()[i];
    if (answer.jumped[i] == 0) continue;
    const auto part = [&](const Vector& v) { return v.segment(b.v0, b.nv); };
    work += answer.h * part(start.k).dot(part(answer.nu_q) - 0.5 * (part(x.nu) + part(moved.nu)));
  }
  return work;
}

/// sum w p^2/2 of the step's impulses.
double energy_of_impulses(const Model& model, const Instant& start, const StepAnswer& answer) {
  double energy = 0;
  for (const std::vector<Acting>* all : {&answer.first, &answer.second})
    for (const Acting& r : *all) {
      double w = r.w;
      const ContactInstant* c = r.of == Reaction::Of::Contact ? contact_at(start, r.source) : nullptr;
      if (std::isnan(w) && c != nullptr) w = inverse_mass(model, start, c->W, law_of(*c));
      if (std::isnan(w) && r.of == Reaction::Of::JointRow)
        w = inverse_mass(model, start,
                         three_columns(start.joint_rows[static_cast<std::size_t>(r.source)].W, 0),
                         Law::Equality);
      if (!std::isnan(w)) energy += 0.5 * w * (r.p / r.lever).squaredNorm();
    }
  return energy;
}

/// Kinetic energy of bodies that move by 1e-12 of the scene's length in a step: what does so is at rest, and its energy the rounding
/// of positions (2e-16 of that length) and what a solver's tolerance leaves of it. Ten times less refuses steps of a mechanism that
/// friction has stopped; ten times more hides a gain that doubles a speed of 1e-11 lengths a step.
double energy_at_rest(const Model& model, const Instant& start, const State& x, double h) {
  constexpr double rest = 1e-12;
  const double speed = rest * scales_of(model, x, start).length / h;
  double mass = 0;
  for (const Body& b : model.bodies())
    if (b.nv > 0 && b.kind != BodyKind::Generalized) mass += b.mass;
  for (const Instant::GeneralizedMass& m : start.masses) mass += m.M.diagonal().maxCoeff();
  return 0.5 * mass * speed * speed;
}

/// What turning gained of bodies that no impulse acts on, under a scheme that keeps their angular momentum to rounding: with it the energy
/// stays between |L|^2/(2 J) of the largest and the smallest J, however large the step, so that it is an error and no gain.
double gained_by_turning(const Model& model, const Instant& start, const State& x, const State& moved,
                         const StepAnswer& answer) {
  if (answer.scheme != Scheme::Halves) return 0;
  std::vector<char> touched(model.bodies().size(), 0);
  const auto touch = [&](const auto& W) {
    touched[static_cast<std::size_t>(W.a)] = touched[static_cast<std::size_t>(W.b)] = 1;
  };
  for (const JointRowInstant& row : start.joint_rows) touch(row.W);
  for (const std::vector<Acting>* all : {&answer.first, &answer.second})
    for (const Acting& r : *all)
      if (const ContactInstant* c = r.of == Reaction::Of::Contact ? contact_at(start, r.source) : nullptr)
        touch(c->W);
  double gained = 0;
  for (std::size_t i = 0; i < model.bodies().size(); ++i) {
    const Body& b = model.bodies()[i];
    if (b.kind != BodyKind::Spatial || touched[i] != 0) continue;
    const auto turning = [&](const State& y) {
      const Vector3 w = y.nu.segment<3>(b.v0 + 3);
      return 0.5 * w.dot(b.J * w);
    };
    gained += std::max(0.0, turning(moved) - turning(x));
  }
  return gained;
}

}  // namespace

StepGain gain_of(const Model& model, const Instant& start, const State& x, const State& moved,
                 const StepAnswer& answer, double struck, const StepRequest& request, const StepReport& r) {
  const bool first_overlap =
      -start.gap_min() <= request.first_overlap && start.joint_error() <= request.first_overlap;
  StepGain gain;
  // most steps gain nothing: a comparison each
  if (r.energy_left <= 0 && struck <= 0 && (first_overlap || r.energy_overlap <= 0)) return gain;
  const double left = r.energy_left + displaced(model, start, x, moved, answer) -
                      gained_by_turning(model, start, x, moved, answer);
  const double kinetic = model.kinetic_energy(x), kinetic_after = model.kinetic_energy(moved);
  const double before = r.energy - r.energy_left - r.energy_friction - r.energy_impact - r.energy_load -
                        r.energy_motor - r.energy_surface - r.energy_overlap;
  const double height = before - kinetic, height_after = r.energy - kinetic_after;
  gain.measure = std::max(kinetic, kinetic_after) + std::abs(height_after - height) +
                 std::abs(r.energy_friction) + std::abs(r.energy_impact) + std::abs(r.energy_load) +
                 std::abs(r.energy_motor) + std::abs(r.energy_surface) + std::abs(r.energy_overlap) +
                 energy_of_impulses(model, start, answer);
  // a linearised gap overlaps by (h v)^2/(2 R); pushing that out gives (h v/R)^2/2 of the kinetic energy, which the step before took
  constexpr double curved = 0.2;  // a turn of .63 rad a step: beyond, linearised gaps are no gaps
  const double allowed = answer.scheme == Scheme::Start ? curved * gain.measure : 0;
  const double pushed = r.energy_overlap > 0 ? std::max(0.0, r.energy_overlap - allowed) : r.energy_overlap;
  gain.from_nothing = std::max(left + (first_overlap ? 0 : pushed), 0.0) + std::max(struck, 0.0);
  constexpr double rounding =
      64 * std::numeric_limits<double>::epsilon();  // of energies that are differences
  gain.from_nothing =
      std::max(0.0, gain.from_nothing - rounding * (std::abs(height) + std::abs(height_after)));
  if (gain.from_nothing > much * gain.measure)  // else nobody asks
    gain.from_nothing = std::max(0.0, gain.from_nothing - energy_at_rest(model, start, x, answer.h));
  if (!std::isfinite(left)) gain.from_nothing = left;
  return gain;
}

StepGain Stepper::halved(const Model& model, const State& x, const StepRequest& request, int parts,
                         bool& advanced) {
  const std::unique_ptr<Stepper> stepper = anew();
  StepGain sum;
  State y = x;
  StepReport report;
  StepRequest part = request;
  part.keep_energy = false;
  part.h = request.h / parts;
  for (int i = 1; i <= parts; ++i) {
    part.t_end = i == parts ? request.t_end : x.t + i * part.h;
    stepper->step(model, y, part, report);
    advanced = report.advanced();
    if (!advanced) break;
    sum.from_nothing += stepper->gain_.from_nothing;
    sum.measure = std::max(sum.measure, stepper->gain_.measure);
  }
  return sum;
}

bool Stepper::keeps_energy(const Model& model, const State& x, const StepRequest& request,
                           const StepGain& gain, StepReport& report) {
  constexpr double falls = 0.6;  // of the whole step's gain in its halves: order 1 gives 1/2
  constexpr int most_halvings = 10;
  gain_ = gain;
  if (!request.keep_energy || gain.from_nothing <= much * gain.measure) return true;
  const auto refused = [&](const std::string& why) {
    report.status = StepStatus::NotSolved;
    report.message = "the step gains " + shortest(gain.from_nothing) +
                     " J from nothing, beside energies of " + shortest(gain.measure) + " J in it" + why;
    return false;
  };
  if (!std::isfinite(gain.from_nothing)) return refused("");
  double last = gain.from_nothing;
  for (int k = 1; k <= most_halvings; ++k) {
    bool advanced = true;
    const StepGain now = halved(model, x, request, 1 << k, advanced);
    const std::string parts = std::to_string(1 << k) + " parts";
    if (!advanced) return refused("; it is not solved in " + parts);
    if (k == 1 && !(now.from_nothing <= falls * gain.from_nothing))
      return refused(", and in " + parts + " " + shortest(now.from_nothing) + " J");
    last = now.from_nothing;
    if (last <= much * std::max(now.measure, gain.measure)) return true;
  }
  return refused(", and halved ten times still " + shortest(last) + " J");
}

}  // namespace perp
