// The system between events: with the modes of contacts and joints known, a differential equation.
#pragma once

#include <vector>

#include "instant/row_factors.hpp"
#include "step/acceleration_biases.hpp"
#include "step/modes.hpp"

namespace perp {

/// What the forces of a state do in a unit of time, and what impulses along its rows L do.
struct ModeKick {
  Vector free;              ///< (nv) M^-1 k
  Rows::Response response;  ///< M^-1 L
};

/// In fixed modes every closed contact and every joint is a set of equations, and forces c along some rows R follow from
///   M nu' = k + L c,   R^T nu' + b = 0     =>     (R^T M^-1 L) c = -(R^T M^-1 k + b).
/// Rows: each joint row; n of each closed contact; t, o of those that stick; the frictions of joints at rest. A column of L is
/// that of R but for sliding contacts, where it has the friction: n - mu d, d the direction of sliding.
///
/// Rows that repeat each other (a table's fourth leg, a spatial four-bar) leave forces open; those taken are the limit of rows that give
/// a little: Z^T C c = 0, Z a basis of R Z = 0, C the compliances of the rows. So c = V z, V a basis of what is across C Z; R alone, not
/// masses, tells which rows repeat each other.
class ModeDynamics {
 public:
  explicit ModeDynamics(const Model& model) : model_(model) {}

  /// From here on in these modes; their directions of sliding count where |u_f| <= small_speed. Returns what is wrong with x ("" if nothing).
  std::string begin(const State& x, const Modes& modes, double small_speed);

  double speed_error = 0;  ///< [m/s] of the integrator: what is much slower than it has no direction

  /// nu' at x, with `force` and the others below; false where the system cannot be evaluated.
  bool evaluate(const State& x);

  /// x moved onto the constraints of the modes, positions by the shortest way in the norm of M, then velocities. Angles and
  /// quaternions as they are, but for unit length. Returns the largest violation left, psi [m, rad] (u is exact to rounding).
  double project(State& x);

  /// For half-explicit steps: from where rows() or turn() was last.
  void kick(ModeKick& out) const;
  /// After rows(x): the impulses z along the rows of `from` with which nu + M^-1 L z obeys the velocity equations at x, added to x.nu.
  bool meet(const ModeKick& from, State& x, Vector& z);
  /// Loads and directions of friction at x, of which only the velocities have changed since rows().
  void turn(const State& x);

  /// A step starts at x, where evaluate() or rows() was last: directions of sliding are held against those of x from here on.
  void begin_step(const State& x);

  /// u_f . d of closed contact i, d its direction at the start of the step, where evaluate() or rows() was last; |u_f| where it
  /// started from rest.
  double sliding_speed(const State& x, std::size_t i) const;
  /// Its rate, after evaluate().
  double sliding_acceleration(std::size_t i) const;
  /// The rate's rate of joint friction i, after evaluate().
  double joint_acceleration(std::size_t i) const;
  /// Whether what is left of u_f, where u_f . d has become zero, is less than is known of it.
  bool as_good_as_stopped(const State& x, std::size_t i) const;
  /// The direction that friction opposes there.
  Vector3 sliding_direction(const State& x, std::size_t i) const;

  /// q' of (6), quaternions as derivatives of their components.
  void kinematic_map(const State& x, Vector& q_dot) const;

  const Model& model() const { return model_; }
  const Modes& modes() const { return modes_; }
  const Instant& instant() const { return s_; }

  Vector nu_dot;               ///< (nv) after evaluate
  std::vector<Vector3> force;  ///< of each closed contact, along n, t, o
  Vector joint_force;          ///< of each joint friction
  double stabilise = 0;        ///< [1/s] rate at which evaluate() makes violations decay; 0: not at all
  long evaluations = 0;        ///< calls to evaluate

  // For the differential-algebraic form, which eliminates nothing: rows at x with `rows(x)`, then
  int row_count() const { return rows_.size(); }
  bool rows(const State& x);                                    ///< fills those below
  Matrix R() const { return rows_.dense(false, model_.nv()); }  ///< (nv, m)
  Matrix L() const { return rows_.dense(true, model_.nv()); }   ///< (nv, m)
  const Vector& load() const { return load_; }          ///< k with the friction of joints that slide
  const Vector& velocity() const { return velocity_; }  ///< (m) R^T nu + explicit part
  const Vector& gap() const { return gap_; }            ///< (m) psi of rows that are constraints on q
  const std::vector<int>& position_rows() const { return position_rows_; }  ///< of the rows those with a psi
  bool redundant() const { return redundant_; }                             ///< some row repeats others
  Matrix basis() const;           ///< (m, r), empty if no row repeats another
  Matrix position_basis() const;  ///< the same of the position rows
  const Vector& multipliers() const { return c_; }              ///< of the last evaluate

 private:
  void assemble(const State& x);
  void arrange();
  void find_basis();
  bool repeats();
  [[nodiscard]] Matrix basis_of(const RowFactors& factors) const;
  double slow() const;
  Vector3 friction_direction(const ContactInstant& c, std::size_t i, const Vector3& u) const;

  const Model& model_;
  Modes modes_;
  std::vector<Vector3>
      direction_;  // of each closed contact that slides, at the start of the step, world axes
  double small_speed_ = 0;
  std::vector<double> speed_;    // |u_f| there
  std::vector<double> fastest_;  // the largest |u_f| so far
  std::vector<char> straight_;   // as good as stopped: the direction stays
  std::vector<char> from_rest_;  // it began to slide and is slow: the direction is that in which it began
  Instant s_;
  AccelerationBiases biases_;
  std::vector<int> asked_;
  Rows rows_;
  Rows::Response Y_;
  RowFactors all_, positions_;  // of all rows, and of those that are constraints on q
  bool redundant_ = false;
  Vector compliance_, load_, velocity_, gap_, bias_, free_, b_, c_, scratch_;
  std::vector<int> position_rows_;
};

}  // namespace perp
