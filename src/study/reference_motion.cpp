#include "study/reference_motion.hpp"

#include <algorithm>
#include <boost/math/tools/toms748_solve.hpp>
#include <boost/numeric/odeint/stepper/controlled_runge_kutta.hpp>
#include <boost/numeric/odeint/stepper/runge_kutta_fehlberg78.hpp>
#include <cmath>
#include <limits>
#include <mutex>

#include "perp/core/errors.hpp"

namespace perp {
namespace {

using Fehlberg = boost::numeric::odeint::runge_kutta_fehlberg78<Reals, Real>;
using Controlled = boost::numeric::odeint::controlled_runge_kutta<Fehlberg>;

constexpr Real local_error = 1e-17L;  // of max(1, |y|) a step: a hundredth of double's rounding
constexpr Real first_step = 1e-3L;    // [s] after a switch, before the error control knows better

/// The rates in the order of arguments that the steppers want.
auto system_of(const Stretch& stretch) {
  return [&stretch](const Reals& y, Reals& rate, Real t) {
    std::fill(rate.begin(), rate.end(), 0);
    stretch.rate(t, y, rate);
  };
}

}  // namespace

struct ReferenceMotion::Nodes {
  struct Node {
    Point point;
    Real step = first_step;  ///< suggested from here
    bool is_switch = false;
  };

  std::map<int, Stretch> stretches;
  Real max_step;
  std::vector<Node> list;
  std::mutex guard_of_list;

  const Stretch& stretch(const Point& from) const { return stretches.at(from.stretch); }

  /// y after one step of length s from a node, s no longer than the accepted step from there.
  Reals advance(const Point& from, Real s) const {
    Reals y = from.y;
    if (s > 0) Fehlberg().do_step(system_of(stretch(from)), y, from.t, s);
    return y;
  }

  /// The length of the step from `from`, at most `whole`, at whose end the guard is zero.
  Real time_to_switch(const Point& from, Real whole) const {
    const auto guard = [&](Real s) { return stretch(from).guard(from.t + s, advance(from, s)); };
    Real inside = 0;  // a stretch may begin where its guard is still zero: look for where it is positive
    if (!(guard(0) > 0))
      for (inside = whole / 2; inside > whole * 1e-12L && !(guard(inside) > 0);) inside /= 2;
    if (!(guard(inside) > 0)) return 0;
    std::uintmax_t iterations = 200;
    const auto bracket =
        boost::math::tools::toms748_solve(guard, inside, whole, guard(inside), guard(whole),
                                          boost::math::tools::eps_tolerance<Real>(62), iterations);
    return bracket.second;
  }

  void extend() {
    Node next = list.back();
    const Point from = next.point;
    const Stretch& now = stretch(from);
    Controlled controlled(
        boost::numeric::odeint::default_error_checker<Real, Controlled::algebra_type,
                                                      Controlled::operations_type>(local_error, local_error));
    next.step = std::min(next.step, max_step);
    while (controlled.try_step(system_of(now), next.point.y, next.point.t, next.step) ==
           boost::numeric::odeint::fail) {
    }
    next.is_switch = now.guard && !(now.guard(next.point.t, next.point.y) > 0);
    if (next.is_switch) {
      const Real s = time_to_switch(from, next.point.t - from.t);
      next.point = {from.t + s, advance(from, s), from.stretch};
      next.point.stretch = now.next(next.point.t, next.point.y);
      next.step = first_step;
    }
    list.push_back(std::move(next));
  }
};

ReferenceMotion::ReferenceMotion(std::map<int, Stretch> stretches, Reals y0, int first, Real max_step)
    : nodes_(std::make_shared<Nodes>()) {
  nodes_->stretches = std::move(stretches);
  nodes_->max_step = max_step;
  nodes_->list.push_back({.point = {.t = 0, .y = std::move(y0), .stretch = first}});
}

ReferenceMotion::ReferenceMotion(std::function<void(Real t, const Reals& y, Reals& rate)> rate, Reals y0)
    : ReferenceMotion({{0, Stretch{std::move(rate)}}}, std::move(y0), 0) {}

ReferenceMotion::Point ReferenceMotion::at(Real t) const {
  if (!(t >= 0) || !std::isfinite(t)) refuse("exact", "t", double(t), "needs to be >= 0 and finite [s]");
  const std::lock_guard lock(nodes_->guard_of_list);
  std::vector<Nodes::Node>& list = nodes_->list;
  while (list.back().point.t <= t) nodes_->extend();
  const auto after = std::upper_bound(
      list.begin(), list.end(), t, [](Real value, const Nodes::Node& node) { return value < node.point.t; });
  const Point& from = std::prev(after)->point;
  return {t, nodes_->advance(from, t - from.t), from.stretch};
}

std::vector<Real> ReferenceMotion::switches(Real t) const {
  static_cast<void>(at(t));
  const std::lock_guard lock(nodes_->guard_of_list);
  std::vector<Real> times;
  for (const Nodes::Node& node : nodes_->list)
    if (node.is_switch && node.point.t <= t) times.push_back(node.point.t);
  return times;
}

ReferenceMotion turning(std::function<RealVector3(Real t)> w, Real corner) {
  Stretch turn{.rate = [w](Real t, const Reals& y, Reals& rate) { turn_in_world_axes(y, w(t), rate); }};
  Stretch until_corner = turn;
  until_corner.guard = [corner](Real t, const Reals&) { return corner - t; };
  until_corner.next = [](Real, Reals&) { return 1; };
  return {{{0, until_corner}, {1, turn}}, {1, 0, 0, 0}, 0};
}

namespace {

using RealQuaternion = Eigen::Quaternion<Real>;

RealQuaternion quaternion(const Reals& y, std::size_t at) { return {y[at], y[at + 1], y[at + 2], y[at + 3]}; }

void set_half(Reals& rate, std::size_t at, const RealQuaternion& product) {
  rate[at] = product.w() / 2;
  rate[at + 1] = product.x() / 2;
  rate[at + 2] = product.y() / 2;
  rate[at + 3] = product.z() / 2;
}

RealQuaternion pure(const RealVector3& w) { return {0, w.x(), w.y(), w.z()}; }

}  // namespace

void turn_in_world_axes(const Reals& y, const RealVector3& w, Reals& rate, std::size_t at) {
  set_half(rate, at, pure(w) * quaternion(y, at));
}

void turn_in_body_axes(const Reals& y, const RealVector3& w, Reals& rate, std::size_t at) {
  set_half(rate, at, quaternion(y, at) * pure(w));
}

Quaternion orientation(const Reals& y, std::size_t at) {
  return quaternion(y, at).normalized().cast<double>();
}

}  // namespace perp
