#include "study/fit_runs.hpp"

#include <algorithm>
#include <cmath>
#include <exception>
#include <map>
#include <mutex>
#include <thread>

#include "model/motion_columns.hpp"
#include "perp/core/errors.hpp"
#include "perp/step/simulate.hpp"

namespace perp {
namespace {

/// The row as the data's frame has it: p_data = scale R p + d. Velocities are as measured, not differences of positions.
void to_frame(const Model& model, const Recording& r, std::vector<double>& row) {
  const Quaternion R = rotation(r.turn);
  const auto vector = [&](std::size_t at) { return Eigen::Map<Vector3>(row.data() + at); };
  std::size_t at = 0;
  for (const Body& body : model.bodies()) switch (body.kind) {
      case BodyKind::Spatial:
      case BodyKind::Prescribed: {
        vector(at) = r.scale * (R * vector(at)) + r.shift;
        const Quaternion q = R * Quaternion(row[at + 3], row[at + 4], row[at + 5], row[at + 6]);
        row[at + 3] = q.w(), row[at + 4] = q.x(), row[at + 5] = q.y(), row[at + 6] = q.z();
        vector(at + 7) = r.scale * (R * vector(at + 7));
        vector(at + 10) = R * vector(at + 10);
        at += 13;
        break;
      }
      case BodyKind::Particle:
        vector(at) = r.scale * (R * vector(at)) + r.shift;
        vector(at + 3) = r.scale * (R * vector(at + 3));
        at += 6;
        break;
      case BodyKind::Planar: {
        const Vector3 p = r.scale * (R * Vector3(row[at], row[at + 1], 0)) + r.shift;
        const Vector3 v = r.scale * (R * Vector3(row[at + 3], row[at + 4], 0));
        row[at] = p.x(), row[at + 1] = p.y(), row[at + 2] += r.turn.z();
        row[at + 3] = v.x(), row[at + 4] = v.y();
        at += 6;
        break;
      }
      case BodyKind::Generalized:
        at += static_cast<std::size_t>(body.nq + body.nv);
        break;
      case BodyKind::Ground:
        break;
    }
}

/// The place of the first of a quaternion's four numbers, by the place of each; -1 of others.
std::vector<int> quaternions(const std::vector<std::string>& names) {
  std::vector<int> first(names.size(), -1);
  for (std::size_t i = 0; i < names.size(); ++i)
    if (names[i].ends_with(".qw"))
      for (std::size_t k = i; k < i + 4; ++k) first[k] = static_cast<int>(i);
  return first;
}

double median_interval(const std::vector<MeasuredMotion>& motions) {
  std::vector<double> all;
  for (const MeasuredMotion& motion : motions)
    for (std::size_t i = 1; i < motion.t.size(); ++i) all.push_back(motion.t[i] - motion.t[i - 1]);
  if (all.empty()) return not_set;
  std::nth_element(all.begin(), all.begin() + static_cast<std::ptrdiff_t>(all.size() / 2), all.end());
  return all[all.size() / 2];
}

constexpr double fraction_of_interval = 1.0 / 16;  // the default step: an impact is late by half of it
constexpr double penalty = 3;                      // spreads of the column that a missing cell is off by

}  // namespace

void recorded_row(const Model& model, const Recording& recording, const State& x, std::vector<double>& row) {
  motion_row(model, x, row);
  to_frame(model, recording, row);
}

FitRuns::FitRuns(const FitProblem& problem, const std::vector<MeasuredMotion>& motions, const Scene& scene)
    : problem_(problem), motions_(motions), cells_(motions.size()), h_(problem.h) {
  const std::vector<std::string> names = motion_columns(scene.model);
  rough_.assign(motions.size(), 0);
  std::map<std::string, int> column_of;
  std::vector<double> sum, squares, count;
  for (std::size_t m = 0; m < motions.size(); ++m) {
    const MeasuredMotion& motion = motions[m];
    rows_.push_back(static_cast<int>(motion.t.size()));
    std::vector<int> place, column;
    for (const std::string& name : motion.columns) {
      const auto found = std::find(names.begin(), names.end(), name);
      if (found == names.end())
        refuse("fit", "column of " + motion.name, name, "needs to be a column of the scene's trajectory.csv");
      place.push_back(static_cast<int>(found - names.begin()));
      column.push_back(column_of.emplace(name, static_cast<int>(columns_.size())).first->second);
      if (column.back() < static_cast<int>(columns_.size())) continue;
      columns_.push_back(name);
      sum.push_back(0), squares.push_back(0), count.push_back(0);
    }
    for (int k = 0; k < rows_.back(); ++k)
      for (std::size_t c = 0; c < place.size(); ++c) {
        const double value = motion.values(k, static_cast<Eigen::Index>(c));
        if (std::isnan(value)) continue;
        const auto g = static_cast<std::size_t>(column[c]);
        sum[g] += value, squares[g] += value * value, ++count[g];
        cells_[m].push_back({k, place[c], column[c], value});
      }
    if (cells_[m].empty()) refuse("fit", "measured " + motion.name, "empty", "needs a measured number");
  }
  double largest = 0;
  for (std::size_t g = 0; g < columns_.size(); ++g) {
    const double mean = sum[g] / count[g], variance = squares[g] / count[g] - mean * mean;
    spread_.push_back(std::sqrt(std::max(0.0, variance)));
    largest = std::max(largest, spread_[g]);
  }
  // a column that stays where it is has the scale of the others of its motion
  for (double& spread : spread_)
    if (!(spread > 1e-3 * largest)) spread = largest > 0 ? 1e-3 * largest : 1;
  if (std::isnan(h_)) h_ = fraction_of_interval * median_interval(motions);
}

std::optional<Scene> FitRuns::scene(const Unknowns& unknowns, const Vector& theta) const {
  try {
    return problem_.scene(unknowns.parameters(problem_.set, theta));
  } catch (const std::invalid_argument&) {
    return std::nullopt;
  }
}

std::optional<Trajectory> FitRuns::run(const Scene& scene, const State& start, double t_end) {
  ++runs_;
  State x = start;
  try {
    const double open = overlap(scene.model, x), rounding = 1e-12 * std::max(1e-3, x.q.cwiseAbs().maxCoeff());
    if (open > rounding && !project_onto_constraints(scene.model, x).reached) {
      ++failed_;
      return std::nullopt;
    }
    const std::unique_ptr<Stepper> stepper = make_stepper(problem_.method, problem_.options);
    const bool chooses = chooses_steps(*stepper);
    return simulate(
        scene.model, *stepper, x,
        {.t_end = t_end, .h = chooses ? not_set : std::min(h_, t_end - x.t), .events = scene.events});
  } catch (const StepFailure& failure) {
    ++failed_;
    return failure.trajectory.size() > 1 ? std::optional(failure.trajectory) : std::nullopt;
  } catch (const std::invalid_argument&) {
    ++failed_;
    return std::nullopt;
  }
}

void FitRuns::penalise(Residual& residual, int motion, std::size_t from) const {
  const std::vector<MeasuredCell>& all = cells(motion);
  for (std::size_t i = from; i < static_cast<std::size_t>(residual.raw.size()); ++i)
    residual.raw[static_cast<Eigen::Index>(i)] = penalty * spread(all[i].column);
  residual.failed = true;
}

Residual FitRuns::residual(const Unknowns& unknowns, const Vector& theta, const std::optional<Scene>& scene,
                           int motion) {
  const MeasuredMotion& data = this->motion(motion);
  const std::vector<MeasuredCell>& all = cells(motion);
  const int rows = limit(motion);
  const auto end = std::find_if(all.begin(), all.end(), [&](const MeasuredCell& c) { return c.row >= rows; });
  Residual residual{.raw = Vector::Zero(end - all.begin())};
  if (residual.raw.size() == 0) return residual;
  if (!scene) {
    ++runs_, ++failed_;
    penalise(residual, motion, 0);
    return residual;
  }
  const Recording recording = unknowns.recording(motion, theta);
  const State start = unknowns.start(*scene, motion, theta);
  const double last =
      recording.offset + recording.rate * data.t[static_cast<std::size_t>(std::prev(end)->row)];
  std::optional<Trajectory> run;
  if (last > start.t) {
    run = this->run(*scene, start, last);
  } else {
    run.emplace(start, 0);
  }
  if (!run) {
    penalise(residual, motion, 0);
    return residual;
  }
  const std::vector<int> quaternion = quaternions(motion_columns(scene->model));
  std::vector<double> row;
  int filled = -1;
  for (std::size_t i = 0; i < static_cast<std::size_t>(residual.raw.size()); ++i) {
    const MeasuredCell& cell = all[i];
    if (cell.row != filled) {
      const double t = recording.offset + recording.rate * data.t[static_cast<std::size_t>(cell.row)];
      if (t > run->t(run->size() - 1) && cell.row != std::prev(end)->row) {
        const bool ended = !run->stopped_by.empty();
        if (!ended) {
          penalise(residual, motion, i);
          return residual;
        }
      }
      State x = run->front();
      if (t > x.t)
        x = run->size() > 1 ? run->at(std::min(t, run->t(run->size() - 1))) : x;
      else
        move(scene->model, x.nu, t - x.t, x.q);  // before the start: as it moves there
      recorded_row(scene->model, recording, x, row);
      filled = cell.row;
    }
    double value = row[static_cast<std::size_t>(cell.place)];
    const int first = quaternion[static_cast<std::size_t>(cell.place)];
    if (first >= 0) {  // q and -q are one rotation: the sign by all that was measured of it in this row
      double product = 0;
      for (std::size_t k = i; k < all.size() && all[k].row == cell.row; ++k)
        if (quaternion[static_cast<std::size_t>(all[k].place)] == first)
          product += all[k].value * row[static_cast<std::size_t>(all[k].place)];
      for (std::size_t k = i; k-- > 0 && all[k].row == cell.row;)
        if (quaternion[static_cast<std::size_t>(all[k].place)] == first)
          product += all[k].value * row[static_cast<std::size_t>(all[k].place)];
      if (product < 0) value = -value;
    }
    residual.raw[static_cast<Eigen::Index>(i)] = value - cell.value;
  }
  return residual;
}

int FitRuns::rows_before_contact(const Unknowns& unknowns, const Vector& theta, const Scene& scene,
                                 int motion) {
  const MeasuredMotion& data = this->motion(motion);
  const Recording recording = unknowns.recording(motion, theta);
  const State start = unknowns.start(scene, motion, theta);
  const double last = recording.offset + recording.rate * data.t.back();
  if (!(last > start.t)) return 0;
  const std::optional<Trajectory> run = this->run(scene, start, last);
  if (!run) return 0;
  for (std::size_t i = 0; i < run->steps(); ++i) {
    const StepReport report = run->report(i);
    const bool closed = std::any_of(report.contacts.begin(), report.contacts.end(),
                                    [](const ContactRow& c) { return c.mode != ContactMode::Open; });
    if (!closed) continue;
    const auto before = std::count_if(data.t.begin(), data.t.end(), [&](double t) {
      return recording.offset + recording.rate * t < run->t(i);
    });
    return i == 0 ? 0 : static_cast<int>(before);
  }
  return static_cast<int>(data.t.size());
}

void FitRuns::each(int n, const std::function<void(int)>& work) const {
  std::atomic<int> next = 0;
  std::exception_ptr error;
  std::mutex mutex;
  const auto loop = [&] {
    for (int i; (i = next++) < n;) {
      try {
        work(i);
      } catch (...) {
        const std::lock_guard lock(mutex);
        if (!error) error = std::current_exception();
        next = n;
      }
    }
  };
  std::vector<std::thread> others;
  for (int k = 1; k < std::min(problem_.jobs, n); ++k) others.emplace_back(loop);
  loop();
  for (std::thread& thread : others) thread.join();
  if (error) std::rethrow_exception(error);
}

}  // namespace perp
