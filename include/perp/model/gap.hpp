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

/// How normal and point of a ContactPoint move, in world axes: with them the gap's second derivatives are known.
///   dn = normal (v_A, w_A, v_B, w_B) dt + normal_t dt,     dc likewise with `point`
struct ContactDerivative {
  using Columns =
      Eigen::Matrix<double, 3, 12>;    ///< of the twists of A, then of B (origin's velocity, then turning)
  Columns normal = Columns::Zero();    ///< [1/m, 1/rad]
  Columns point = Columns::Zero();     ///< [-, m/rad]
  Vector3 normal_t = Vector3::Zero();  ///< explicit, at fixed poses [1/s]
  Vector3 point_t = Vector3::Zero();   ///< [m/s]
  double gap_tt = 0;                   ///< of gap_t [m/s^2]
};

/// A gap function psi_n of the poses of A and B and of time, with `points()` contact points. Made from any callable
///   ContactPoint(const Pose& X_WA, const Pose& X_WB, double t)
/// or, for several points between one pair of bodies, by Gap::patch. Geometry only: it knows no forces.
///
/// Derivatives come from the function given to differentiated_by (built-in gaps have one; `differentiable` makes one by
/// automatic differentiation), else from fourth-order central differences of the gap itself.
class Gap {
 public:
  using Patch =
      std::function<void(const Pose& X_WA, const Pose& X_WB, double t, std::span<ContactPoint> out)>;
  using PatchDerivative =
      std::function<void(const Pose& X_WA, const Pose& X_WB, double t, std::span<ContactDerivative> out)>;

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

  /// What each of its points is called after the contact's name: "" or a feature of the shapes, "b3".
  Gap& named_by(std::function<std::string(int point)> name) {
    name_ = std::move(name);
    return *this;
  }
  /// By default the point's number, nothing of a single point.
  std::string point_name(int point) const {
    return name_ ? name_(point) : points_ == 1 ? std::string() : std::to_string(point);
  }

  /// The derivatives that go with `evaluate`.
  Gap& differentiated_by(PatchDerivative derivative) {
    derivative_ = std::move(derivative);
    return *this;
  }
  /// Bounds, for all poses, on how fast the gap changes by turning alone: |(point - origin of A) x normal| <= a [m], b likewise. A
  /// gap that has them and no explicit time can be left alone while its bodies are far apart. infinity: unknown.
  Gap& levers(double a, double b) {
    lever_a_ = a;
    lever_b_ = b;
    return *this;
  }
  double lever_a() const { return lever_a_; }
  double lever_b() const { return lever_b_; }

  bool has_derivatives() const { return static_cast<bool>(derivative_); }  ///< false: by differences

  /// out has size points(); entries of points that are not there now mean nothing.
  void differentiate(const Pose& X_WA, const Pose& X_WB, double t, std::span<ContactDerivative> out) const {
    derivative_ ? derivative_(X_WA, X_WB, t, out) : differences(X_WA, X_WB, t, out);
  }

  /// out has size points().
  void operator()(const Pose& X_WA, const Pose& X_WB, double t, std::span<ContactPoint> out) const {
    evaluate_(X_WA, X_WB, t, out);
  }

 private:
  Gap(int points, Patch evaluate) : points_(points), evaluate_(std::move(evaluate)) {}
  void differences(const Pose& X_WA, const Pose& X_WB, double t, std::span<ContactDerivative> out) const;

  int points_;
  Patch evaluate_;
  PatchDerivative derivative_;  // may be empty
  double lever_a_ = infinity, lever_b_ = infinity;
  Recipe recipe_;
  std::function<std::string(int)> name_;  // may be empty
};

/// What check_gap found, each the largest over the poses it tried.
struct GapCheck {
  double normal_length_error = 0;  ///< | |normal| - 1 |
  double rate_error =
      0;  ///< normal . relative velocity against a central difference of the gap [m/s per m/s]
  double time_error = 0;  ///< gap_t against a central difference in t [m/s]
  double derivative_error =
      0;  ///< derivatives of normal and point against central differences, of gaps that have them
  bool finite = true;   ///< no NaN in any field of a point whose gap is not infinity
  bool passed = false;  ///< all of the above within `tolerance`
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

/// The vector that t is the projection of: `wish` or the axis that stands in for it.
[[nodiscard]] Vector3 tangent_wish(const Vector3& normal, const Vector3& wish);

}  // namespace perp
