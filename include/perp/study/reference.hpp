// What errors are held against: the exact motion, or, where none is known, two computed ones that agree.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <string_view>

#include "perp/study/error_measure.hpp"
#include "perp/study/impulse_path.hpp"
#include "perp/study/scene.hpp"

namespace perp {

/// What a study asks for: `perp study --reference`.
enum class ReferenceChoice {
  Automatic,     ///< exact where the scene knows it, else event
  Exact,         ///< the scene's exact motion
  Event,         ///< the method `event` at a tight tolerance, confirmed by the limit of `ncp2` at fixed steps
  Extrapolated,  ///< the method `extrapolated`, confirmed likewise
  OwnLimit       ///< each method against what its own answers tend to: says nothing of how right that is
};

[[nodiscard]] std::string_view name_of(ReferenceChoice choice);  ///< "exact", "event", ..., "own-limit"
/// Throws std::invalid_argument for a name that is none.
[[nodiscard]] ReferenceChoice reference_named(std::string_view name);

/// What a method's errors are counted from.
enum class OrderReference {
  Exact,         ///< the scene's exact motion
  Event,         ///< a run of `event`, confirmed
  Extrapolated,  ///< a run of `extrapolated`, confirmed
  Limit,  ///< the method's own answers as h goes to 0, from its two smallest steps, which are then left out of the fit
  None  ///< nothing: there is no reference, or the method has no limit to form
};

/// "exact", "event", "extrapolated", "limit", "none"
[[nodiscard]] std::string_view name_of(OrderReference reference);

/// What error_v measures; doc/studies.md has the formulas.
enum class VelocityMeasure {
  AtEnd,  ///< velocity_error at T: for T away from impacts
  L1,     ///< l1_distance over the whole run
  Graph  ///< graph_distance over the whole run, a second counting as the largest velocity over the run's length
};

/// A motion to count errors from, with how far it can be trusted.
struct Reference {
  OrderReference kind = OrderReference::None;
  State end = {};                              ///< at T
  std::function<State(double t)> motion = {};  ///< over the run
  std::optional<VelocityPath> velocity = {};   ///< over the run, for measures that need it
  double bar_q = 0,
         bar_v = 0;  ///< how far the two computed motions are apart, as error_q and error_v; 0: exact
  /// Accumulated impulses by `ncp2` at a quarter of the finest step; where they were asked for and it came to T.
  std::optional<ImpulsePath> impulses = {};
  double length = 1;       ///< of the scene, by which moments count as impulses [m]
  std::string words = {};  ///< how it came about; of None why there is none

  explicit operator bool() const { return kind != OrderReference::None; }
};

struct ReferenceOptions {
  VelocityMeasure velocity = VelocityMeasure::AtEnd;
  int steps = 1280;  ///< least number of steps of the confirming runs; they refine up to 16 times that
  ReferenceChoice by = ReferenceChoice::Event;  ///< Event or Extrapolated
  double tolerance = 1e-13;                     ///< rtol of the run of the adaptive method
};

/// The scene's exact motion; None where it has none, or does not know it at t_end.
[[nodiscard]] Reference exact_reference(const Scene& scene, double t_end, VelocityMeasure velocity);

/// The impulses of `ncp2` with steps of h/4; empty where it does not come to t_end.
[[nodiscard]] std::optional<ImpulsePath> reference_impulses(const Scene& scene, double t_end, double h);

/// The method `event` (or `extrapolated`, which shares its events) at the tolerance, confirmed by `ncp2`, with which it shares neither right-hand side nor steps: the limit L of
/// ncp2 is the least-squares fit of x(h) = L + a h^2, or with b h^4 where that fits ten times better, to runs of five numbers of steps
/// spread over a factor of 2, whose ratios keep an event from falling at one fraction of all their steps. The two agree if they differ by at most three
/// times the scatter of these runs about L, and by at most a thousandth of how far the motion goes; if not, ncp2 is refined
/// fourfold, twice at most. The bar is that difference, or that from `event` at a hundred times the tolerance where that is larger. Runs
/// that do not reach t_end confirm nothing.
[[nodiscard]] Reference confirmed_reference(const Scene& scene, double t_end,
                                            const ReferenceOptions& options = {});

}  // namespace perp
