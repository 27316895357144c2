// A step's reactions in the modes of its answer: equations that can be differentiated.
#pragma once

#include <Eigen/LU>
#include <Eigen/QR>
#include <span>
#include <string>

#include "step/implicit/step_problem.hpp"

namespace perp {

/// The mode of a reaction.
enum class Held {
  Open,    ///< p = 0
  Rests,   ///< u = 0 in all its rows: joints' equations, contacts without friction and those that stick
  Slides,  ///< u_n = 0, p_f = -mu p_n u_f/|u_f|; a joint's friction at its bound
  Tied     ///< u_n = 0, p_f = -mu p_n d: d is known, of a first stage
};

struct HeldMode {
  Held held = Held::Open;
  Vector3 d = Vector3::Zero();  ///< along t, o: of Tied; of Slides the direction of u_f
};

/// The mode of r by its p and u; `border` says where it lies on one ("" if on none). `speed` is the largest of the step's.
[[nodiscard]] HeldMode mode_of(const Reaction& r, double speed, std::string& border);

/// The unit direction of u_f; of a joint's friction its sign.
[[nodiscard]] Vector3 sliding_direction(const Reaction& r);

/// Unknowns p of all reactions that are not open, in their order.
[[nodiscard]] int unknowns_of(std::span<const Reaction> all, std::span<const HeldMode> modes);

/// R - sum W p and the laws' left-hand sides, as many as unknowns: d of Tied ones as they have it, of Slides from u.
void held_equations(std::span<const Reaction> all, std::span<const HeldMode> modes, const Vector& R,
                    Vector& out);

/// The entries of z past nu as impulses: p += t z.
void add_impulses(std::span<const HeldMode> modes, const Vector& z, double t, std::span<Reaction> all);

/// K dnu - sum W dp and the laws' slopes as one matrix in (nu, p), factored. Rows that repeat each other (a table's fourth leg) leave
/// dp open: the shortest is taken.
class HeldSystem {
 public:
  /// Why it cannot be solved, or "": then solve() has dnu that does not depend on how redundant reactions share.
  std::string factor(const Model& model, const std::vector<Coupling>& K, std::span<const Reaction> all,
                     std::span<const HeldMode> modes);
  [[nodiscard]] Vector solve(const Vector& rhs) const;
  /// How far A z is from rhs, of both [-]: rows that contradict each other have no solution.
  [[nodiscard]] double miss(const Vector& z, const Vector& rhs) const;

 private:
  Vector rows_, columns_;  // that A is scaled by
  Matrix A_;
  Eigen::PartialPivLU<Matrix> lu_;
  Eigen::CompleteOrthogonalDecomposition<Matrix> cod_;
  bool redundant_ = false;
};

}  // namespace perp
