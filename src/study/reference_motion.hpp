// Motions without a closed form: y' = f(t, y) in minimal coordinates, integrated until double precision cannot tell.
#pragma once

#include <functional>
#include <map>
#include <memory>
#include <vector>

#include "perp/core/types.hpp"

namespace perp {

using Real = long double;
using Reals = std::vector<Real>;
using RealVector3 = Eigen::Matrix<Real, 3, 1>;

/// A smooth stretch of a motion. It lasts while guard > 0; where guard falls through zero, `next` may change y (an impact,
/// a velocity that is zero from here on) and names the stretch that follows.
struct Stretch {
  std::function<void(Real t, const Reals& y, Reals& rate)> rate;  ///< rate comes zeroed, as long as y
  std::function<Real(Real t, const Reals& y)> guard = {};         ///< empty: for ever
  std::function<int(Real t, Reals& y)> next = {};                 ///< number of the following stretch
};

/// Nothing changes any more.
inline const Stretch still{.rate = [](Real, const Reals&, Reals&) {}};

/// The solution of a sequence of initial value problems
///   y' = rate_s(t, y),   s changes where guard_s(t, y) = 0,
/// by Fehlberg's pair of orders 7 and 8 [HNW93, II.10] in extended precision, local error 1e-17 of max(1, |y|), switches
/// bracketed and refined to rounding. Nodes are kept, and what lies between two nodes is one step from the first: the
/// answer at t does not depend on which times were asked for before. Copies share their nodes; threads may ask at once.
class ReferenceMotion {
 public:
  struct Point {
    Real t = 0;
    Reals y;
    int stretch = 0;
  };

  /// Starts at t = 0 in the stretch numbered `first`. max_step [s] bounds the steps: a guard that dips below zero and comes
  /// back between two nodes goes unseen.
  ReferenceMotion(std::map<int, Stretch> stretches, Reals y0, int first, Real max_step = 0.05L);

  /// One stretch for ever.
  ReferenceMotion(std::function<void(Real t, const Reals& y, Reals& rate)> rate, Reals y0);

  /// Just after a switch if t is one. Throws std::invalid_argument for t < 0.
  Point at(Real t) const;

  /// Times of the switches up to t, in order.
  std::vector<Real> switches(Real t) const;

 private:
  struct Nodes;
  std::shared_ptr<Nodes> nodes_;
};

/// Motions of an orientation q from q = 1, in y = (w, x, y, z), at the angular velocity w(t) in world axes, which may have a
/// corner at one time.
ReferenceMotion turning(std::function<RealVector3(Real t)> w, Real corner = infinity);

/// rate[at .. at + 3] of the orientation y[at .. at + 3] of a body that turns at w, in world axes or in its own.
void turn_in_world_axes(const Reals& y, const RealVector3& w, Reals& rate, std::size_t at = 0);
void turn_in_body_axes(const Reals& y, const RealVector3& w, Reals& rate, std::size_t at = 0);

/// The orientation y[at .. at + 3], normalised.
Quaternion orientation(const Reals& y, std::size_t at = 0);

}  // namespace perp
