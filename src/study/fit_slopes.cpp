// Slopes of a fit's residuals from the sensitivities of one run.
#include <algorithm>
#include <cmath>

#include "perp/step/sensitivity.hpp"
#include "perp/step/simulate.hpp"
#include "study/fit_runs.hpp"

namespace perp {
namespace {

bool moves_the_model(UnknownKind kind) {
  return kind == UnknownKind::Parameter || kind == UnknownKind::Coordinate || kind == UnknownKind::Rate ||
         kind == UnknownKind::Rotation || kind == UnknownKind::Spin;
}

/// A run's states and their derivatives, between which all goes straight: a slope's error is of the order of h^2.
struct SlopedRun {
  std::vector<State> x;
  std::vector<StateDerivative> slope;

  /// The state at t, moved by d along column j (not at all if j < 0); before the start as the start moves.
  State at(const Model& model, double t, Eigen::Index j, double d) const {
    const auto after = std::upper_bound(x.begin() + 1, x.end() - 1, t,
                                        [](double time, const State& y) { return time < y.t; });
    const auto b = static_cast<std::size_t>(after - x.begin()), a = b - 1;
    const double length = x[b].t - x[a].t, share = length > 0 ? std::max(0.0, (t - x[a].t) / length) : 1;
    State y = x[a];
    y.q += share * (x[b].q - x[a].q);
    y.nu += share * (x[b].nu - x[a].nu);
    if (j >= 0) {
      y.q += d * ((1 - share) * slope[a].q.col(j) + share * slope[b].q.col(j));
      y.nu += d * ((1 - share) * slope[a].nu.col(j) + share * slope[b].nu.col(j));
    }
    if (t < x.front().t) move(model, y.nu, t - x.front().t, y.q);
    return y;
  }
};

}  // namespace

std::optional<Matrix> FitRuns::slopes(const Unknowns& unknowns, const Vector& theta,
                                      const std::vector<int>& which, int motion, const Vector& r) {
  const auto m = static_cast<std::size_t>(motion);
  const std::string& method = problem_.method;
  const bool known = method == "ncp" || method == "ncp-start" || method == "ncp2" || method == "event";
  const std::optional<Scene> here = scene(unknowns, theta);
  if (rough_[m] != 0 || !known || !here || !here->events.empty() || r.size() == 0) return std::nullopt;

  std::vector<int> moving;
  for (const int i : which)
    if (moves_the_model(unknowns[i].kind)) moving.push_back(i);
  const auto count = static_cast<Eigen::Index>(moving.size());
  Vector phi(count), scale(count);
  for (Eigen::Index k = 0; k < count; ++k) {
    phi[k] = theta[moving[static_cast<std::size_t>(k)]];
    scale[k] = unknowns[moving[static_cast<std::size_t>(k)]].scale;
  }
  const ParametricModel model = [&](const Vector& at) {
    Vector there = theta;
    for (Eigen::Index k = 0; k < count; ++k) there[moving[static_cast<std::size_t>(k)]] = at[k];
    Scene s = problem_.scene(unknowns.parameters(problem_.set, there));
    State start = unknowns.start(s, motion, there);
    return ModelAtStart{std::move(s.model), std::move(start)};
  };
  const Recording recording = unknowns.recording(motion, theta);
  const std::vector<MeasuredCell>& all = cells(motion);
  const std::vector<double>& clock = this->motion(motion).t;
  const auto time = [&](const Recording& by, const MeasuredCell& cell) {
    return by.offset + by.rate * clock[static_cast<std::size_t>(cell.row)];
  };
  const double last = time(recording, all[static_cast<std::size_t>(r.size() - 1)]);

  SlopedRun run;
  try {
    const ModelAtStart at = model(phi);
    const double rounding = 1e-12 * std::max(1e-3, at.start.q.cwiseAbs().maxCoeff());
    if (!(last > at.start.t) || overlap(at.model, at.start) > rounding) return std::nullopt;
    const std::unique_ptr<Stepper> stepper = make_stepper(method, problem_.options);
    ++runs_;
    const Sensitivity s = sensitivity(model, phi, *stepper,
                                      {.t_end = last,
                                       .h = method == "event" ? not_set : std::min(h_, last - at.start.t),
                                       .scale = scale,
                                       .each = [&](const State& x, const StateDerivative& by) {
                                         run.x.push_back(x);
                                         run.slope.push_back(by);
                                       }});
    if (!s.exists() || (s.impacts > 0 && method != "event")) {
      rough_[m] = 1;
      return std::nullopt;
    }
  } catch (const StepFailure&) {
    return std::nullopt;
  } catch (
      const std::
          invalid_argument&) {  // a neighbour that the scene refuses, or a contact that has no derivative
    return std::nullopt;
  }
  if (run.x.size() < 2) return std::nullopt;

  Matrix J(r.size(), static_cast<Eigen::Index>(which.size()));
  std::vector<double> row, plus, minus;
  Eigen::Index moved = 0;
  for (std::size_t k = 0; k < which.size(); ++k) {
    const int i = which[k];
    const Eigen::Index column = moves_the_model(unknowns[i].kind) ? moved++ : -1;
    const double d = 1e-5 * unknowns[i].scale;
    Vector there = theta;
    there[i] = theta[i] + d;
    const Recording up = unknowns.recording(motion, there);
    there[i] = theta[i] - d;
    const Recording down = unknowns.recording(motion, there);
    for (Eigen::Index c = 0; c < r.size(); ++c) {
      const MeasuredCell& cell = all[static_cast<std::size_t>(c)];
      const auto place = static_cast<std::size_t>(cell.place);
      recorded_row(here->model, up, run.at(here->model, time(up, cell), column, d), plus);
      recorded_row(here->model, down, run.at(here->model, time(down, cell), column, -d), minus);
      recorded_row(here->model, recording, run.at(here->model, time(recording, cell), -1, 0), row);
      // q and -q are one rotation: the residual says which was taken
      const double value = r[c] + cell.value;
      const double sign = std::abs(value - row[place]) <= std::abs(value + row[place]) ? 1 : -1;
      J(c, static_cast<Eigen::Index>(k)) = sign * (plus[place] - minus[place]) / (2 * d);
    }
  }
  return J;
}

}  // namespace perp
