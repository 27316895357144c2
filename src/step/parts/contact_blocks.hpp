// Contacts as blocks of a friction problem, and what their friction is where they slide or roll: one place for impacts, CP1, and steps across.
#pragma once

#include <vector>

#include "perp/instant/instant.hpp"
#include "perp/solve/friction_problem.hpp"
#include "step/modes/modes.hpp"

namespace perp {

/// Blocks of a friction problem over the rows of a ReducedSystem, one after the other.
class ContactBlocks {
 public:
  /// Contact c; what slides or rolls is no unknown of the problem's. `row` is that of its n. Returns the rows that stay.
  int add(const Instant& s, const ContactInstant& c, int row, bool slides = false, bool rolls = false);
  void add_interval(int row, double bound);
  /// Without rows: a block without moments, of a contact or with a bound of its own; one with, of 1 or 2 tangents.
  void add(BlockKind kind, double mu) { add(kind, mu, mu, 0, 0); }
  void add_with_moments(int tangents, double mu, double mu_o, double torsion, double rolling);
  /// kinds and sizes of all, in their order.
  void give(FrictionProblem& problem) const;

  std::vector<int> rows;  ///< that stay, of the reduced system

 private:
  void add(BlockKind kind, double mu, double mu_o, double torsion, double rolling);

  std::vector<BlockKind> kinds_;
  std::vector<double> mu_, mu_o_, torsion_, rolling_;
  bool ellipses_ = false, torsions_ = false, rollings_ = false;
};

/// First row of a contact's moments, in a ReducedSystem where its n is at `row`.
[[nodiscard]] inline int moment_row(const ContactInstant& c, int row) { return row + 1 + c.tangents; }

/// What a contact with moments slides at, over its directions that have friction: u_f in the plane and lever w_n along n, world axes. (Of a
/// contact without moments: u_f.) For accelerations likewise.
[[nodiscard]] Vector3 slip_of(const ContactInstant& c, const MomentInstant* m, const Vector3& u,
                              const Vector3& omega, double lever);
/// And what it rolls at, times the lever; zero without rolling.
[[nodiscard]] Vector3 roll_of(const ContactInstant& c, const MomentInstant* m, const Vector3& omega,
                              double lever);

/// Friction of a contact with moments over its normal force: along t, o [-] and about n, t, o [m].
struct FrictionShare {
  Vector2 force = Vector2::Zero();
  Vector3 moment = Vector3::Zero();
};
/// Of what slides along `slip`, a direction of slip_of, and rolls along `roll`, one of roll_of; each zero where it rests.
[[nodiscard]] FrictionShare friction_share(const ContactInstant& c, const MomentInstant& m,
                                           const Vector3& slip, const Vector3& roll, double lever);

/// The normal force for which a contact's friction and moments are just on their bounds, of group 1 and 2. `f` along n, t, o, `moment`
/// about them.
[[nodiscard]] double sliding_pull(const ContactInstant& c, const MomentInstant& m, const Vector3& f,
                                  const Vector3& moment, double lever);
[[nodiscard]] double rolling_pull(const MomentInstant& m, const Vector3& moment);
/// The direction of slip_of, of roll_of that friction on its bound opposes, if it is any.
[[nodiscard]] Vector3 slip_against(const ContactInstant& c, const MomentInstant* m, const Vector3& f,
                                   const Vector3& moment, double lever);
[[nodiscard]] Vector3 roll_against(const ContactInstant& c, const MomentInstant* m, const Vector3& moment);

}  // namespace perp
