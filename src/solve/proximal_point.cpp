#include <algorithm>
#include <cmath>

#include "friction_stages.hpp"

namespace perp {
namespace {

/// W + alpha I, through W's own factorisations.
class ShiftedOperator final : public DelassusOperator {
 public:
  ShiftedOperator(DelassusOperator& W, double alpha, int n) : W_(W), alpha_(alpha) {
    for (int i = 0; i < n; ++i) diagonal_.push_back(W.diagonal(i) + alpha * Matrix3::Identity());
  }
  const Matrix3& diagonal(int i) const override { return diagonal_[i]; }
  void apply(const Columns3& r, Columns3& Wr) const override {
    W_.apply(r, Wr);
    Wr += alpha_ * r;
  }
  bool factor(const Blocks3& A, const Blocks3& B) override {
    Blocks3 shifted = A;
    for (size_t i = 0; i < A.size(); ++i) shifted[i] += alpha_ * B[i];
    return W_.factor(shifted, B);
  }
  bool solve(const Columns3& y, Columns3& x, Columns3& Wx) override {
    if (!W_.solve(y, x, Wx)) return false;
    Wx += alpha_ * x;
    return true;
  }
  Vector3 row(int i, const Columns3& r) const override { return W_.row(i, r) + alpha_ * r.col(i); }
  Matrix dense() const override {
    Matrix W = W_.dense();
    W.diagonal().array() += alpha_;
    return W;
  }

 private:
  DelassusOperator& W_;
  double alpha_;
  Blocks3 diagonal_;
};

/// The problem with alpha (r - centre) added to u.
ContactSystem shifted(const ContactSystem& system, double alpha, const Columns3& centre) {
  ContactSystem result;
  result.n = system.n;
  result.kind = system.kind;
  result.mu = system.mu;
  result.s = system.s;
  result.sigma = system.sigma;
  result.q = system.q - alpha * centre;
  result.W = std::make_unique<ShiftedOperator>(*system.W, alpha, system.n);
  return result;
}

}  // namespace

void proximal_point(const ContactSystem& system, const ProximalOptions& options, double tolerance,
                    Budget& budget, Iterate& best) {
  constexpr double enough = 0.1;               // of the inner error at its start: the step counts
  constexpr double shrink = 0.3, grow = 4;     // alpha after a step that counts; after one that does not
  constexpr double least = 1e-12, most = 100;  // alpha
  double alpha = options.alpha;
  Iterate centre = best;
  for (int k = 0; k < options.most && best.error > tolerance && !budget.spent(); ++k) {
    const ContactSystem inner = shifted(system, alpha, centre.r);
    Iterate point;
    point.r = centre.r;
    evaluate(inner, point);
    const double before = point.error, goal = std::min(0.1 * tolerance, 0.01 * before);
    newton(inner, {.most = options.newton}, goal, budget, point);
    if (point.error > enough * before)
      newton(inner, {.most = options.newton, .fischer_burmeister = true}, goal, budget, point);
    const bool counts = point.error <= enough * before;
    evaluate(system, point);
    if (!std::isfinite(point.error)) return;
    if (point.error < best.error) best = point;
    if (counts) {
      centre = std::move(point);
      alpha = std::max(least, shrink * alpha);
    } else if (options.sweeps > 0) {
      if (point.error < centre.error) centre = std::move(point);
      centre.error = infinity;  // so that the sweeps' own end is taken, better or not
      gauss_seidel(system, options.sweeps, tolerance, budget, centre);
      if (centre.error < best.error) best = centre;
      alpha = std::min(1.0, grow * alpha);
    } else {
      alpha *= grow;
      if (alpha > most) alpha = 1, centre = std::move(point);
    }
  }
}

}  // namespace perp
