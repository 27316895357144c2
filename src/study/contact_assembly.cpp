#include "contact_assembly.hpp"

#include <algorithm>
#include <cmath>

namespace perp {

std::uint64_t Random::bits() {
  std::uint64_t z = (state_ += 0x9e3779b97f4a7c15u);
  z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
  z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
  return z ^ (z >> 31);
}

double Random::uniform(double low, double high) {
  return low + (high - low) * (static_cast<double>(bits() >> 11) * 0x1p-53);
}

double Random::decades(double low, double high) { return std::pow(10.0, uniform(low, high)); }

int Random::integer(int low, int high) {
  return low + static_cast<int>(bits() % static_cast<std::uint64_t>(high - low + 1));
}

Vector3 Random::vector(double size) {
  const double x = uniform(-size, size), y = uniform(-size, size), z = uniform(-size, size);
  return {x, y, z};
}

int ContactAssembly::add_body(double mass, const Matrix3& inertia, const Vector3& position) {
  bodies_.push_back({mass, inertia, position, Vector3::Zero(), Vector3::Zero(), Vector3::Zero()});
  return static_cast<int>(bodies_.size()) - 1;
}

int ContactAssembly::add_box(double mass, const Vector3& sides, const Matrix3& R, const Vector3& position) {
  const Vector3 squares = sides.cwiseAbs2();
  const Vector3 principal = mass / 12 * (Vector3::Constant(squares.sum()) - squares);
  return add_body(mass, R * principal.asDiagonal() * R.transpose(), position);
}

int ContactAssembly::add_sphere(double mass, double radius, const Vector3& position) {
  return add_body(mass, 0.4 * mass * radius * radius * Matrix3::Identity(), position);
}

void ContactAssembly::set_velocity(int body, const Vector3& v, const Vector3& w) {
  bodies_[body].v = v;
  bodies_[body].w = w;
}

void ContactAssembly::gravity(const Vector3& g) {
  for (Body& body : bodies_) body.force += body.mass * g;
}

void ContactAssembly::add_contact(int a, int b, const Vector3& point, const Vector3& normal, double mu,
                                  double gap, double e) {
  contacts_.push_back({a, b, point, normal.normalized(), mu, gap, e});
}

FrictionProblem ContactAssembly::problem() const {
  using Triplet = Eigen::Triplet<double>;
  const auto n = 6 * static_cast<int>(bodies_.size()), nc = contacts();
  std::vector<Triplet> mass, wrench;
  std::vector<Matrix3> axes_of(contacts_.size());
  FrictionProblem problem;
  problem.f.resize(n);
  Vector before(n);
  for (int i = 0; i < n / 6; ++i) {
    const Body& body = bodies_[i];
    for (int k = 0; k < 3; ++k) {
      mass.emplace_back(6 * i + k, 6 * i + k, body.mass);
      for (int l = 0; l < 3; ++l)
        if (body.inertia(k, l) != 0) mass.emplace_back(6 * i + 3 + k, 6 * i + 3 + l, body.inertia(k, l));
    }
    before.segment<6>(6 * i) << body.v, body.w;
    problem.f.segment<6>(6 * i) << body.mass * body.v + h_ * body.force, body.inertia * body.w;
  }
  const BlockKind kind = has_torsion_ && has_rolling_ ? BlockKind::TorsionalRolling
                         : has_torsion_               ? BlockKind::Torsional
                         : has_rolling_               ? BlockKind::Rolling
                                                      : BlockKind::Cone;
  const int rows = block_rows(kind);
  problem.w = Vector::Zero(rows * nc);
  problem.mu.resize(nc);
  if (has_torsion_) problem.torsion.resize(nc);
  if (has_rolling_) problem.rolling.resize(nc);
  problem.kinds.assign(contacts_.size(), kind);
  for (int c = 0; c < nc; ++c) {
    const Contact& contact = contacts_[c];
    const Vector3 helper = std::abs(contact.normal.x()) < 0.7 ? Vector3::UnitX() : Vector3::UnitY();
    const Vector3 t = (helper - helper.dot(contact.normal) * contact.normal).normalized();
    Matrix3& axes = axes_of[c];
    axes << contact.normal, t, contact.normal.cross(t);
    for (const auto& [body, sign] : {std::pair{contact.a, -1.0}, std::pair{contact.b, 1.0}}) {
      if (body == fixed) continue;
      const Vector3 arm = contact.point - bodies_[body].position;
      for (int k = 0; k < 3; ++k) {
        const Vector3 moment = arm.cross(axes.col(k));
        for (int l = 0; l < 3; ++l) {
          wrench.emplace_back(6 * body + l, rows * c + k, sign * axes(l, k));
          wrench.emplace_back(6 * body + 3 + l, rows * c + k, sign * moment(l));
        }
      }
      const int first_axis = has_torsion_ ? 0 : 1,
                after_axis = has_rolling_ ? 3 : 1;  // moments: about n, then t, o
      for (int k = first_axis; k < after_axis; ++k)
        for (int l = 0; l < 3; ++l)
          wrench.emplace_back(6 * body + 3 + l, rows * c + 3 + k - first_axis, sign * axes(l, k));
    }
    if (has_torsion_) problem.torsion(c) = contact.torsion;
    if (has_rolling_) problem.rolling(c) = contact.rolling;
    problem.mu(c) = contact.mu;
  }
  SparseMatrix M(n, n), H(n, rows * nc);
  M.setFromTriplets(mass.begin(), mass.end());
  H.setFromTriplets(wrench.begin(), wrench.end());
  H.prune(0.0);
  const Vector u_before = H.transpose() * before;
  for (int c = 0; c < nc; ++c) {
    const Contact& contact = contacts_[c];
    for (int k = 0; k < 3; ++k) problem.w(rows * c + k) = -axes_of[c].col(k).dot(contact.wall);
    problem.w(rows * c) += contact.gap / h_;
    if (contact.gap == 0) problem.w(rows * c) += contact.e * std::min(0.0, u_before(rows * c));
  }
  problem.M = M;
  problem.H = H;
  return problem;
}

}  // namespace perp
