// Velocities over time, and the two norms in which a jump at a wrong time is a small error.
#include <algorithm>
#include <array>
#include <cmath>

#include "perp/core/errors.hpp"
#include "perp/study/error_measure.hpp"

namespace perp {
namespace {

using Index = Eigen::Index;

constexpr double thinnest = 1e-13;           // of the whole interval: what a jump of a motion is narrowed to
constexpr double hausdorff_accuracy = 1e-6;  // of the distance

Index points(const VelocityPath& path) { return static_cast<Index>(path.t.size()); }
double time_of(const VelocityPath& path, Index i) { return path.t[static_cast<std::size_t>(i)]; }

void need_comparable(const char* where, const VelocityPath& a, const VelocityPath& b) {
  for (const VelocityPath* path : {&a, &b})
    if (points(*path) < 2 || path->v.cols() != points(*path) || !path->v.allFinite() ||
        !std::is_sorted(path->t.begin(), path->t.end()))
      refuse(where, "path", static_cast<double>(points(*path)),
             "needs two points or more, times that never fall and a finite column of v for each");
  if (a.v.rows() != b.v.rows())
    refuse(where, "path", static_cast<double>(b.v.rows()), "needs as many components as the other path");
  const double rounding = 1e-12 * (a.t.back() - a.t.front());
  if (!(std::abs(a.t.front() - b.t.front()) <= rounding && std::abs(a.t.back() - b.t.back()) <= rounding))
    refuse(where, "path", b.t.back(), "needs the same first and last time as the other path");
}

/// ∫ |f| over the length of an interval on which f goes in a straight line from f0 to f1.
double integral_of_magnitude(double f0, double f1, double length) {
  const double a = std::abs(f0), b = std::abs(f1);
  if (f0 * f1 >= 0) return length * (a + b) / 2;
  return length * (a * a + b * b) / (a + b) / 2;  // two triangles
}

/// Walks along a path: values at times that do not fall, on the segment that goes on after them.
class Walk {
 public:
  explicit Walk(const VelocityPath& path) : path_(path) {}
  /// Moves to the segment that holds the open interval after t.
  void to(double t) {
    while (at_ + 2 < points(path_) && time_of(path_, at_ + 1) <= t) ++at_;
  }
  double end() const { return time_of(path_, at_ + 1); }
  double value(Index component, double t) const {
    const double t0 = time_of(path_, at_), t1 = time_of(path_, at_ + 1);
    const double s = t1 > t0 ? (t - t0) / (t1 - t0) : 1;
    return (1 - s) * path_.v(component, at_) + s * path_.v(component, at_ + 1);
  }

 private:
  const VelocityPath& path_;
  Index at_ = 0;
};

struct Point {
  double t, v;  // t already times `rate`
};

double length(const Point& p, const Point& q) { return std::max(std::abs(p.t - q.t), std::abs(p.v - q.v)); }

/// The distance of p from the segment from a to b in the maximum norm: the larger of two magnitudes, each linear along the
/// segment, is least at an end, where one of them is zero, or where they are equal.
double distance(const Point& p, const Point& a, const Point& b) {
  const double x0 = a.t - p.t, dx = b.t - a.t, y0 = a.v - p.v, dy = b.v - a.v;
  const auto at = [&](double s) { return std::max(std::abs(x0 + s * dx), std::abs(y0 + s * dy)); };
  double least = std::min(at(0), at(1));
  for (const auto& [zero, slope] :
       {std::array{x0, dx}, std::array{y0, dy}, std::array{x0 - y0, dx - dy}, std::array{x0 + y0, dx + dy}}) {
    const double s = -zero / slope;
    if (s > 0 && s < 1) least = std::min(least, at(s));
  }
  return least;
}

/// One component of a path as a curve in the plane.
struct Curve {
  std::vector<Point> p;

  Curve(const VelocityPath& path, Index component, double rate) {
    for (Index i = 0; i < points(path); ++i) p.push_back({rate * time_of(path, i), path.v(component, i)});
  }

  /// The least over this curve's segments of the larger of the distances of a and b from it. No point between a and b is
  /// further away, since the distance from one segment is convex.
  double beyond(const Point& a, const Point& b) const {
    const auto after =
        std::partition_point(p.begin() + 1, p.end() - 1, [&](const Point& x) { return x.t < a.t; });
    const auto start = after - p.begin();
    double least = infinity;
    const auto consider = [&](std::ptrdiff_t i) {  // the segment from p[i - 1] to p[i]
      const Point &first = p[static_cast<std::size_t>(i - 1)], &last = p[static_cast<std::size_t>(i)];
      if (std::max(first.t - b.t, a.t - last.t) >= least) return false;
      least = std::min(least, std::max(distance(a, first, last), distance(b, first, last)));
      return true;
    };
    for (std::ptrdiff_t i = start; i < std::ssize(p) && consider(i); ++i) continue;
    for (std::ptrdiff_t i = start - 1; i > 0 && consider(i); --i) continue;
    return least;
  }
};

/// The largest distance that a point of `from` has from `to`: segments of `from` are halved while their bound is above what
/// some point is known to have.
double furthest(const Curve& from, const Curve& to) {
  double known = 0;
  std::vector<std::array<Point, 2>> open;
  for (std::size_t i = 1; i < from.p.size(); ++i) open.push_back({from.p[i - 1], from.p[i]});
  for (const Point& p : from.p) known = std::max(known, to.beyond(p, p));
  double scale = 0;
  for (const Point& p : from.p) scale = std::max({scale, length(p, from.p.front())});
  while (!open.empty()) {
    const auto [a, b] = open.back();
    open.pop_back();
    if (to.beyond(a, b) <= known * (1 + hausdorff_accuracy)) continue;
    if (length(a, b) <= thinnest * scale) continue;
    const Point middle{(a.t + b.t) / 2, (a.v + b.v) / 2};
    known = std::max(known, to.beyond(middle, middle));
    open.push_back({a, middle});
    open.push_back({middle, b});
  }
  return known;
}

}  // namespace

VelocityPath velocity_path(const Model& model, const Trajectory& run) {
  VelocityPath path{.t = {}, .v = Matrix(model.nv(), static_cast<Index>(run.size()))};
  for (std::size_t i = 0; i < run.size(); ++i) {
    path.t.push_back(run.t(i));
    path.v.col(static_cast<Index>(i)) = world_velocity(model, run.state(i));
  }
  return path;
}

VelocityPath velocity_path(const Model& model, const std::function<State(double)>& motion, double t_begin,
                           double t_end, double tolerance, int first_intervals) {
  if (!(t_end > t_begin)) refuse("velocity_path", "t_end", t_end, "needs to be past t_begin");
  if (!(tolerance > 0)) refuse("velocity_path", "tolerance", tolerance, "needs to be positive");
  if (first_intervals < 1)
    refuse("velocity_path", "first_intervals", static_cast<double>(first_intervals),
           "needs to be at least 1");
  struct Node {
    double t;
    Vector v;
  };
  const auto node = [&](double t) { return Node{t, world_velocity(model, motion(t))}; };
  std::vector<Node> later;  // nodes to come, the next one last
  double scale = 0;
  for (int i = first_intervals; i >= 0; --i) {
    const double s = static_cast<double>(i) / first_intervals;
    later.push_back(node(i == first_intervals ? t_end : t_begin + s * (t_end - t_begin)));
    if (later.back().v.size() > 0) scale = std::max(scale, later.back().v.lpNorm<Eigen::Infinity>());
  }

  std::vector<Node> path{later.back()};
  later.pop_back();
  while (!later.empty()) {
    const Node &a = path.back(), &b = later.back();
    if (b.t - a.t > thinnest * (t_end - t_begin)) {
      Node middle = node((a.t + b.t) / 2);
      if (((a.v + b.v) / 2 - middle.v).lpNorm<Eigen::Infinity>() > tolerance * scale) {
        later.push_back(std::move(middle));
        continue;
      }
    }
    path.push_back(std::move(later.back()));
    later.pop_back();
  }

  VelocityPath result{.t = {}, .v = Matrix(model.nv(), static_cast<Index>(path.size()))};
  for (std::size_t i = 0; i < path.size(); ++i) {
    result.t.push_back(path[i].t);
    result.v.col(static_cast<Index>(i)) = path[i].v;
  }
  return result;
}

double l1_distance(const VelocityPath& a, const VelocityPath& b) {
  need_comparable("l1_distance", a, b);
  const double end = std::min(a.t.back(), b.t.back());
  Vector sum = Vector::Zero(a.v.rows());
  Walk on_a(a), on_b(b);
  for (double t = std::max(a.t.front(), b.t.front()); t < end;) {
    on_a.to(t);
    on_b.to(t);
    const double next = std::min({on_a.end(), on_b.end(), end});
    for (Index c = 0; c < sum.size(); ++c)
      sum[c] += integral_of_magnitude(on_a.value(c, t) - on_b.value(c, t),
                                      on_a.value(c, next) - on_b.value(c, next), next - t);
    t = next;
  }
  return sum.size() == 0 ? 0 : sum.maxCoeff();
}

double graph_distance(const VelocityPath& a, const VelocityPath& b, double rate) {
  need_comparable("graph_distance", a, b);
  if (!(rate > 0) || !std::isfinite(rate)) refuse("graph_distance", "rate", rate, "needs to be positive");
  double largest = 0;
  for (Index c = 0; c < a.v.rows(); ++c) {
    const Curve on_a(a, c, rate), on_b(b, c, rate);
    largest = std::max({largest, furthest(on_a, on_b), furthest(on_b, on_a)});
  }
  return largest;
}

}  // namespace perp
