#include "study/fit_report.hpp"

#include <algorithm>
#include <boost/math/distributions/students_t.hpp>
#include <cmath>
#include <cstdio>
#include <map>

#include "perp/core/errors.hpp"
#include "study/fit_intervals.hpp"
#include "study/fit_start.hpp"

namespace perp {
namespace {

std::string full_name(const FitRuns& runs, const Unknown& u) {
  return u.shared() || runs.motions() == 1 ? u.name : u.name + "@" + runs.motion(u.motion).name;
}

/// "k +0.71, m -0.70": the entries that have a part.
std::string sentence(const FitRuns& runs, const Unknowns& unknowns, const Vector& v) {
  std::vector<int> order;
  for (int i = 0; i < unknowns.size(); ++i)
    if (std::abs(v[i]) > 0.03) order.push_back(i);
  std::stable_sort(order.begin(), order.end(), [&](int a, int b) { return std::abs(v[a]) > std::abs(v[b]); });
  std::string names, numbers;
  const double sign = order.empty() || v[order[0]] > 0 ? 1 : -1;
  for (const int i : order) {
    char part[40];
    std::snprintf(part, sizeof part, " %+.2g", sign * v[i] * unknowns[i].scale);
    names += (names.empty() ? "" : ", ") + full_name(runs, unknowns[i]);
    numbers += (numbers.empty() ? "" : ", ") + full_name(runs, unknowns[i]) + part;
  }
  if (order.size() == 1) return "the data say nothing of " + names;
  return "the data do not tell apart " + names + ": they stay as they are along (" + numbers + ")";
}

/// Of residuals in the order of time, column by column: mean product of neighbours over mean square.
double neighbours(FitAdjuster& adjuster) {
  double product = 0, square = 0;
  const std::vector<Residual> all = adjuster.residuals(adjuster.theta());
  for (int m = 0; m < adjuster.runs().motions(); ++m) {
    std::map<int, double> last;
    for (Eigen::Index i = 0; i < all[static_cast<std::size_t>(m)].raw.size(); ++i) {
      const int c = adjuster.runs().cells(m)[static_cast<std::size_t>(i)].column;
      const double r = std::clamp(all[static_cast<std::size_t>(m)].raw[i] / adjuster.sigmas()[c], -3.0, 3.0);
      if (const auto before = last.find(c); before != last.end()) product += before->second * r;
      square += r * r;
      last[c] = r;
    }
  }
  return square > 0 ? product / square : 0;
}

/// Rows of a rotation that is wholly free: the quaternion of the start, by the chain rule.
void add_quaternion(const FitAdjuster& adjuster, int first, const Matrix& covariance, bool known,
                    double times, std::vector<FittedValue>& values) {
  const Unknowns& unknowns = adjuster.unknowns();
  const Unknown& u = unknowns[first];
  int index[3] = {-1, -1, -1};
  for (int i = 0; i < unknowns.size(); ++i)
    if (unknowns[i].kind == UnknownKind::Rotation && unknowns[i].motion == u.motion &&
        unknowns[i].body == u.body)
      index[unknowns[i].index] = i;
  Quaternion base = Quaternion::Identity();
  for (const auto& [body, q] : unknowns.bases[static_cast<std::size_t>(u.motion)].orientations)
    if (body == u.body) base = q;
  Vector3 r;
  for (int k = 0; k < 3; ++k) r[k] = adjuster.theta()[index[k]];
  const auto at = [&](const Vector3& turn) {
    const Quaternion q = rotation(turn) * base;
    return Eigen::Vector4d(q.w(), q.x(), q.y(), q.z());
  };
  Eigen::Matrix<double, 4, 3> D;
  constexpr double small = 1e-5;  // rad: central differences of a smooth function, exact to 1e-10
  for (int k = 0; k < 3; ++k)
    D.col(k) = (at(r + small * Vector3::Unit(k)) - at(r - small * Vector3::Unit(k))) / (2 * small);
  Matrix3 C;
  for (int a = 0; a < 3; ++a)
    for (int b = 0; b < 3; ++b) C(a, b) = covariance(index[a], index[b]);
  const Eigen::Vector4d q = at(r);
  const std::string stem = u.name.substr(0, u.name.size() - 2);
  const char* parts[] = {"qw", "qx", "qy", "qz"};
  for (int k = 0; k < 4; ++k) {
    Unknown named = u;
    named.name = stem + parts[k];
    const double half = times * std::sqrt(std::max(0.0, (D.row(k) * C * D.row(k).transpose()).value()));
    FittedValue value{.name = full_name(const_cast<FitAdjuster&>(adjuster).runs(), named),
                      .identifiable = known};
    if (known) value.value = q[k], value.low = q[k] - half, value.high = q[k] + half;
    values.push_back(value);
  }
}

/// Where an interval's end is by the data themselves: curvature foretells that chi^2 rises there by `rise`. Where it does not, because a
/// kink lies at the minimum (friction that only just holds), farther out; infinity where nothing stops it within the unknown's scale.
double end_of_interval(FitAdjuster& adjuster, int i, const Vector& direction, double half, double rise) {
  const double least = adjuster.cost(adjuster.theta());
  const Unknowns& unknowns = adjuster.unknowns();
  const auto change = [&](const Vector& step) {
    Vector theta = adjuster.theta() + step;
    for (int k = 0; k < theta.size(); ++k) theta[k] = std::clamp(theta[k], unknowns[k].low, unknowns[k].high);
    return 2 * (adjuster.cost(theta) - least);
  };
  // what is really least at this value lies below both: the others as curvature has them follow, and where they are
  const auto risen = [&](double s) {
    return std::min(change(s * direction), change(s * direction[i] * Vector::Unit(direction.size(), i)));
  };
  constexpr double enough =
      0.25;  // of what is foretold: minima of steps of fixed size are not quite parabolas
  const double most = unknowns[i].scale / std::abs(direction[i]);
  double inside = risen(half) > enough * rise ? 0 : half;
  for (double s = 2 * half; s < most; s *= 2)  // past a kink it may be flat
    if (risen(s) < rise) inside = s;
  if (inside == 0) return half;
  double outside = 2 * inside;
  if (outside >= most) return infinity;
  constexpr int halvings = 6;
  for (int k = 0; k < halvings; ++k) {
    const double middle = 0.5 * (inside + outside);
    (risen(middle) < rise ? inside : outside) = middle;
  }
  return outside;
}

struct Kind {
  std::string body, what;
};

Kind kind_of(const std::string& column) {
  const std::size_t dot = column.rfind('.');
  const std::string part = column.substr(dot + 1), body = column.substr(0, dot);
  if (part == "x" || part == "y" || part == "z") return {body, "position"};
  if (part == "qw" || part == "qx" || part == "qy" || part == "qz" || part == "angle")
    return {body, "rotation"};
  if (part == "vx" || part == "vy" || part == "vz") return {body, "velocity"};
  if (part == "wx" || part == "wy" || part == "wz" || part == "omega") return {body, "spin"};
  return {body, part[0] == 'q' ? "coordinate" : "rate"};
}

/// Appends residuals of a motion, and where some rows had no part the errors of their prediction.
void add_motion(FitAdjuster& adjuster, const std::vector<Residual>& all, int m, int from_row,
                FitResult& result) {
  FitRuns& runs = adjuster.runs();
  std::map<std::pair<std::string, std::string>, std::map<int, double>> squares;
  bool quaternion = false;
  for (Eigen::Index i = 0; i < all[static_cast<std::size_t>(m)].raw.size(); ++i) {
    const MeasuredCell& cell = runs.cells(m)[static_cast<std::size_t>(i)];
    const std::string& column = runs.columns()[static_cast<std::size_t>(cell.column)];
    const double r = all[static_cast<std::size_t>(m)].raw[i];
    const bool held = cell.row >= from_row;
    result.residuals.push_back({.motion = runs.motion(m).name,
                                .column = column,
                                .t = runs.motion(m).t[static_cast<std::size_t>(cell.row)],
                                .measured = cell.value,
                                .fitted = cell.value + r,
                                .held_back = held});
    if (!held) continue;
    const Kind kind = kind_of(column);
    quaternion = quaternion || column.ends_with(".qw");
    squares[{kind.body, kind.what}][cell.row] += r * r;
  }
  for (const auto& [kind, rows] : squares) {
    PredictionError error{.motion = runs.motion(m).name, .body = kind.first, .what = kind.second};
    double sum = 0;
    for (const auto& [row, square] : rows) {
      double e = std::sqrt(square);
      if (kind.second == "rotation" && quaternion) e = 4 * std::asin(std::min(1.0, 0.5 * e));  // of |q - q'|
      sum += e * e;
      error.largest = std::max(error.largest, e);
      error.end = e;
    }
    error.rows = static_cast<int>(rows.size());
    error.rms = std::sqrt(sum / error.rows);
    result.prediction.push_back(error);
  }
}

}  // namespace

void report_values(FitAdjuster& adjuster, FitResult& result) {
  const Unknowns& unknowns = adjuster.unknowns();
  const FitRuns& runs = adjuster.runs();
  const int n = unknowns.size();
  Vector scale(n);
  for (int i = 0; i < n; ++i) scale[i] = unknowns[i].scale;
  const Curvature curve = curvature(adjuster.hessian(), scale);
  const auto N = static_cast<double>(adjuster.cells());
  const double freedom = std::max(1.0, N - n), r = neighbours(adjuster);
  const bool correlated = r > 3 / std::sqrt(N);  // more than chance
  result.correlation = r;
  const double wider = correlated ? std::sqrt((1 + std::min(r, 0.99)) / (1 - std::min(r, 0.99))) : 1;
  const double times = wider * boost::math::quantile(boost::math::students_t(freedom), 0.975);
  for (const FlatDirection& flat : curve.flat) result.flat.push_back(sentence(runs, unknowns, flat.v));
  for (int i = 0; i < n; ++i) {
    const Unknown& u = unknowns[i];
    const bool known = curve.identifiable[static_cast<std::size_t>(i)];
    if (u.kind == UnknownKind::Rotation && unknowns.whole_rotation(u.motion, u.body)) {
      if (u.index > 0) continue;
      bool all = true;
      for (int k = 0; k < n; ++k)
        if (unknowns[k].kind == u.kind && unknowns[k].motion == u.motion && unknowns[k].body == u.body)
          all = all && curve.identifiable[static_cast<std::size_t>(k)];
      add_quaternion(adjuster, i, curve.covariance, all, times, result.values);
      continue;
    }
    FittedValue value{.name = full_name(runs, u), .identifiable = known};
    if (known) {
      const double x = adjuster.theta()[i], half = times * std::sqrt(curve.covariance(i, i));
      double below = half, above = half;
      if (u.kind == UnknownKind::Parameter && half > 0) {
        const Vector direction = curve.covariance.col(i) / curve.covariance(i, i);
        below = end_of_interval(adjuster, i, -direction, half, times * times);
        above = end_of_interval(adjuster, i, direction, half, times * times);
      }
      value.value = x;
      value.low = std::max(u.low, x - below);
      value.high = std::min(u.high, x + above);
      if (curve.covariance(i, i) * 1e10 < u.scale * u.scale && !u.shared() &&
          adjuster.adjusted().size() < std::size_t(n))
        value.low = value.high = not_set, value.note = "from its rows before the first contact";
      if (x <= u.low) value.note = "at its lower bound";
      if (x >= u.high) value.note = "at its upper bound";
      if (std::isinf(below) || std::isinf(above)) {  // the data say at least, or at most
        const std::string end = std::isinf(above) && std::isinf(below) ? ""
                                : std::isinf(above)                    ? ": at least " + shortest(value.low)
                                                                       : ": at most " + shortest(value.high);
        value = {.name = value.name, .note = "the data do not limit it" + end};
        result.flat.push_back(value.name + ": the data do not limit it" + end);
      }
    } else {
      for (const FlatDirection& flat : curve.flat)
        if (std::abs(flat.v[i]) > 0.03 && value.note.empty()) value.note = sentence(runs, unknowns, flat.v);
    }
    result.values.push_back(value);
  }
  for (std::size_t c = 0; c < runs.columns().size(); ++c) {
    long cells = 0;
    for (int m = 0; m < runs.motions(); ++m)
      for (const MeasuredCell& cell : runs.cells(m))
        cells += cell.column == static_cast<int>(c) && cell.row < runs.limit(m);
    result.noise.push_back({runs.columns()[c], adjuster.sigmas()[static_cast<Eigen::Index>(c)], cells});
  }
}

void report_residuals(FitAdjuster& adjuster, FitResult& result) {
  FitRuns& runs = adjuster.runs();
  std::vector<int> fitted;
  for (int m = 0; m < runs.motions(); ++m) {
    fitted.push_back(runs.limit(m));
    runs.limit(m, static_cast<int>(runs.motion(m).t.size()));
  }
  const std::vector<Residual> all = adjuster.residuals(adjuster.theta());
  for (int m = 0; m < runs.motions(); ++m) {
    add_motion(adjuster, all, m, fitted[static_cast<std::size_t>(m)], result);
    runs.limit(m, fitted[static_cast<std::size_t>(m)]);
  }
}

void predict(const FitProblem& problem, const std::vector<MeasuredMotion>& held, const Unknowns& fitted,
             const Vector& theta, const Vector& sigma, const std::vector<std::string>& columns,
             FitResult& result) {
  const Scene scene = problem.scene(fitted.parameters(problem.set, theta));
  FitRuns runs(problem, held, scene);
  Unknowns unknowns(problem, scene, held);
  guess_from_data(runs, scene, unknowns);
  for (int i = 0; i < unknowns.size(); ++i)
    for (int k = 0; k < fitted.size(); ++k)
      if (unknowns[i].shared() && fitted[k].shared() && unknowns[i].name == fitted[k].name)
        unknowns[i].guess = theta[k];
  FitAdjuster adjuster(problem, runs, unknowns, 0);
  Vector sigmas = adjuster.sigmas();
  for (std::size_t c = 0; c < runs.columns().size(); ++c)
    for (std::size_t k = 0; k < columns.size(); ++k)
      if (columns[k] == runs.columns()[c])
        sigmas[static_cast<Eigen::Index>(c)] = sigma[static_cast<Eigen::Index>(k)];
  adjuster.set_sigmas(sigmas);
  for (int pass = 0; pass < 2; ++pass) adjuster.settle_starts();  // the second with a better first contact
  report_residuals(adjuster, result);
  result.runs += runs.runs();
  result.failed += runs.failed();
}

}  // namespace perp
