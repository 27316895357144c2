#include <cmath>

#include "friction_stages.hpp"

namespace perp {

template <int R>
void gauss_seidel(const ContactSystem<R>& system, int sweeps, double tolerance, Budget& budget,
                  Iterate<R>& best) {
  Iterate<R> point = best;
  for (int sweep = 0; sweep < sweeps && !budget.spent(); ++sweep) {
    ++budget.iterations;
    for (int i = 0; i < system.n; ++i) {
      const Square<R>& W = system.W->diagonal(i);
      const Column<R> r = point.r.col(i);
      const Column<R> q = system.q.col(i) + system.W->row(i, point.r) - W * r;
      point.r.col(i) = solve_one_contact(system.block[i], W, q, r);
    }
    if (sweep % 10 == 9 || sweep + 1 == sweeps) {
      evaluate(system, point);
      if (!std::isfinite(point.error)) return;
      if (point.error < best.error) best = point;
      if (best.error <= tolerance) return;
    }
  }
}

template void gauss_seidel(const ContactSystem<3>&, int, double, Budget&, Iterate<3>&);
template void gauss_seidel(const ContactSystem<6>&, int, double, Budget&, Iterate<6>&);

}  // namespace perp
