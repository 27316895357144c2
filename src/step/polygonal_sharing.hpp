// Redundant contacts and joints of the seed's LCP: of its solutions the one that all methods take.
#pragma once

#include "perp/solve/lemke.hpp"
#include "perp/step/polygonal_lcp.hpp"
#include "solve/vanishing_compliance.hpp"

namespace perp {

/// Lemke's method answers (39) with a vertex, which puts all load on as few contacts as can bear it. This takes its place with the
/// limit of contacts and joints that give a little, all alike (VanishingCompliance), in the modes of the vertex if the limit
/// fits them, else in those of an LCP whose rows give a little. Allocates nothing while sizes stay the same.
class PolygonalSharing {
 public:
  /// Whether an island can have redundant reactions.
  static bool possible(const Island& island) {
    const std::size_t acting = island.contacts.size() + island.joint_frictions.size();
    return acting > 1 || (acting == 1 && !island.joint_rows.empty());
  }

  /// `polygonal` is assembled, scaled, from the same arguments; z solves it and r are its impulses. False, and both as they were, if
  /// there is no limit or it was not found.
  bool share(const Model& model, const ReducedSystem& reduced, const Instant& instant, const Island& island,
             const PolygonalTerms& terms, const PolygonalLcp& polygonal, Vector& z, Vector& r);

 private:
  enum class Mode { Open, Rest, Slide };
  /// What a normal impulse or a joint's friction does, and the friction of its contact.
  struct Place {
    Mode mode = Mode::Open;
    // columns of PolygonalLcp: vertices that friction is at or between, if it slides; the one before
    int first = -1, second = -1, last = -1;
  };
  /// One unknown: a direction of r, and the row that it ties.
  struct Tied {
    int row = 0, rows = 0;                      // first and number of the entries that follow
    Vector3 acts = Vector3::Zero(), on = acts;  // along r; of u
  };

  void modes_by_velocity();
  void modes_by_solution(const Vector& z);
  void tie();
  bool solve();
  bool settle();
  bool soften();
  bool negative(double v, double v_1) const;
  int fastest(int first, int end) const;
  bool fits();
  void mend();
  Place& place_of(std::size_t group);
  double along(int column, const Vector& x) const;
  double gap(std::size_t contact) const;

  const ReducedSystem* reduced_ = nullptr;
  const Instant* instant_ = nullptr;
  const Island* island_ = nullptr;
  const PolygonalTerms* terms_ = nullptr;
  const PolygonalLcp* lcp_ = nullptr;
  double small_ = 0, small_1_ = 0;  // of velocities [m/s], and of what rows give
  std::vector<Place> contacts_, frictions_;
  std::vector<Tied> tied_;
  Matrix C_, A_, C_tied_;
  Vector k_, q_, known_, u_, r_, b_, k_tied_, scale_, y_, y_1_, r_1_, u_1_;
  VanishingCompliance limit_;
  ReducedSystem soft_;
  PolygonalLcp soft_lcp_;
  LemkeSolver lemke_;
  LcpSolution solution_;
};

}  // namespace perp
