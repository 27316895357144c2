#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "cone.hpp"
#include "friction_stages.hpp"

namespace perp {
namespace {

/// Newton on r - p(r - u) for one contact; true if it came down to round-off.
bool newton_one_contact(BlockKind kind, double mu, const Matrix3& W, const Vector3& q, Vector3& r) {
  Vector3 p;
  Matrix3 P;
  const double size = q.norm();
  for (int k = 0; k < 12; ++k) {
    const Vector3 u = W * r + q;
    alart_curnier_projection(kind, mu, r - u, p, P);
    const Vector3 F = r - p;
    if (F.norm() <= 1e-14 * (size + r.norm())) return true;
    const Matrix3 J = Matrix3::Identity() - P + P * W;
    r -= J.partialPivLu().solve(F);
    if (!r.allFinite()) return false;
  }
  return false;
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

}  // namespace

Vector3 solve_one_contact(BlockKind kind, double mu, const Matrix3& W, const Vector3& q, const Vector3& r) {
  if (kind == BlockKind::HalfLine || (mu == 0 && kind != BlockKind::Interval))
    return {W(0, 0) > 0 ? std::max(0.0, -q(0) / W(0, 0)) : 0, 0, 0};
  if (kind == BlockKind::Interval) return {0, W(1, 1) > 0 ? std::clamp(-q(1) / W(1, 1), -mu, mu) : r(1), 0};
  if (q(0) >= 0) return Vector3::Zero();  // separating without a reaction
  Vector3 answer = r;
  if (newton_one_contact(kind, mu, W, q, answer)) return answer;
  answer = {W(0, 0) > 0 ? -q(0) / W(0, 0) : 0, 0, 0};
  if (newton_one_contact(kind, mu, W, q, answer)) return answer;
  if (kind == BlockKind::Planar) {
    for (const double side : {1.0, -1.0}) {
      answer = sliding_reaction(mu, W, q, Vector2(side, 0));
      if (answer(0) > 0 && side * (W * answer + q)(1) >= 0 && std::isfinite(answer.norm())) return answer;
    }
  } else {
    answer = slide(mu, W, q);
    if (answer.allFinite()) return answer;
  }
  return project_block(kind, mu, r - augmented_velocity(kind, mu, W * r + q));
}

void gauss_seidel(const ContactSystem& system, int sweeps, double tolerance, Budget& budget, Iterate& best) {
  Iterate point = best;
  for (int sweep = 0; sweep < sweeps && !budget.spent(); ++sweep) {
    ++budget.iterations;
    for (int i = 0; i < system.n; ++i) {
      const Matrix3& W = system.W->diagonal(i);
      const Vector3 r = point.r.col(i);
      const Vector3 q = system.q.col(i) + system.W->row(i, point.r) - W * r;
      point.r.col(i) = solve_one_contact(system.kind[i], system.mu[i], W, q, r);
    }
    if (sweep % 10 == 9 || sweep + 1 == sweeps) {
      evaluate(system, point);
      if (!std::isfinite(point.error)) return;
      if (point.error < best.error) best = point;
      if (best.error <= tolerance) return;
    }
  }
}

void evaluate(const ContactSystem& system, Iterate& point) {
  system.W->apply(point.r, point.u);
  point.u += system.q;
  point.error = pass_error(natural_map(system, point.r, point.u), point.r.norm());
}

}  // namespace perp
