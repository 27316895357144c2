// The system between events: with the modes of contacts and joints known, a differential equation.
#pragma once

#include <Eigen/LU>
#include <vector>

#include "step/events/acceleration_biases.hpp"
#include "step/modes/modes.hpp"
#include "step/parts/contact_blocks.hpp"

namespace perp {

/// What the forces of a state do in a unit of time, and what impulses along its rows L do.
struct ModeKick {
  Vector free;      ///< (nv) M^-1 k
  Matrix response;  ///< (nv, m) M^-1 L
};

/// What of a contact moves: it slides (and spins), or it rolls.
enum class Moving { Slip, Roll };

/// u_f in world axes, of u along n, t, o.
inline Vector3 tangential(const ContactInstant& c, const Vector3& u) {
  Vector3 u_f = Vector3::Zero();
  for (int t = 1; t <= c.tangents; ++t) u_f += u[t] * c.frame.col(t);
  return u_f;
}

/// In fixed modes every closed contact and every joint is a set of equations, and forces c along some rows R follow from
///   M nu' = k + L c,   R^T nu' + b = 0     =>     (R^T M^-1 L) c = -(R^T M^-1 k + b).
/// Rows: each joint row; n of each closed contact; t, o of those that stick; the frictions of joints at rest. A column of L is
/// that of R but for sliding contacts, where it has the friction: n - mu d, d the direction of sliding. Contacts with moments have rows
/// of these too, and in the column of n what friction_share says of those that move.
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
  /// started from rest. Of contacts with moments slip_of, or roll_of, is meant.
  double sliding_speed(const State& x, std::size_t i, Moving what = Moving::Slip) const;
  /// |u_f|.
  double speed(const State& x, std::size_t i, Moving what = Moving::Slip) const {
    return velocity_of(x, i, what).norm();
  }
  /// The rate of sliding_speed, after evaluate().
  double sliding_acceleration(std::size_t i, Moving what = Moving::Slip) const;
  /// The rate's rate of joint friction i, after evaluate().
  double joint_acceleration(std::size_t i) const;
  /// Whether what is left of u_f, where u_f . d has become zero, is less than is known of it.
  bool as_good_as_stopped(const State& x, std::size_t i, Moving what = Moving::Slip) const;
  /// The direction that friction opposes there.
  Vector3 sliding_direction(const State& x, std::size_t i, Moving what = Moving::Slip) const;
  /// Friction over the normal force of what of closed contact i moves.
  FrictionShare sliding_share(const State& x, std::size_t i) const;

  /// column(force, moment) for every column of L that is closed contact i's: along and about n, t, o, where rows() or turn() was last.
  template <class Column>
  void for_columns(const State& x, std::size_t i, const Column& column) const;

  /// q' of (6), quaternions as derivatives of their components.
  void kinematic_map(const State& x, Vector& q_dot) const;

  const Model& model() const { return model_; }
  const Modes& modes() const { return modes_; }
  const Instant& instant() const { return s_; }

  Vector nu_dot;                ///< (nv) after evaluate
  std::vector<Vector3> force;   ///< of each closed contact, along n, t, o
  std::vector<Vector3> moment;  ///< and about them; empty where no contact has moments
  Vector joint_force;           ///< of each joint friction
  double stabilise = 0;         ///< [1/s] rate at which evaluate() makes violations decay; 0: not at all
  long evaluations = 0;         ///< calls to evaluate

  // For the differential-algebraic form, which eliminates nothing: rows at x with `rows(x)`, then
  int row_count() const { return static_cast<int>(R_.cols()); }
  bool rows(const State& x);                            ///< fills the four below
  const Matrix& R() const { return R_; }                ///< (nv, m)
  const Matrix& L() const { return L_; }                ///< (nv, m)
  const Vector& load() const { return load_; }          ///< k with the friction of joints that slide
  const Vector& velocity() const { return velocity_; }  ///< (m) R^T nu + explicit part
  const Vector& gap() const { return gap_; }            ///< (m) psi of rows that are constraints on q
  const std::vector<int>& position_rows() const { return position_rows_; }  ///< of the rows those with a psi
  const Matrix& basis() const { return V_; }                    ///< (m, r), empty if no row repeats another
  const Matrix& position_basis() const { return V_position_; }  ///< the same of the position rows
  const Vector& multipliers() const { return c_; }              ///< of the last evaluate

 private:
  void assemble(const State& x);
  void find_basis();
  [[nodiscard]] Matrix repeated(const std::vector<int>& rows, double threshold) const;
  double slow() const;
  /// How one group of a closed contact moves.
  struct Sliding {
    Vector3 direction = Vector3::Zero();  // at the start of the step, world axes
    double speed = 0;                     // |u_f| there
    double fastest = 0;                   // the largest |u_f| so far
    bool straight = false;                // as good as stopped: the direction stays
    bool from_rest = false;  // it began to slide and is slow: the direction is that in which it began
  };
  const ContactInstant& contact(std::size_t i) const {
    return s_.contacts[static_cast<std::size_t>(asked_[i])];
  }
  const Sliding& sliding(std::size_t i, Moving what) const {
    return (what == Moving::Slip ? slips_ : rolls_)[i];
  }
  bool moves(std::size_t i, Moving what) const {
    return what == Moving::Slip ? modes_.contacts[i].slides : modes_.contacts[i].rolls;
  }
  Vector3 velocity_of(const State& x, std::size_t i, Moving what) const;
  /// row(moments, column) for every row of closed contact i: of the contact's W, or of its moments'.
  template <class Row>
  void for_rows(std::size_t i, const Row& row) const;
  void begin_step(const State& x, std::size_t i, Moving what);
  Vector3 friction_direction(const ContactInstant& c, std::size_t i, Moving what, const Vector3& u_f) const;

  const Model& model_;
  Modes modes_;
  double small_speed_ = 0;
  std::vector<Sliding> slips_, rolls_;  // of each closed contact
  Instant s_;
  AccelerationBiases biases_;
  std::vector<int> asked_;
  Matrix R_, L_, Y_, N_, Z_, V_, V_position_;
  Vector compliance_, load_, velocity_, gap_, bias_, free_, b_, c_;
  std::vector<int> position_rows_;
  Eigen::PartialPivLU<Matrix> lu_;
};

template <class Row>
void ModeDynamics::for_rows(std::size_t i, const Row& row) const {
  const ContactInstant& c = contact(i);
  const MomentInstant* m = s_.moments_of(c);
  row(false, 0);
  const bool sticks = !modes_.contacts[i].slides;
  for (int t = 1; sticks && t <= c.tangents; ++t)
    if (m == nullptr || (t == 1 ? c.mu : m->mu_o) > 0) row(false, t);
  if (m == nullptr) return;
  if (sticks && m->torsion > 0) row(true, 0);
  for (int t = 3 - c.tangents; t <= 2 && m->rolling > 0 && !modes_.contacts[i].rolls; ++t) row(true, t);
}

template <class Column>
void ModeDynamics::for_columns(const State& x, std::size_t i, const Column& column) const {
  const FrictionShare share = sliding_share(x, i);
  for_rows(i, [&](bool moments, int k) {
    Vector3 f = Vector3::Zero(), tau = f;
    (moments ? tau : f)[k] = 1;
    if (!moments && k == 0) {
      f.tail<2>() = share.force;
      tau = share.moment;
    }
    column(f, tau);
  });
}

/// An orthonormal basis of the range of the symmetric positive semidefinite N, after its diagonal is scaled to 1, scaled back;
/// empty if N has full rank.
[[nodiscard]] Matrix range_basis(const Matrix& N);

}  // namespace perp
