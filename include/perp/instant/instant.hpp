// What the system is like at one state: the one question that every method asks.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "perp/model/model.hpp"
#include "perp/model/point_table.hpp"

namespace perp {

/// A wrench map W over the two bodies that it touches, as two small blocks; C columns, one a direction. A body's block has a
/// row for each of its velocities (none for the ground and for prescribed bodies):
///   nu-space impulse = W p,   relative velocity = W^T nu + (explicit part).
template <int C>
struct WrenchMap {
  using Columns = Eigen::Matrix<double, C, 1>;
  using Block = Eigen::Matrix<double, 6, C>;
  int a = 0, b = 0;                            ///< indices of the two bodies
  int va = 0, na = 0;                          ///< first velocity and number of velocities of body a
  int vb = 0, nb = 0;                          ///< of body b
  Block A = Block::Zero(), B = Block::Zero();  ///< rows past na and nb are zero

  /// W^T nu over the system's velocities.
  Columns velocity(const Vector& nu) const {
    Columns u = Columns::Zero();
    for (int c = 0; c < C; ++c) {
      for (int i = 0; i < na; ++i) u[c] += A(i, c) * nu[va + i];
      for (int i = 0; i < nb; ++i) u[c] += B(i, c) * nu[vb + i];
    }
    return u;
  }

  void connect(const Model& model, BodyId first, BodyId second) {
    const Body &body_a = model.body(first), &body_b = model.body(second);
    a = first.index, va = body_a.v0, na = body_a.nv;
    b = second.index, vb = body_b.v0, nb = body_b.nv;
  }

  /// out += W p.
  void add_impulse(const Columns& p, Vector& out) const {
    for (int c = 0; c < C; ++c) {
      for (int i = 0; i < na; ++i) out[va + i] += A(i, c) * p[c];
      for (int i = 0; i < nb; ++i) out[vb + i] += B(i, c) * p[c];
    }
  }
};

/// A contact point whose gap exists now.
struct ContactInstant {
  int contact = 0;                      ///< number, Model::contact
  int point = 0;                        ///< among all points of the model
  int slot = 0;                         ///< among those of its contact
  double psi_n = 0;                     ///< gap [m]
  Vector3 position = Vector3::Zero();   ///< where impulses act, world axes [m]
  Matrix3 frame = Matrix3::Identity();  ///< columns n, t, o in world axes
  Vector3 wish = Vector3::UnitX();      ///< t is its projection across n
  int tangents = 0;                     ///< friction directions in use: 0, 1 (t) or 2 (t, o)
  WrenchMap<3> W;                       ///< columns n, t, o: W_n and W_f of (24)
  Vector3 bias = Vector3::Zero();       ///< explicit velocities: (dPsi_n/dt, dphi_f/dt) (erratum 30) [m/s]
  double mu = 0, e = 0;
  int moments = -1;  ///< in Instant::moments, of a contact that has_ellipse()

  /// Relative velocity of b over a along n, t, o [m/s].
  Vector3 velocity(const Vector& nu) const { return W.velocity(nu) + bias; }
};

/// What a contact with torsion, rolling or friction axes has besides: moments on b about n, t, o, and b's angular velocity relative
/// to a. Columns that the contact has no use for are zero: n without torsion, t, o without rolling.
struct MomentInstant {
  WrenchMap<3> W;                   ///< of unit moments about n, t, o
  Vector3 bias = Vector3::Zero();   ///< explicit angular velocities, of prescribed bodies [rad/s]
  double mu_o = 0;                  ///< friction along o [-]; mu is that along t
  double torsion = 0, rolling = 0;  ///< [m]

  Vector3 velocity(const Vector& nu) const { return W.velocity(nu) + bias; }

  /// Whether the contact has friction along any of t, o, n.
  bool has_sliding(double mu) const { return mu > 0 || mu_o > 0 || torsion > 0; }
  /// Rows that a contact of so many tangents has of them: torsion, then rolling about t and o (in the plane about o).
  int rows(int tangents) const { return (torsion > 0 ? 1 : 0) + (rolling > 0 ? tangents : 0); }
  /// The columns of W that they are.
  std::array<int, 3> columns(int tangents) const {
    if (torsion > 0) return {0, 1, 2};
    return {3 - tangents, 2, 2};
  }
};

/// One equation of a joint, a coordinate of a joint, or (as `friction`) the one along which a joint has friction.
struct JointRowInstant {
  int joint = 0;                    ///< in Model::joints()
  int row = -1;                     ///< in JointGeometry::rows; -1: made of a coordinate
  int coordinate = -1;              ///< of coordinates, friction, and the equation of a prescribed motion
  bool prescribed = false;          ///< the equation coordinate - position(t) = 0 of a JointMotion
  double psi_b = 0;                 ///< [m] or [rad]; of friction rows the joint's coordinate
  double psi_b_t = 0;               ///< explicit time derivative [m/s, rad/s]
  double friction = 0;              ///< c_max [N, N m]; 0 in equations
  WrenchMap<1> W;                   ///< W_b of (24)
  JointRowValue world;              ///< the row in world axes: force and moment of a unit impulse on b
  Vector3 point = Vector3::Zero();  ///< c_B, where its force acts, world axes [m]

  double velocity(const Vector& nu) const { return W.velocity(nu)[0] + psi_b_t; }
};

/// Everything the equations of motion (24) and the constraints (7), (8) need at one state. Refilled by `evaluate`; it
/// allocates nothing while the model stays the same.
struct Instant {
  double t = 0;
  std::vector<Pose> X;   ///< X_WB of every body
  std::vector<Twist> V;  ///< its twist, world axes
  Vector nu;             ///< x.nu
  Vector k;              ///< g_ext with the gyroscopic terms (erratum 4), in nu's axes [N, N m]
  Vector
      k_load;  ///< the part of k that takes energy in or out: forces and dampers; empty without forces and springs
  Vector k_motor;                           ///< and that of motors; empty without motors
  std::vector<ContactInstant> contacts;     ///< points with a finite gap, in the model's order
  std::vector<MomentInstant> moments;       ///< of those of them that have torsion or rolling
  std::vector<JointRowInstant> joint_rows;  ///< psi_b = 0, in the model's order
  std::vector<JointRowInstant> joint_frictions;
  std::vector<JointRowInstant> joint_coordinates;  ///< of all joints, in the model's order
  std::vector<int> first_coordinate;               ///< of each joint, in joint_coordinates

  /// Empty, or what was not finite: "gap of contact 'floor' is nan at t = 0.3". The rest is then incomplete.
  std::string fault;

  /// Null of a contact without torsion and rolling.
  const MomentInstant* moments_of(const ContactInstant& c) const {
    return c.moments < 0 ? nullptr : &moments[static_cast<std::size_t>(c.moments)];
  }

  const JointRowInstant& coordinate(JointId joint, int i) const {
    return joint_coordinates[static_cast<std::size_t>(
        first_coordinate[static_cast<std::size_t>(joint.index)] + i)];
  }

  double gap_min() const;      ///< min psi_n [m]; infinity without contacts
  double joint_error() const;  ///< max |psi_b| [m, rad]; 0 without joints

  struct GeneralizedMass {
    int body;           ///< in Model::bodies()
    Matrix M, inverse;  ///< (nv, nv) at q
  };
  std::vector<GeneralizedMass> masses;  ///< of generalized bodies, in the model's order

  PointTable<int> contact_of_point{-1};  ///< of each point of the model, its entry in `contacts`, or -1
  std::vector<Matrix3> R;                ///< X's rotations, as matrices
  std::vector<ContactPoint> points;      ///< scratch
};

/// Fills `instant` with the system at x. Sizes are the caller's duty (Model::check). With `like`, tangents t are those of
/// the contact points there, turned with the normal as little as can be: a method that compares two states keeps its axes.
/// `only` are the contacts to look at, ascending; all that may touch if null.
void evaluate(const Model& model, const State& x, Instant& instant, const Instant* like = nullptr,
              const std::vector<int>* only = nullptr);

/// The part of it that does not depend on contacts: poses, twists, k, and the joints if k depends on them. For other velocities
/// at the same q.
void evaluate_loads(const Model& model, const State& x, Instant& instant);

/// M^-1 f for a vector of the system's velocity space; M is block diagonal, and in nu's axes constant but for generalized bodies,
/// of which it is that of the instant.
void solve_mass(const Model& model, const Instant& instant, const Vector& f, Vector& out);
/// M nu.
void multiply_mass(const Model& model, const Instant& instant, const Vector& nu, Vector& out);
/// The part of the body of that index: f and out have its nv entries.
void solve_mass(const Model& model, const Instant& instant, int body, const double* f, double* out);

}  // namespace perp
