#include "io/expression_timing.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace perp {
namespace {

/// A switch that depends on t alone.
struct TimeSwitch {
  Expression g;
  bool linear;

  bool on(double t) const { return g(std::array{t}) >= 0; }

  /// The first double after `low` that is on the other side, which `high` is.
  double cross(double low, double high) const {
    const bool side = on(low);
    while (true) {
      const double middle = low + 0.5 * (high - low);
      if (!(middle > low && middle < high)) return high;
      (on(middle) == side ? low : high) = middle;
    }
  }

  /// The first change in (t, until); of what is not linear looked for every `look`.
  double next(double t, double until, double look) const {
    if (!(until > t)) return infinity;
    const bool side = on(t);
    if (linear) return on(until) == side ? infinity : cross(t, until);
    const double steps = std::ceil((until - t) / look);
    for (double k = 1; k <= steps; ++k) {
      const double s = k == steps ? until : t + k * look;
      if (on(s) != side) return cross(t + (k - 1) * look, s);
    }
    return infinity;
  }
};

}  // namespace

Timing timing_of(std::span<const Expression> parts, const VariablesAt& at) {
  Timing timing{.steady =
                    std::none_of(parts.begin(), parts.end(), [](const Expression& e) { return e.uses(0); })};
  std::vector<TimeSwitch> switches;
  for (const Expression& part : parts)
    for (const Expression& g : part.switches()) {
      if (g.constant()) continue;
      if (g.uses_only(0))
        switches.push_back({g, g.linear(0)});
      else
        timing.switches.emplace_back([g, at](const Model& model, const State& x) { return g(at(model, x)); });
    }
  timing.next = [switches](double t, double until, double look) {
    double soonest = infinity;
    for (const TimeSwitch& s : switches)
      soonest = std::min(soonest, s.next(t, std::min(until, soonest), look));
    return soonest;
  };
  return timing;
}

}  // namespace perp
