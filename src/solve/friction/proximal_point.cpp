#include <algorithm>
#include <cmath>

#include "solve/friction/friction_stages.hpp"

namespace perp {
namespace {

/// W + alpha I, through W's own factorisations.
template <int R>
class ShiftedOperator final : public DelassusOperator<R> {
 public:
  ShiftedOperator(DelassusOperator<R>& W, double alpha, int n) : W_(W), alpha_(alpha) {
    for (int i = 0; i < n; ++i) diagonal_.push_back(W.diagonal(i) + alpha * Square<R>::Identity());
  }
  const Square<R>& diagonal(int i) const override { return diagonal_[i]; }
  void apply(const Columns<R>& r, Columns<R>& Wr) const override {
    W_.apply(r, Wr);
    Wr += alpha_ * r;
  }
  bool factor(const Squares<R>& A, const Squares<R>& B) override {
    Squares<R> shifted = A;
    for (size_t i = 0; i < A.size(); ++i) shifted[i] += alpha_ * B[i];
    return W_.factor(shifted, B);
  }
  bool solve(const Columns<R>& y, Columns<R>& x, Columns<R>& Wx) override {
    if (!W_.solve(y, x, Wx)) return false;
    Wx += alpha_ * x;
    return true;
  }
  Column<R> row(int i, const Columns<R>& r) const override { return W_.row(i, r) + alpha_ * r.col(i); }
  Matrix dense() const override {
    Matrix W = W_.dense();
    W.diagonal().array() += alpha_;
    return W;
  }

 private:
  DelassusOperator<R>& W_;
  double alpha_;
  Squares<R> diagonal_;
};

/// The problem with alpha (r - centre) added to u.
template <int R>
ContactSystem<R> shifted(const ContactSystem<R>& system, double alpha, const Columns<R>& centre) {
  ContactSystem<R> result;
  result.n = system.n;
  result.block = system.block;
  result.layout = system.layout;
  result.s = system.s;
  result.sigma = system.sigma;
  result.q = system.q - alpha * centre;
  result.W = std::make_unique<ShiftedOperator<R>>(*system.W, alpha, system.n);
  return result;
}

}  // namespace

template <int R>
void proximal_point(const ContactSystem<R>& system, const ProximalOptions& options, double tolerance,
                    Budget& budget, Iterate<R>& best) {
  constexpr double enough = 0.1;               // of the inner error at its start: the step counts
  constexpr double shrink = 0.3, grow = 4;     // alpha after a step that counts; after one that does not
  constexpr double least = 1e-12, most = 100;  // alpha
  double alpha = options.alpha;
  Iterate<R> centre = best;
  for (int k = 0; k < options.most && best.error > tolerance && !budget.spent(); ++k) {
    const ContactSystem<R> inner = shifted(system, alpha, centre.r);
    Iterate<R> point;
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

template void proximal_point(const ContactSystem<3>&, const ProximalOptions&, double, Budget&, Iterate<3>&);
template void proximal_point(const ContactSystem<6>&, const ProximalOptions&, double, Budget&, Iterate<6>&);

}  // namespace perp
