#include "perp/study/observed_order.hpp"

#include <algorithm>
#include <cmath>

#include "perp/core/errors.hpp"

namespace perp {
namespace {

struct Point {
  double h, error;
};

double slope(const std::vector<Point>& points) {
  const auto size = static_cast<double>(points.size());
  double x = 0, y = 0, xx = 0, xy = 0;
  for (const Point& p : points) x += std::log(p.h) / size, y += std::log(p.error) / size;
  for (const Point& p : points) {
    xx += (std::log(p.h) - x) * (std::log(p.h) - x);
    xy += (std::log(p.h) - x) * (std::log(p.error) - y);
  }
  return xy / xx;
}

/// How many of the points, which come with the smallest step first, have errors within a factor of each other.
std::size_t level_points(const std::vector<Point>& points, double factor) {
  double low = infinity, high = 0;
  std::size_t count = 0;
  for (const Point& p : points) {
    low = std::min(low, p.error);
    high = std::max(high, p.error);
    if (high > factor * low) break;
    ++count;
  }
  return count;
}

bool enough(const std::vector<Point>& points, std::size_t count, const OrderOptions& options) {
  return count >= static_cast<std::size_t>(options.least_points) &&
         points[count - 1].h >= options.least_span * points[0].h * (1 - 1e-9);
}

void add(std::string& note, const std::string& more) { note.append(note.empty() ? "" : "; ").append(more); }

}  // namespace

std::vector<double> halvings(double h, int count) {
  if (!(h > 0) || !std::isfinite(h)) refuse("halvings", "h", h, "needs to be positive [s]");
  if (count < 1) refuse("halvings", "count", static_cast<double>(count), "needs to be at least 1");
  std::vector<double> steps;
  for (int k = 0; k < count; ++k) steps.push_back(std::ldexp(h, -k));
  return steps;
}

std::vector<double> ladder(double length, int first, int count) {
  if (first < 1) refuse("ladder", "first", static_cast<double>(first), "needs to be at least 1");
  return halvings(length / first, count);
}

ObservedOrder observed_order(const std::vector<double>& h, const std::vector<double>& error,
                             const std::vector<double>& round_off, const OrderOptions& options) {
  if (error.size() != h.size() || round_off.size() != h.size())
    refuse("observed_order", "error", static_cast<double>(error.size()), "needs as many entries as h");
  std::vector<Point> points;
  int failed = 0, rounded = 0, barred = 0;
  for (std::size_t i = 0; i < h.size(); ++i) {
    if (!(h[i] > 0)) refuse("observed_order", "h", h[i], "needs to be positive [s]");
    if (error[i] < 0) refuse("observed_order", "error", error[i], "needs not to be negative");
    if (!std::isfinite(error[i]))
      ++failed;
    else if (error[i] <= round_off[i])
      ++rounded;
    else if (error[i] <= options.bar)
      ++barred;
    else
      points.push_back({h[i], error[i]});
  }
  std::stable_sort(points.begin(), points.end(), [](const Point& a, const Point& b) { return a.h < b.h; });

  ObservedOrder result;
  const auto count = [&](int n, const char* what) {
    return std::to_string(n) + " of " + std::to_string(h.size()) + " " + what;
  };
  if (failed > 0) add(result.note, count(failed, "without an answer"));
  if (rounded > 0) add(result.note, count(rounded, "at round-off"));
  if (barred > 0) add(result.note, count(barred, "within the reference's bar"));
  if (rounded > 0 && rounded == static_cast<int>(h.size())) {
    result.note = "exact to round-off";
    return result;
  }
  result.points = static_cast<int>(points.size());
  if (!points.empty()) result.h_least = points.front().h, result.h_most = points.back().h;
  for (std::size_t i = points.size(); i-- > 1;)
    if (points[i].h > points[i - 1].h) result.local.push_back(slope({points[i - 1], points[i]}));
  if (!enough(points, points.size(), options)) {
    add(result.note, "too few points for an order");
    return result;
  }
  const std::size_t level = level_points(points, options.stall_range);
  if (enough(points, level, options)) {
    result.floor = points.front().error;
    char text[40];
    std::snprintf(text, sizeof text, "stalls at %.3g", result.floor);
    add(result.note, text);
    return result;
  }
  result.order = slope(points);
  return result;
}

State extrapolated(const Model& model, const State& coarse, const State& fine, double ratio, double p) {
  if (!(ratio > 1)) refuse("extrapolated", "ratio", ratio, "needs to be above 1");
  if (!(p > 0)) refuse("extrapolated", "p", p, "needs to be positive");
  const double further = 1 / (std::pow(ratio, p) - 1);
  State limit = fine;
  limit.q += further * (fine.q - coarse.q);
  limit.nu += further * (fine.nu - coarse.nu);
  for (const Body& body : model.bodies()) {
    if (body.kind != BodyKind::Spatial) continue;
    const auto orientation = [&](const State& x) {
      const auto q = x.q.segment<4>(body.q0 + 3);
      return Quaternion(q[0], q[1], q[2], q[3]);
    };
    const Quaternion from = orientation(coarse), to = orientation(fine);
    const Quaternion q = to * rotation(further * rotation_vector(from.conjugate() * to));
    limit.q.segment<4>(body.q0 + 3) << q.w(), q.x(), q.y(), q.z();
    const auto w = [&](const State& x) -> Vector3 {
      return orientation(x) * Vector3(x.nu.segment<3>(body.v0 + 3));
    };
    limit.nu.segment<3>(body.v0 + 3) = q.conjugate() * (w(fine) + further * (w(fine) - w(coarse)));
  }
  return limit;
}

}  // namespace perp
