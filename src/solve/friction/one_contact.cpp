// One contact alone, for sweeps.
#include <algorithm>
#include <cmath>
#include <numbers>

#include "solve/friction/friction_stages.hpp"

namespace perp {
namespace {

/// Newton on r - p(r - u) for one contact; true if it came down to round-off.
template <int R>
bool newton_one_contact(const Block<R>& block, const Square<R>& W, const Column<R>& q, Column<R>& r) {
  Column<R> p;
  Square<R> P;
  const double size = q.norm();
  for (int k = 0;; ++k) {
    const Column<R> u = W * r + q;
    alart_curnier_projection<R>(block, r - u, p, P);
    const Column<R> F = r - p;
    const double miss = F.norm(), scale = size + r.norm();
    if (miss <= 1e-14 * scale) return true;
    if (k == 12) return miss <= 1e-13 * scale;  // as near as rounding lets it
    const Square<R> J = Square<R>::Identity() - P + P * W;
    r -= J.partialPivLu().solve(F);
    if (!r.allFinite()) return false;
  }
}

/// The reaction that stops a contact with a disc, if it lies in the cone.
bool stick(const Block<3>& block, const Matrix3& W, const Vector3& q, Vector3& r) {
  Matrix3 A = W;
  if (block.planar()) A(2, 2) += W(0, 0);  // a row not in use
  r.noalias() = -(A.inverse() * q);
  const double bound = block.radius * r(0);
  return r(0) > 0 && r.tail<2>().squaredNorm() <= bound * bound &&
         (W * r + q).squaredNorm() <= 1e-28 * q.squaredNorm();
}

/// Sliding along the unit vector d: u_N = 0, r_T = -mu r_N d. Returns r_N, infinite if u_N never closes.
Vector3 sliding_reaction(double mu, const Matrix3& W, const Vector3& q, const Vector2& d) {
  const double slope = W(0, 0) - mu * W.row(0).tail<2>().dot(d);
  const double r_N = -q(0) / slope;
  return {r_N, -mu * r_N * d(0), -mu * r_N * d(1)};
}

/// The sliding solution by a scan of directions: u_T parallel to d, found by bisection. NaN if there is none.
Vector3 slide(double mu, const Matrix3& W, const Vector3& q) {
  const auto direction = [](double angle) { return Vector2(std::cos(angle), std::sin(angle)); };
  const auto twist = [&](double angle) {
    const Vector2 d = direction(angle);
    const Vector2 u_T = (W * sliding_reaction(mu, W, q, d) + q).tail<2>();
    return d.x() * u_T.y() - d.y() * u_T.x();
  };
  constexpr int sectors = 48;
  const double width = 2 * std::numbers::pi / sectors;
  for (int k = 0; k < sectors; ++k) {
    double a = k * width, b = a + width;
    double f_a = twist(a);
    const double f_b = twist(b);
    if (!(f_a * f_b <= 0)) continue;
    for (int i = 0; i < 60; ++i) {
      const double c = (a + b) / 2, f_c = twist(c);
      if (f_a * f_c <= 0)
        b = c;
      else
        a = c, f_a = f_c;
    }
    const Vector2 d = direction((a + b) / 2);
    const Vector3 r = sliding_reaction(mu, W, q, d);
    const Vector3 u = W * r + q;
    if (r(0) > 0 && d.dot(u.tail<2>()) >= 0 && std::isfinite(r.norm())) return r;
  }
  return Vector3::Constant(not_set);
}

/// The sliding solution of a disc where Newton's method finds none. NaN if there is none.
Vector3 slide(const Block<3>& block, const Matrix3& W, const Vector3& q) {
  const double mu = block.radius;
  if (!block.planar()) return slide(mu, W, q);
  for (const double side : {1.0, -1.0}) {
    const Vector3 answer = sliding_reaction(mu, W, q, Vector2(side, 0));
    if (answer(0) > 0 && side * (W * answer + q)(1) >= 0 && std::isfinite(answer.norm())) return answer;
  }
  return Vector3::Constant(not_set);
}

}  // namespace

template <int R>
Column<R> solve_one_contact(const Block<R>& block, const Square<R>& W, const Column<R>& q,
                            const Column<R>& r) {
  Column<R> alone = Column<R>::Zero();  // the normal row by itself
  alone(0) = W(0, 0) > 0 ? -q(0) / W(0, 0) : 0;
  if (block.contact && block.frictionless()) return alone.cwiseMax(0);
  if (!block.contact && block.planar()) {
    Column<R> answer = Column<R>::Zero();
    answer(1) = W(1, 1) > 0 ? std::clamp(-q(1) / W(1, 1), -block.radius, block.radius) : r(1);
    return answer;
  }
  if (block.contact && q(0) >= 0) return Column<R>::Zero();  // separating without a reaction
  Column<R> answer;
  if constexpr (R == 3)
    if (block.contact && block.is_disc() && stick(block, W, q, answer)) return answer;
  answer = r;
  if (newton_one_contact(block, W, q, answer)) return answer;
  answer = alone;
  if (newton_one_contact(block, W, q, answer)) return answer;
  if constexpr (R == 3) {
    if (block.is_disc()) {
      answer = slide(block, W, q);
      if (answer.allFinite()) return answer;
    }
  }
  return project_block<R>(block, r - augmented_velocity<R>(block, W * r + q));
}

template Vector3 solve_one_contact(const Block<3>&, const Matrix3&, const Vector3&, const Vector3&);
template Column<6> solve_one_contact(const Block<6>&, const Square<6>&, const Column<6>&, const Column<6>&);

}  // namespace perp
