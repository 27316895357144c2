// What counts as zero in a step: one room for closeness. Each share is of a scale that model and state make (Scales, StepSpeeds,
// lengths of the bodies' own), so that a scene in other units is decided alike.
#pragma once

#include <algorithm>
#include <cmath>

#include "perp/instant/instant.hpp"

namespace perp::closeness {

inline constexpr double eps = std::numeric_limits<double>::epsilon();

/// A gap touches if it is at most this share of the way h v of a step [-]. Steps are solved to 1e-10 of v, and a gap that closed in the
/// last step is that far from zero, more where impulses are large. Ten times less: contacts that rest on many others count
/// as arriving and restart their friction. Ten times more: a ball that falls slowly strikes a step too early.
inline constexpr double gap = 1e-7;

/// A contact approaches if u_n is below minus this share of the speeds of a step [-]; the same reasons.
inline constexpr double approach = 1e-7;

/// A contact sticks if |u_f| is at most this share of the speeds of a step [-]. Ten times less: what sticks seems to slip where the step is
/// solved to 1e-10. Ten times more: a slip that is about to stop counts as stopped a step earlier.
inline constexpr double slip = 1e-9;

/// Friction that is less than (1 - this) of its bound does not slip, whatever u_f [-]: in a small step psi/h rounds to more than `slip`.
/// Ten times less: the cone's own error (1e-10 to 1e-5 where p_n is small) makes slip of sticking; ten times more: what has just begun
/// to slip counts as stuck.
inline constexpr double inside_cone = 1e-3;

/// Rounding of a single sum, in eps of its terms' sizes [-].
inline constexpr double terms = 4;

/// What rounding leaves of a step's equation, of the sum of the sizes of what it adds up [-]: each of these is itself a sum, of four at most
/// that matter. Ten times less: light bodies between heavy ones are refused; ten times more: what
/// is left may be seen from outside.
inline constexpr double of_sum = 16 * eps;

/// What a step's algebra may leave of its equations on the way, of the largest w |p| and velocity in them, where they nearly repeat [-]. Newton's
/// method comes to 1e-13 to 2e-10 of them in piles, arches and overhangs, and goes on from there without a search. Ten times less: these
/// stop on the way; ten times more: a box held by friction for 100 s creeps.
inline constexpr double of_terms = 2e-10;

/// But it excuses no more than this share of the speeds of a step [-]: where rounding is more, the step is not solved. Ten times more:
/// light bodies between heavy ones move wrongly; ten times less: mass ratios of 1e8 and more are refused.
inline constexpr double most_rounding = 1e-6;

[[nodiscard]] inline bool touches(double gap_now, double h, double speed) {
  return gap_now <= gap * h * speed;
}
[[nodiscard]] inline bool approaches(double u_n, double speed) { return u_n < -approach * speed; }
[[nodiscard]] inline bool sticks(double u_f, double speed) { return u_f <= slip * speed; }
/// Friction of size p_f on its bound [N s].
[[nodiscard]] inline bool on_bound(double p_f, double bound) { return p_f >= (1 - inside_cone) * bound; }
[[nodiscard]] inline bool loaded(double p_n) { return p_n > 0; }

/// Whether a row of these two bodies is an equation of angles: it has no lever on any body's position.
[[nodiscard]] bool is_angular(const Model& model, const WrenchMap<3>& W, int column);

/// What psi of a contact cannot be known below [m; rad of an angular one]: rounding of the positions and levers that it is the
/// difference of.
[[nodiscard]] double gap_rounding(const Model& model, const Instant& s, const State& x,
                                  const ContactInstant& c);

/// The same of a joint's equation [m, rad].
[[nodiscard]] double joint_rounding(const Model& model, const Instant& s, const JointRowInstant& row);

/// The largest |psi_b| in units of its rounding [-].
[[nodiscard]] double joint_misfit(const Model& model, const Instant& s);

}  // namespace perp::closeness
