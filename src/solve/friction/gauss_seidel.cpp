#include <cmath>

#include "solve/friction/friction_stages.hpp"

namespace perp {
namespace {

/// One sweep, in place; r is what system.W holds.
template <int R>
void sweep_once(const ContactSystem<R>& system, Columns<R>& r) {
  for (int i = 0; i < system.n; ++i) {
    const Square<R>& W = system.W->diagonal(i);
    const Column<R> before = r.col(i);
    const Column<R> q = system.q.col(i) + system.W->held(i) - W * before;
    const Column<R> after = solve_one_contact(system.block[i], W, q, before), change = after - before;
    if (change.isZero(0)) continue;
    r.col(i) = after;
    system.W->add(i, change);
  }
}

}  // namespace

template <int R>
void sweeps_while_they_pay(const ContactSystem<R>& system, double iterations, double tolerance,
                           Budget& budget, Iterate<R>& best) {
  constexpr int trial = 5, batch = 10, most = 3000;  // sweeps: at first, between two looks, in all
  constexpr double worth = 2;                        // iterations that the trial may cost
  constexpr int little = 25;  // sweeps that leave no better start for Newton's method than there was
  double own = 0;
  for (const Block<R>& block : system.block) own += own_work(block);
  const double newton = (system.W->newton_work() + newton_own_work * system.n) /
                        (system.W->sweep_work() + own);  // sweeps that cost as much as an iteration
  if (trial > worth * newton) return;
  Iterate<R> point = best;
  const Iterate<R> begin = best;
  for (int sweep = 0, poor = 0; sweep < most && !budget.spent();) {
    const double before = point.error;
    const int count = sweep == 0 ? trial : batch;
    system.W->hold(point.r);
    for (int k = 0; k < count && !budget.spent(); ++k) {
      ++budget.iterations;
      sweep_once(system, point.r);
    }
    sweep += count;
    evaluate(system, point);
    if (!std::isfinite(point.error)) return;
    if (point.error < best.error) best = point;
    if (best.error <= tolerance) return;
    const double left = point.error < before
                            ? count * std::log(tolerance / point.error) / std::log(point.error / before)
                            : infinity;
    poor = left <= iterations * newton ? 0 : poor + 1;
    if (poor < 2 && (poor == 0 || sweep > little)) continue;
    if (sweep <= little) best = begin;
    return;
  }
}

template <int R>
void gauss_seidel(const ContactSystem<R>& system, int sweeps, double tolerance, Budget& budget,
                  Iterate<R>& best) {
  Iterate<R> point = best;
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

template void sweeps_while_they_pay(const ContactSystem<3>&, double, double, Budget&, Iterate<3>&);
template void sweeps_while_they_pay(const ContactSystem<6>&, double, double, Budget&, Iterate<6>&);
template void gauss_seidel(const ContactSystem<3>&, int, double, Budget&, Iterate<3>&);
template void gauss_seidel(const ContactSystem<6>&, int, double, Budget&, Iterate<6>&);

}  // namespace perp
