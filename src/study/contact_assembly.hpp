// Rigid bodies at one instant, gathered into a friction problem: what the families are made with.
#pragma once

#include <cstdint>
#include <vector>

#include "perp/solve/friction_problem.hpp"

namespace perp {

/// Random numbers that are the same everywhere: SplitMix64 [SLF14].
class Random {
 public:
  explicit Random(std::uint64_t seed) : state_(seed) {}
  std::uint64_t bits();
  double uniform(double low, double high);
  double decades(double low, double high);  ///< 10^uniform(low, high)
  int integer(int low, int high);           ///< low <= i <= high
  bool chance(double probability) { return uniform(0, 1) < probability; }
  Vector3 vector(double size);  ///< entries uniform in [-size, size]

 private:
  std::uint64_t state_;
};

/// Free bodies with velocities and the impulses of one step's loads, and the contacts between them.
class ContactAssembly {
 public:
  static constexpr int fixed = -1;  ///< the world

  explicit ContactAssembly(double step) : h_(step) {}

  /// A box with the given full sides [m] whose axes are the columns of R. Returns its number.
  int add_box(double mass, const Vector3& sides, const Matrix3& R, const Vector3& position);
  int add_sphere(double mass, double radius, const Vector3& position);
  int add_body(double mass, const Matrix3& inertia, const Vector3& position);

  void set_velocity(int body, const Vector3& v, const Vector3& w);
  void push(int body, const Vector3& force) { bodies_[body].force += force; }
  void gravity(const Vector3& g);

  /// A contact at `point` with the normal from a to b; `gap` >= 0 enters as gap/h, the restitution e as e times
  /// the approach speed where the gap is closed.
  void add_contact(int a, int b, const Vector3& point, const Vector3& normal, double mu, double gap = 0,
                   double e = 0);
  /// Bounds of contact's moments over its normal reaction [m]. If any contact was given `torsion` (`rolling`), all have the rows.
  void set_torsion(int contact, double torsion) { contacts_[contact].torsion = torsion, has_torsion_ = true; }
  void set_rolling(int contact, double rolling) { contacts_[contact].rolling = rolling, has_rolling_ = true; }
  void set_mu(int contact, double mu) { contacts_[contact].mu = mu; }
  /// Lets the first side of a contact move with `velocity` (a wall on its own course).
  void move(int contact, const Vector3& velocity) { contacts_[contact].wall = velocity; }

  int bodies() const { return static_cast<int>(bodies_.size()); }
  int contacts() const { return static_cast<int>(contacts_.size()); }
  const Vector3& position(int body) const { return bodies_[body].position; }

  /// M v = H r + f, u = Hᵀ v + w of the backward Euler step.
  FrictionProblem problem() const;

 private:
  struct Body {
    double mass;
    Matrix3 inertia;
    Vector3 position, v, w, force;
  };
  struct Contact {
    int a, b;
    Vector3 point, normal;
    double mu, gap, e;
    Vector3 wall = Vector3::Zero();
    double torsion = 0, rolling = 0;
  };
  double h_;
  bool has_torsion_ = false, has_rolling_ = false;
  std::vector<Body> bodies_;
  std::vector<Contact> contacts_;
};

}  // namespace perp
