// Redundant contacts and joints of the seed's LCP: of its solutions the one that all methods take.
#pragma once

#include "perp/solve/lemke.hpp"
#include "perp/step/polygonal_lcp.hpp"
#include "solve/friction/vanishing_compliance.hpp"

namespace perp {

/// What a contact or a joint's friction does.
struct PolygonalMode {
  enum class Kind { Open, Rest, Slide } kind = Kind::Open;
  // columns of PolygonalLcp, if it slides: vertices of the polygon that its friction is at or between; the vertex before these
  int first = -1, second = -1, last = -1;
};

/// The modes that solved an island's problem, and its contact points, which tell it from others.
struct KeptModes {
  std::vector<int> points;
  std::vector<PolygonalMode> contacts, frictions;
};

/// Lemke's method answers (39) with a vertex, which puts all load on as few contacts as can bear it. This takes its place with the
/// limit of contacts and joints that give a little, all alike (VanishingCompliance): in the modes of the last step if the limit fits
/// them, which spares Lemke's path; in those of the vertex; else in those of an LCP whose rows give a little.
class PolygonalSharing {
 public:
  /// An island's problem; `lcp` has its unknowns listed, scaled.
  struct Problem {
    const Model& model;
    const ReducedSystem& reduced;
    const Instant& instant;
    const Island& island;
    const PolygonalTerms& terms;
    const PolygonalLcp& lcp;
    const std::vector<int>& points;
    LemkeSolver& lemke;
  };

  /// Impulses r and the solution z with them, in kept modes; false, and nothing found, if they are another problem's or no longer
  /// fit.
  bool again(const Problem& problem, const KeptModes& kept, Vector& z, Vector& r);

  /// `lcp` is filled, z solves it, and r are its impulses: those of the limit take their place, and `kept` its modes. If there is no
  /// limit or it was not found, all stay, and nothing is kept.
  void share(const Problem& problem, KeptModes& kept, Vector& z, Vector& r);

 private:
  using Kind = PolygonalMode::Kind;

  void begin(const Problem& problem);
  void make_room();
  void modes_by_velocity();
  void modes_by_solution(const Vector& z);
  bool solve();
  void tie(std::size_t contact);
  bool settle();
  bool soften();
  bool negative(double v, double v_1) const;
  int fastest(int first, int end) const;
  bool fits();
  bool fits(std::size_t group, int first, int end) const;
  void mend();
  PolygonalMode& mode_of(std::size_t group);
  const PolygonalMode& mode_of(std::size_t group) const;
  double along(int column, const Vector& x) const;
  double bound_of(std::size_t group) const;

  const Problem* problem_ = nullptr;
  double small_ = 0, small_1_ = 0;  // of velocities [m/s], and of what rows give
  std::vector<PolygonalMode> contacts_, frictions_;
  Matrix C_, A_, A_C_;
  Vector k_, q_, u_, r_, b_, b_k_, scale_, r_1_, u_1_;
  VanishingCompliance limit_;
  ReducedSystem soft_;
  PolygonalLcp soft_lcp_;
  LcpSolution solution_;
};

}  // namespace perp
