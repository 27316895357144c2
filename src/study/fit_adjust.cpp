#include "study/fit_adjust.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "study/derivative_free.hpp"

namespace perp {
namespace {

constexpr double sigma_first = 0.02;  // of a column's spread, before anything is known of its scatter
constexpr double sigma_least = 1e-8;  // of its spread: data that a run made scatter by the solver's tolerance
constexpr double far = 3;  // sigmas, from which a residual counts by its size, not its square [Huber64]
constexpr int fewest_rows = 5;

double rho(double r) { return std::abs(r) < far ? r * r : far * (2 * std::abs(r) - far); }

}  // namespace

double FitAdjuster::weight(double r) { return std::abs(r) < far ? 1 : far / std::abs(r); }

FitAdjuster::FitAdjuster(const FitProblem& problem, FitRuns& runs, Unknowns& unknowns, int last_rows)
    : problem_(problem), runs_(runs), unknowns_(unknowns) {
  const int n = unknowns.size();
  theta_.resize(n);
  precision_ = Vector::Zero(n);
  for (int i = 0; i < n; ++i) theta_[i] = unknowns[i].guess;
  sigma_.resize(static_cast<Eigen::Index>(runs.columns().size()));
  for (Eigen::Index c = 0; c < sigma_.size(); ++c) sigma_[c] = sigma_first * runs.spread(static_cast<int>(c));
  for (int m = 0; m < runs.motions(); ++m) {
    whole_.push_back(static_cast<int>(runs.motion(m).t.size()) - (runs.motions() == 1 ? last_rows : 0));
    runs.limit(m, whole_.back());
  }
}

/// The border of what the scene accepts, between an accepted value and one that is not.
void FitAdjuster::find_bounds() {
  const auto accepted = [&](int i, double value) {
    Vector theta = theta_;
    theta[i] = value;
    return runs_.scene(unknowns_, theta).has_value();
  };
  for (int i = 0; i < unknowns_.size(); ++i) {
    Unknown& u = unknowns_[i];
    if (u.kind != UnknownKind::Parameter || !accepted(i, u.guess)) continue;
    constexpr double reach = 100;  // scales, as far as a parameter is looked for
    for (const double side : {-1.0, 1.0}) {
      double& bound = side < 0 ? u.low : u.high;
      double inside = u.guess, outside = std::isfinite(bound) ? bound : u.guess + side * reach * u.scale;
      if (accepted(i, outside)) continue;
      constexpr int halvings = 50;
      for (int k = 0; k < halvings; ++k) {
        const double middle = 0.5 * (inside + outside);
        (accepted(i, middle) ? inside : outside) = middle;
      }
      constexpr double digits = 1e9;  // a border is a round number: 1, not 0.99999999999
      const double round = std::round(inside / u.scale * digits) / digits * u.scale;
      if (accepted(i, round)) inside = round;
      bound = inside;
    }
  }
}

std::vector<Residual> FitAdjuster::residuals(const Vector& theta) {
  const std::optional<Scene> scene = runs_.scene(unknowns_, theta);
  std::vector<Residual> all(static_cast<std::size_t>(runs_.motions()));
  runs_.each(runs_.motions(),
             [&](int m) { all[static_cast<std::size_t>(m)] = runs_.residual(unknowns_, theta, scene, m); });
  return all;
}

double FitAdjuster::cost(const Vector& theta) {
  double sum = 0;
  const std::vector<Residual> all = residuals(theta);
  for (int m = 0; m < runs_.motions(); ++m) {
    const Vector& raw = all[static_cast<std::size_t>(m)].raw;
    for (Eigen::Index i = 0; i < raw.size(); ++i)
      sum += 0.5 * rho(raw[i] / sigma_[runs_.cells(m)[static_cast<std::size_t>(i)].column]);
  }
  return sum;
}

long FitAdjuster::cells() const {
  long n = 0;
  for (int m = 0; m < runs_.motions(); ++m)
    n += std::count_if(runs_.cells(m).begin(), runs_.cells(m).end(),
                       [&](const MeasuredCell& c) { return c.row < runs_.limit(m); });
  return n;
}

/// A difference over which residuals change by about a third of what scatter hides, so that steps of fixed size, whose impacts are
/// late by a part of a step, do not decide on slopes.
double FitAdjuster::difference(int i) const {
  const double scale = unknowns_[i].scale;
  if (!(precision_[i] > 0)) return 1e-3 * scale;
  return std::clamp(0.3 / precision_[i], 1e-4 * scale, 3e-2 * scale);
}

void FitAdjuster::normal_equations(const Vector& theta, const std::vector<int>& free, bool central, Matrix& H,
                                   Vector& g) {
  const int n = static_cast<int>(free.size());
  struct Task {
    int motion, k, side;  // k: in free; -1: theta itself
  };
  std::vector<Task> tasks;
  const auto moved = [&](int k, int side) {
    Vector at = theta;
    if (k < 0) return at;
    const Unknown& u = unknowns_[free[static_cast<std::size_t>(k)]];
    double& value = at[free[static_cast<std::size_t>(k)]];
    const double step = difference(free[static_cast<std::size_t>(k)]);
    const bool at_top = !central && value + step > u.high;
    value = std::clamp(value + (at_top ? -step : side * step), u.low, u.high);
    return at;
  };
  std::vector<std::vector<std::array<Vector, 2>>> found(static_cast<std::size_t>(runs_.motions()));
  const std::optional<Scene> here = runs_.scene(unknowns_, theta);
  const auto depends = [&](int m, int k) {
    const Unknown& u = unknowns_[free[static_cast<std::size_t>(k)]];
    return u.shared() || u.motion == m;
  };
  std::vector<std::optional<Matrix>> slopes(static_cast<std::size_t>(runs_.motions()));
  runs_.each(central ? 0 : runs_.motions(), [&](int m) {
    std::vector<int> which;
    for (int k = 0; k < n; ++k)
      if (depends(m, k)) which.push_back(free[static_cast<std::size_t>(k)]);
    const Vector r = runs_.residual(unknowns_, theta, here, m).raw;
    slopes[static_cast<std::size_t>(m)] = runs_.slopes(unknowns_, theta, which, m, r);
    found[static_cast<std::size_t>(m)].resize(static_cast<std::size_t>(n) + 1);
    found[static_cast<std::size_t>(m)][0][1] = r;
  });
  std::vector<std::array<std::optional<Scene>, 2>> there(static_cast<std::size_t>(n));
  for (int k = 0; k < n; ++k)
    if (unknowns_[free[static_cast<std::size_t>(k)]].kind == UnknownKind::Parameter)
      for (int side = central ? 0 : 1; side < 2; ++side)
        there[static_cast<std::size_t>(k)][static_cast<std::size_t>(side)] =
            runs_.scene(unknowns_, moved(k, 2 * side - 1));
  for (int m = 0; m < runs_.motions(); ++m) {
    found[static_cast<std::size_t>(m)].resize(static_cast<std::size_t>(n) + 1);
    if (central) tasks.push_back({m, -1, 1});
    for (int k = 0; k < n; ++k) {
      if (!depends(m, k) || slopes[static_cast<std::size_t>(m)]) continue;
      tasks.push_back({m, k, 1});
      if (central) tasks.push_back({m, k, -1});
    }
  }
  runs_.each(static_cast<int>(tasks.size()), [&](int task) {
    const Task& t = tasks[static_cast<std::size_t>(task)];
    const std::size_t side = t.side > 0 ? 1 : 0;
    const bool parameter =
        t.k >= 0 && unknowns_[free[static_cast<std::size_t>(t.k)]].kind == UnknownKind::Parameter;
    const std::optional<Scene>& scene = parameter ? there[static_cast<std::size_t>(t.k)][side] : here;
    found[static_cast<std::size_t>(t.motion)][static_cast<std::size_t>(t.k + 1)][side] =
        runs_.residual(unknowns_, moved(t.k, t.side), scene, t.motion).raw;
  });
  H = Matrix::Zero(n, n);
  g = Vector::Zero(n);
  for (int m = 0; m < runs_.motions(); ++m) {
    const auto& of_motion = found[static_cast<std::size_t>(m)];
    const Vector& r0 = of_motion[0][1];
    const std::optional<Matrix>& by_run = slopes[static_cast<std::size_t>(m)];
    std::vector<int> mine;
    for (int k = 0; k < n; ++k)
      if (by_run ? depends(m, k)
                 : of_motion[static_cast<std::size_t>(k) + 1][1].size() == r0.size() && r0.size() > 0)
        mine.push_back(k);
    Vector r(r0.size()), w(r0.size());
    for (Eigen::Index i = 0; i < r0.size(); ++i) {
      w[i] = 1 / sigma_[runs_.cells(m)[static_cast<std::size_t>(i)].column];
      r[i] = r0[i] * w[i];
      const double root = std::sqrt(weight(r[i]));
      w[i] *= root, r[i] *= root;
    }
    Matrix J(r0.size(), static_cast<Eigen::Index>(mine.size()));
    if (by_run) J = w.asDiagonal() * *by_run;
    for (std::size_t c = 0; c < mine.size() && !by_run; ++c) {
      const int i = free[static_cast<std::size_t>(mine[c])];
      const auto& pair = of_motion[static_cast<std::size_t>(mine[c]) + 1];
      const double from = central ? moved(mine[c], -1)[i] : theta[i], to = moved(mine[c], 1)[i];
      J.col(static_cast<Eigen::Index>(c)) =
          (pair[1] - (central ? pair[0] : r0)).cwiseProduct(w) / (to - from);
    }
    const Matrix JJ = J.transpose() * J;
    const Vector Jr = J.transpose() * r;
    for (std::size_t a = 0; a < mine.size(); ++a) {
      g[mine[a]] += Jr[static_cast<Eigen::Index>(a)];
      for (std::size_t b = 0; b < mine.size(); ++b)
        H(mine[a], mine[b]) += JJ(static_cast<Eigen::Index>(a), static_cast<Eigen::Index>(b));
    }
  }
  for (int k = 0; k < n; ++k) precision_[free[static_cast<std::size_t>(k)]] = std::sqrt(H(k, k));
}

std::vector<int> FitAdjuster::adjusted() const {
  std::vector<int> all;
  for (int i = 0; i < unknowns_.size(); ++i)
    if (!problem_.starts_first || unknowns_[i].shared()) all.push_back(i);
  return all;
}

Matrix FitAdjuster::hessian() {
  const std::vector<int> free = adjusted();
  Matrix H;
  Vector g;
  for (int pass = 0; pass < 2; ++pass)
    normal_equations(theta_, free, true, H, g);  // the second with the right differences
  constexpr double kept = 1e12;                  // what is kept is known, as far as the others are concerned
  Matrix all = Matrix::Zero(unknowns_.size(), unknowns_.size());
  for (int i = 0; i < unknowns_.size(); ++i) all(i, i) = kept / (unknowns_[i].scale * unknowns_[i].scale);
  all(free, free) = H;
  return all;
}

LeastSquaresEnd FitAdjuster::minimise(const std::vector<int>& free, int iterations, double tolerance) {
  const auto n = static_cast<Eigen::Index>(free.size());
  LeastSquares problem{
      .low = Vector(n), .high = Vector(n), .scale = Vector(n), .cost = {}, .normal_equations = {}};
  Vector x(n);
  for (Eigen::Index k = 0; k < n; ++k) {
    const Unknown& u = unknowns_[free[static_cast<std::size_t>(k)]];
    problem.low[k] = u.low, problem.high[k] = u.high, problem.scale[k] = u.scale;
    x[k] = theta_[free[static_cast<std::size_t>(k)]];
  }
  const auto whole = [&](const Vector& part) {
    Vector theta = theta_;
    for (Eigen::Index k = 0; k < n; ++k) theta[free[static_cast<std::size_t>(k)]] = part[k];
    return theta;
  };
  problem.cost = [&](const Vector& part) { return cost(whole(part)); };
  problem.normal_equations = [&](const Vector& part, Matrix& H, Vector& g) {
    normal_equations(whole(part), free, false, H, g);
  };
  LeastSquaresEnd end = minimize(problem, x, {.iterations = iterations, .tolerance = tolerance});
  theta_ = whole(end.x);
  return end;
}

void FitAdjuster::adjust_starts(int iterations) {
  std::vector<int> rows;
  for (int m = 0; m < runs_.motions(); ++m) rows.push_back(runs_.limit(m));
  for (int m = 0; m < runs_.motions(); ++m) {
    for (int k = 0; k < runs_.motions(); ++k) runs_.limit(k, k == m ? rows[static_cast<std::size_t>(k)] : 0);
    std::vector<int> own;
    for (int i = 0; i < unknowns_.size(); ++i)
      if (unknowns_[i].motion == m) own.push_back(i);
    if (!own.empty()) minimise(own, iterations, 1e-3 * static_cast<double>(own.size()));
  }
  for (int m = 0; m < runs_.motions(); ++m) runs_.limit(m, rows[static_cast<std::size_t>(m)]);
}

void FitAdjuster::settle_starts() {
  const std::optional<Scene> scene = runs_.scene(unknowns_, theta_);
  if (!scene) return;
  for (int m = 0; m < runs_.motions(); ++m) {
    const int whole = whole_[static_cast<std::size_t>(m)];
    int rows = std::min(whole, runs_.rows_before_contact(unknowns_, theta_, *scene, m));
    if (rows == 0) rows = whole / 4;
    runs_.limit(m, std::clamp(rows, std::min(fewest_rows, whole), whole));
  }
  constexpr int iterations = 15;
  adjust_starts(iterations);
  const Vector before = sigma_;
  estimate_sigmas();  // of these rows: in flight the scatter is the instrument's alone
  adjust_starts(iterations);
  sigma_ = before;
}

std::vector<std::string> FitAdjuster::search_parameters() {
  std::vector<int> searched;
  for (int i = 0; i < unknowns_.size(); ++i)
    if (unknowns_[i].kind == UnknownKind::Parameter && unknowns_[i].guess != 0) searched.push_back(i);
  const auto n = static_cast<Eigen::Index>(searched.size());
  const long budget = problem_.search_runs < 0 ? 40 * (n + 1) : problem_.search_runs / runs_.motions();
  if (n == 0 || budget == 0) return {};
  const std::vector<int> rows = [&] {
    std::vector<int> now;
    for (int m = 0; m < runs_.motions(); ++m) now.push_back(runs_.limit(m));
    return now;
  }();
  for (int m = 0; m < runs_.motions(); ++m) runs_.limit(m, whole_[static_cast<std::size_t>(m)]);
  // in logarithms where the sign is known: a parameter's size is what is not
  Vector low(n), high(n), x(n);
  const auto value = [&](Eigen::Index k, double s) {
    const Unknown& u = unknowns_[searched[static_cast<std::size_t>(k)]];
    return std::clamp(u.guess * std::exp(s), u.low, u.high);
  };
  for (Eigen::Index k = 0; k < n; ++k) {
    const Unknown& u = unknowns_[searched[static_cast<std::size_t>(k)]];
    constexpr double decade = 2.302585092994046;
    const double ends[] = {u.low / u.guess, u.high / u.guess};
    const double least = std::min(ends[0], ends[1]), most = std::max(ends[0], ends[1]);
    low[k] = least > 0 ? std::max(-decade, std::log(least)) : -decade;
    high[k] = std::min(decade, std::log(most));
    if (!(high[k] > low[k])) high[k] = low[k] + 1e-9;
    x[k] = std::clamp(0.0, low[k], high[k]);
  }
  const auto theta = [&](const Vector& s) {
    Vector all = theta_;
    for (Eigen::Index k = 0; k < n; ++k) all[searched[static_cast<std::size_t>(k)]] = value(k, s[k]);
    return all;
  };
  const auto misfit = [&](const Vector& s) {  // far-off cells count once, whatever their distance
    double sum = 0;
    const std::vector<Residual> all = residuals(theta(s));
    for (int m = 0; m < runs_.motions(); ++m)
      for (Eigen::Index i = 0; i < all[static_cast<std::size_t>(m)].raw.size(); ++i) {
        const int column = runs_.cells(m)[static_cast<std::size_t>(i)].column;
        const double r = all[static_cast<std::size_t>(m)].raw[i] / runs_.spread(column);
        sum += r * r / (1 + r * r);
      }
    return sum;
  };
  const SearchEnd end = search(misfit, low, high, x, budget, problem_.seed);
  theta_ = theta(end.x);
  for (int m = 0; m < runs_.motions(); ++m) runs_.limit(m, rows[static_cast<std::size_t>(m)]);
  return {end.sentence};
}

void FitAdjuster::estimate_sigmas() {
  const auto columns = sigma_.size();
  Vector squares = Vector::Zero(columns), count = Vector::Zero(columns);
  const std::vector<Residual> all = residuals(theta_);
  for (int m = 0; m < runs_.motions(); ++m)
    for (Eigen::Index i = 0; i < all[static_cast<std::size_t>(m)].raw.size(); ++i) {
      const int c = runs_.cells(m)[static_cast<std::size_t>(i)].column;
      const double r = all[static_cast<std::size_t>(m)].raw[i];
      squares[c] += weight(r / sigma_[c]) * r * r;
      ++count[c];
    }
  const double cells = count.sum(), left = std::max(0.1, (cells - unknowns_.size()) / cells);
  double relative = 0;
  for (Eigen::Index c = 0; c < columns; ++c)
    relative += squares[c] / (runs_.spread(static_cast<int>(c)) * runs_.spread(static_cast<int>(c)));
  relative /= cells * left;
  constexpr double few = 10;  // cells, of which a scatter is not known: then by that of all columns
  for (Eigen::Index c = 0; c < columns; ++c) {
    const double spread = runs_.spread(static_cast<int>(c));
    const double own = count[c] > few ? squares[c] / (count[c] * left) : relative * spread * spread;
    sigma_[c] = std::max(std::sqrt(own), sigma_least * spread);
  }
}

bool FitAdjuster::adjust() {
  const std::vector<int> all = adjusted();
  const double negligible =
      1e-3 * unknowns_.size();  // of chi^2/2: a gain that moves no unknown by a twentieth of its error
  // beginnings before ends: what comes after many impacts says nothing of a fit that misses the first
  constexpr double longer = 1.5;
  for (bool whole = false; !whole;) {
    whole = true;
    for (int m = 0; m < runs_.motions(); ++m) {
      const int end = whole_[static_cast<std::size_t>(m)];
      runs_.limit(m, std::min(end, static_cast<int>(longer * runs_.limit(m)) + 2));
      whole = whole && runs_.limit(m) == end;
    }
    if (problem_.progress) problem_.progress(std::to_string(cells()) + " cells");
    if (runs_.motions() > 1 && !problem_.starts_first)
      adjust_starts(4);  // each by itself: one that resists does not damp the others
    if (!whole) minimise(all, runs_.motions() > 1 ? 3 : 6, 10 * negligible);
  }
  bool converged = false;
  constexpr int rounds = 6;
  constexpr double settled = 0.05;  // relative change of a sigma
  for (int round = 0; round < rounds; ++round) {
    if (problem_.starts_first) {  // in flight too they depend on the clock
      settle_starts();
      for (int m = 0; m < runs_.motions(); ++m) runs_.limit(m, whole_[static_cast<std::size_t>(m)]);
    }
    const LeastSquaresEnd end = minimise(all, 20, negligible);
    converged = end.converged;
    const Vector before = sigma_;
    estimate_sigmas();
    if (problem_.progress) problem_.progress("scatter round " + std::to_string(round + 1));
    if (((sigma_ - before).cwiseAbs().array() <= settled * before.array()).all() && converged) break;
  }
  return converged;
}

bool FitAdjuster::runs_at_all() {
  const std::vector<Residual> all = residuals(theta_);
  return std::any_of(all.begin(), all.end(), [](const Residual& r) { return !r.failed; });
}

}  // namespace perp
