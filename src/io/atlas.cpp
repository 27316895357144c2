#include "perp/io/atlas.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <memory>
#include <optional>

#include "instant/scales.hpp"
#include "perp/core/errors.hpp"
#include "perp/instant/instant.hpp"
#include "perp/io/scene_file.hpp"
#include "perp/step/methods.hpp"
#include "perp/step/simulate.hpp"
#include "perp/study/error_measure.hpp"

namespace perp {
namespace {

constexpr double off = 1e-2;          // of how far the motion goes
constexpr double deep = 1e-2;         // of the scene's length
constexpr double from_nothing = 0.1;  // of the largest energy
constexpr double tolerance = 1e-8;    // rtol of event
constexpr double rest = 1e-6;         // of the largest speed: slower contacts stick
constexpr double jump = 10;           // times what loads change in a step

bool names_setting(const std::string& name) {
  return name == "stiffness" || name == "damping" || name == "slip_speed";
}

/// A place of the map as a scene and a step.
struct Place {
  Scene scene;
  double T = 0, h = 0;
  MethodOptions options = {.tolerance = tolerance};
};

Place place_of(const AtlasRequest& request, const std::string& method, double a, double b) {
  SceneParameters set(request.set.begin(), request.set.end());
  std::map<std::string, double> settings = request.set_method;
  double h = request.step;
  for (const auto& [name, value] : {std::pair{request.a.name, a}, std::pair{request.b.name, b}}) {
    if (name == "h")
      h = value;
    else if (names_setting(name))
      settings[name] = value;
    else
      set[name] = value;
  }
  Place place{.scene = load_scene(request.scene, set)};
  place.T = std::isnan(request.until) ? place.scene.t_end : request.until;
  place.h = std::isnan(h) ? (place.T - place.scene.start.t) / 100 : h;
  apply_method_settings(place.scene, method, place.options);
  for (const auto& [key, value] : settings)
    if (method == "penalty") place.options.set(method, key, value);
  return place;
}

/// The state at T that is right, where it is known.
std::optional<State> right_end(const Place& place) {
  const Scene& s = place.scene;
  if (s.exact) {
    State x = s.exact(place.T);
    if (x.q.allFinite() && x.nu.allFinite()) return x;
  }
  EventDriven event({.rtol = tolerance, .max_evaluations = 200'000});
  try {
    return simulate(s.model, event, s.start, {.t_end = place.T}).back();
  } catch (const StepFailure&) {
    return std::nullopt;
  }
}

/// Energy that a run has beyond that of its start and of loads, motors and surfaces, step by step; and by which that is little.
struct Gained {
  std::vector<double> energy;  // [J]
  double size = 0;             // the largest that there was
};

Gained gained(const Model& model, const Trajectory& run, const Scales& scales) {
  Gained result;
  const State start = run.front();
  const double first = model.energy(start);
  double mass = 0, given = 0;
  for (const Body& b : model.bodies())
    if (b.nv > 0) mass += b.mass;
  constexpr double still = 1e-9;  // of what loads may do over the scene's length: rounding of what rests
  result.size = std::max(model.kinetic_energy(start), still * mass * scales.speed * scales.speed);
  for (std::size_t i = 0; i < run.steps(); ++i) {
    const State x = run.state(i + 1);
    const StepFigures& f = run.figures(i);
    for (const double work : {f.energy_load, f.energy_motor, f.energy_surface})
      if (std::isfinite(work)) given += std::max(0.0, work), result.size += std::abs(work);
    const double energy = model.energy(x);
    result.size = std::max({result.size, model.kinetic_energy(x), std::abs(energy - first)});
    result.energy.push_back(energy - first - given);
  }
  return result;
}

/// Whether the peaks of a list keep rising: that of its last third above that of its first.
bool keeps_rising(const std::vector<double>& values) {
  constexpr double factor = 1.5;
  const auto third = static_cast<std::ptrdiff_t>(values.size() / 3);
  if (third == 0) return false;
  return *std::max_element(values.end() - third, values.end()) >
         factor * std::max(0.0, *std::max_element(values.begin(), values.begin() + third));
}

/// What is absurd of a run that says it is solved; empty if nothing is.
std::string absurd(const Place& place, const Trajectory& run) {
  const Model& model = place.scene.model;
  Instant s;
  evaluate(model, run.front(), s);
  const Scales scales = scales_of(model, run.front(), s);
  const double open = s.joint_error(), lowest = std::min(0.0, s.gap_min()) - deep * scales.length;
  for (std::size_t i = 0; i < run.steps(); ++i) {
    const State x = run.state(i + 1);
    const StepFigures& f = run.figures(i);
    if (!x.q.allFinite() || !x.nu.allFinite()) return "a state that is no number";
    if (f.gap_min < lowest) return "an overlap of " + shortest(-f.gap_min) + " m";
    if (f.joint_error > open + deep * scales.length) return "a joint open by " + shortest(f.joint_error);
  }
  const Gained all = gained(model, run, scales);
  if (all.energy.empty()) return {};
  const double most = *std::max_element(all.energy.begin(), all.energy.end());
  // a spring that a step of first order follows swings about its energy, the more the nearer it is to its bound
  const bool springs = !model.springs().empty();
  if (most > from_nothing * all.size && (!springs || keeps_rising(all.energy)))
    return "energy from nothing: " + shortest(most) + " J";
  return {};
}

/// Whether the first step changed velocities as no load can, of a system that touches and does not come together.
bool jumped(const Place& place, const Trajectory& run) {
  if (run.steps() == 0) return false;
  const Model& model = place.scene.model;
  Instant s;
  evaluate(model, run.front(), s);
  const Scales scales = scales_of(model, run.front(), s);
  for (const ContactInstant& c : s.contacts)
    if (c.psi_n <= scales.small_gap() && c.velocity(run.front().nu).x() < -scales.small_speed()) return false;
  const double change = (run.state(1).nu - run.state(0).nu).lpNorm<Eigen::Infinity>();
  const double step = run.t(1) - run.t(0);
  return change > jump * step * scales.acceleration && change > deep * scales.speed;
}

AtlasOutcome outcome_of(const Place& place, const Trajectory& run, bool grows) {
  if (grows) return AtlasOutcome::Grows;
  if (jumped(place, run)) return AtlasOutcome::Jumps;
  const Model& model = place.scene.model;
  const State end = run.back();
  Instant s;
  evaluate(model, end, s);
  Scales scales;
  for (const std::size_t i : {std::size_t{0}, run.size() / 2, run.size() - 1}) {
    Instant now;
    evaluate(model, run.state(i), now);
    scales.widen(scales_of(model, run.state(i), now));
  }
  bool closed = false;
  for (const ContactInstant& c : s.contacts) {
    if (c.psi_n > deep * deep * scales.length) continue;
    closed = true;
    if (c.tangents > 0 && c.velocity(end.nu).tail<2>().norm() > rest * scales.speed)
      return AtlasOutcome::Slides;
  }
  for (const JointRowInstant& row : s.joint_frictions) {
    closed = true;
    if (std::abs(row.velocity(end.nu)) > rest * scales.speed) return AtlasOutcome::Slides;
  }
  return closed ? AtlasOutcome::Sticks : AtlasOutcome::Bounded;
}

}  // namespace

double AtlasAxis::value(int i) const {
  if (count < 2) return low;
  const double share = double(i) / (count - 1);
  return geometric() ? low * std::pow(high / low, share) : low + share * (high - low);
}

AtlasAxis read_axis(const std::string& text, const std::string& option) {
  const auto bad = [&]() {
    refuse("perp study", option, text, "needs to be NAME=LO:HI:N, LO below HI and N of 2 or more");
  };
  AtlasAxis axis;
  const std::size_t equals = text.find('=');
  if (equals == 0 || equals == std::string::npos) bad();
  axis.name = text.substr(0, equals);
  const char* at = text.data() + equals + 1;
  const char* const end = text.data() + text.size();
  for (double* value : {&axis.low, &axis.high}) {
    const auto read = std::from_chars(at, end, *value);
    if (read.ec != std::errc() || read.ptr == end || *read.ptr != ':') bad();
    at = read.ptr + 1;
  }
  const auto read = std::from_chars(at, end, axis.count);
  if (read.ec != std::errc() || read.ptr != end || !(axis.low < axis.high) || axis.count < 2 ||
      axis.count > 10000 || !std::isfinite(axis.low) || !std::isfinite(axis.high))
    bad();
  return axis;
}

std::string_view name_of(AtlasVerdict verdict) {
  constexpr std::array<std::string_view, 4> names{"right", "off", "said-so", "silent"};
  return names[static_cast<std::size_t>(verdict)];
}

std::string_view name_of(AtlasOutcome outcome) {
  constexpr std::array<std::string_view, 6> names{"unknown", "sticks", "slides", "jumps", "bounded", "grows"};
  return names[static_cast<std::size_t>(outcome)];
}

AtlasCell atlas_cell(const AtlasRequest& request, const std::string& method_name, double a, double b) {
  AtlasCell cell{.method = method_name, .a = a, .b = b};
  const Place place = place_of(request, method_name, a, b);
  const Scene& s = place.scene;
  const auto stepper = make_stepper(method_name, place.options);
  Trajectory run;
  try {
    run = simulate(s.model, *stepper, s.start, {.t_end = place.T, .h = place.h});
  } catch (const StepFailure& failure) {
    cell.verdict = AtlasVerdict::SaidSo;
    cell.reason = failure.what();
    if (jumped(place, failure.trajectory)) cell.outcome = AtlasOutcome::Jumps;
    return cell;
  }
  cell.reason = absurd(place, run);
  cell.outcome = outcome_of(place, run, cell.reason.starts_with("energy"));
  if (!cell.reason.empty()) {
    cell.verdict = AtlasVerdict::Silent;
    return cell;
  }
  const std::optional<State> right = right_end(place);
  if (!right) return cell;
  cell.error = configuration_error(s.model, run.back(), *right);
  double size = configuration_error(s.model, *right, s.start);
  for (std::size_t i = 0; i < run.size(); ++i)
    size = std::max(size, configuration_error(s.model, run.state(i), s.start));
  Instant start;
  evaluate(s.model, s.start, start);
  size = std::max(size, 1e-6 * scales_of(s.model, s.start, start).length);  // of what stays at rest
  if (!(cell.error <= off * size)) cell.verdict = AtlasVerdict::Off;
  return cell;
}

std::vector<AtlasCell> atlas(const AtlasRequest& request, const std::function<void(int, int)>& progress) {
  std::vector<AtlasCell> cells;
  const int all = static_cast<int>(request.methods.size()) * request.a.count * request.b.count;
  for (const std::string& method : request.methods)
    for (int j = 0; j < request.b.count; ++j)
      for (int i = 0; i < request.a.count; ++i) {
        if (progress) progress(static_cast<int>(cells.size()), all);
        cells.push_back(atlas_cell(request, method, request.a.value(i), request.b.value(j)));
      }
  return cells;
}

}  // namespace perp
