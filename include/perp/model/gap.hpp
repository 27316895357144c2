// The distance between two bodies, and where and along what it is measured.
#pragma once

#include <concepts>
#include <functional>
#include <span>

#include "perp/core/pose.hpp"
#include "perp/model/recipe.hpp"

namespace perp {

/// One point where bodies A and B may touch, in world axes.
///   d(gap)/dt = normal . (velocity of B - velocity of A, at point) + gap_t
struct ContactPoint {
  double gap = infinity;              ///< psi_n [m]: > 0 apart, < 0 overlapping; infinity: no such point now
  Vector3 normal = Vector3::UnitZ();  ///< unit, from A to B
  Vector3 point = Vector3::Zero();    ///< where impulses act [m]
  double gap_t = 0;                   ///< explicit time derivative at fixed poses [m/s]
};

/// A gap function psi_n of the poses of A and B and of time, with `points()` contact points. Made from any callable
///   ContactPoint(const Pose& X_WA, const Pose& X_WB, double t)
/// or, for several points between one pair of bodies, by Gap::patch. Geometry only: it knows no forces.
class Gap {
 public:
  using Patch =
      std::function<void(const Pose& X_WA, const Pose& X_WB, double t, std::span<ContactPoint> out)>;

  template <class Function>
  requires std::is_invocable_r_v<ContactPoint, const Function&, const Pose&, const Pose&, double> Gap(
      Function point)  // NOLINT(google-explicit-constructor): a lambda is a gap
      : points_(1),
        evaluate_(
            [point = std::move(point)](const Pose& X_WA, const Pose& X_WB, double t,
                                       std::span<ContactPoint> out) { out[0] = point(X_WA, X_WB, t); }) {}

  /// A gap of `points` >= 1 points: `evaluate` fills all of them (one that is not there now keeps gap = infinity).
  static Gap patch(int points, Patch evaluate);

  int points() const { return points_; }

  /// How it was made, for gaps that perp brings along.
  const Recipe& recipe() const { return recipe_; }
  Gap& made_by(Recipe recipe) {
    recipe_ = std::move(recipe);
    return *this;
  }

  /// out has size points().
  void operator()(const Pose& X_WA, const Pose& X_WB, double t, std::span<ContactPoint> out) const {
    evaluate_(X_WA, X_WB, t, out);
  }

 private:
  Gap(int points, Patch evaluate) : points_(points), evaluate_(std::move(evaluate)) {}
  int points_;
  Patch evaluate_;
  Recipe recipe_;
};

/// What check_gap found, each the largest over the poses it tried.
struct GapCheck {
  double normal_length_error = 0;  ///< | |normal| - 1 |
  double rate_error =
      0;  ///< normal . relative velocity against a central difference of the gap [m/s per m/s]
  double time_error = 0;  ///< gap_t against a central difference in t [m/s]
  bool finite = true;     ///< no NaN in any field of a point whose gap is not infinity
  bool passed = false;    ///< all of the above within `tolerance`
};

struct GapCheckOptions {
  Pose X_WA, X_WB = {{0, 0, 1}, Quaternion::Identity()};  ///< about these poses ...
  double spread = 0.1;                                    ///< ... disturbed by up to this much [m, rad]
  int samples = 100;                                      ///< poses tried
  double t = 0;                                           ///< about this time [s], +- spread
  double tolerance = 1e-6;  ///< per unit of rate, angular rates counted at `length`
  double length = 1;        ///< a length of the scene [m]
  unsigned seed = 1;
};

/// Tests a gap that a user wrote: is the normal a unit vector, does the gap change at the rate that normal, point and
/// gap_t promise? A gap that fails gives a wrong W_n, and with it steps that converge to the wrong motion.
[[nodiscard]] GapCheck check_gap(const Gap& gap, const GapCheckOptions& options = {});

/// Orthonormal right-handed contact frame (columns n, t, o = n x t). t is `wish` projected into the tangent plane if
/// one is given (nonzero, not along n), else world x, else, where |n_x| > 0.9, world y: so n = z has t = x, o = y, and a
/// normal in the xy plane has t in it.
[[nodiscard]] Matrix3 contact_frame(const Vector3& normal, const Vector3& wish = Vector3::Zero());

}  // namespace perp
