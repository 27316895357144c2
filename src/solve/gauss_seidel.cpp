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
  for (int k = 0;; ++k) {
    const Vector3 u = W * r + q;
    alart_curnier_projection(kind, mu, r - u, p, P);
    const Vector3 F = r - p;
    const double miss = F.norm(), scale = size + r.norm();
    if (miss <= 1e-14 * scale) return true;
    if (k == 12) return miss <= 1e-13 * scale;  // as near as rounding lets it
    const Matrix3 J = Matrix3::Identity() - P + P * W;
    r -= J.partialPivLu().solve(F);
    if (!r.allFinite()) return false;
  }
}

/// The reaction that stops the contact, if it lies in the cone.
bool stick(BlockKind kind, double mu, const Matrix3& W, const Vector3& q, Vector3& r) {
  Matrix3 A = W;
  if (kind == BlockKind::Planar) A(2, 2) += W(0, 0);  // a row not in use
  r.noalias() = -(A.inverse() * q);
  return r(0) > 0 && r.tail<2>().squaredNorm() <= mu * mu * r(0) * r(0) &&
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

}  // namespace

Vector3 solve_one_contact(BlockKind kind, double mu, const Matrix3& W, const Vector3& q, const Vector3& r) {
  if (kind == BlockKind::HalfLine || (mu == 0 && kind != BlockKind::Interval))
    return {W(0, 0) > 0 ? std::max(0.0, -q(0) / W(0, 0)) : 0, 0, 0};
  if (kind == BlockKind::Interval) return {0, W(1, 1) > 0 ? std::clamp(-q(1) / W(1, 1), -mu, mu) : r(1), 0};
  if (q(0) >= 0) return Vector3::Zero();  // separating without a reaction
  Vector3 answer;
  if (stick(kind, mu, W, q, answer)) return answer;
  answer = r;
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

namespace {

/// One sweep, in place; r is what system.W holds.
void sweep_once(const ContactSystem& system, Columns3& r) {
  for (int i = 0; i < system.n; ++i) {
    const Matrix3& W = system.W->diagonal(i);
    const Vector3 before = r.col(i);
    const Vector3 q = system.q.col(i) + system.W->held(i) - W * before;
    const Vector3 after = solve_one_contact(system.kind[i], system.mu[i], W, q, before),
                  change = after - before;
    if (change.isZero(0)) continue;
    r.col(i) = after;
    system.W->add(i, change);
  }
}

}  // namespace

void sweeps_while_they_pay(const ContactSystem& system, double tolerance, Budget& budget, Iterate& best) {
  constexpr int batch = 10;             // sweeps between two looks at the residual
  constexpr int most = 3000, idle = 2;  // sweeps; batches in a row that did not pay
  constexpr double newton = 10;         // iterations that Newton's method will take from here
  const double affordable = newton * system.W->newton_work() / system.W->sweep_work();
  Iterate point = best;
  for (int sweep = 0, poor = 0; sweep < most && poor < idle && !budget.spent(); sweep += batch) {
    const double before = point.error;
    system.W->hold(point.r);
    for (int k = 0; k < batch && !budget.spent(); ++k) {
      ++budget.iterations;
      sweep_once(system, point.r);
    }
    evaluate(system, point);
    if (!std::isfinite(point.error)) return;
    if (point.error < best.error) best = point;
    if (best.error <= tolerance) return;
    const double left = point.error < before
                            ? batch * std::log(tolerance / point.error) / std::log(point.error / before)
                            : infinity;
    poor = left <= affordable ? 0 : poor + 1;
  }
}

void gauss_seidel(const ContactSystem& system, int sweeps, double tolerance, Budget& budget, Iterate& best) {
  Iterate point = best;
  system.W->hold(point.r);
  for (int sweep = 0; sweep < sweeps && !budget.spent(); ++sweep) {
    ++budget.iterations;
    sweep_once(system, point.r);
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
