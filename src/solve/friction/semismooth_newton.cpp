#include <algorithm>
#include <array>
#include <cmath>

#include "solve/friction/friction_maps.hpp"
#include "solve/friction/friction_stages.hpp"

namespace perp {
namespace {

constexpr size_t memory = 10;        // merits that the search may fall back on
constexpr double sufficient = 1e-4;  // Armijo's fraction of the predicted decrease
constexpr int most_halvings = 12;

template <int R, class Map, class Regularisation>
void newton_on(Map& map, const Regularisation& regularisation, const ContactSystem<R>& system, int most,
               double tolerance, Budget& budget, Iterate<R>& best) {
  Squares<R> A(system.n), B(system.n);
  Iterate<R> point = best;
  Columns<R> minus_F, step, W_step, r, u;
  std::array<double, memory> merits;
  double merit = map.evaluate(point.r, point.u);
  merits.fill(merit);
  for (int k = 0, stalled = 0; k < most && !budget.spent(); ++k) {
    ++budget.iterations;
    map.jacobian(regularisation(point.error), A, B);
    minus_F = -map.F;
    if (!system.W->factor(A, B) || !system.W->solve(minus_F, step, W_step)) return;
    // nonmonotone Armijo search on |F|², whose slope along the step is -2 |F|²
    const double reference = *std::max_element(merits.begin(), merits.end());
    const double slope = -2 * merit;
    r = point.r;
    u = point.u;
    double t = 1;
    for (int halvings = 0;; ++halvings, t /= 2) {
      point.r = r + t * step;
      point.u = u + t * W_step;
      merit = map.evaluate(point.r, point.u);
      if (merit <= reference + sufficient * t * slope || halvings == most_halvings) break;
    }
    merits[k % memory] = merit;
    evaluate(system, point);
    if (!std::isfinite(point.error)) return;
    const bool halved = point.error < 0.5 * best.error;
    if (point.error < best.error) best = point;
    // below the tolerance: on to round-off
    if (best.error <= tolerance && (best.error < 1e-15 || (!halved && ++stalled == 2))) return;
  }
}

}  // namespace

template <int R>
void newton(const ContactSystem<R>& system, const NewtonOptions& options, double tolerance, Budget& budget,
            Iterate<R>& best) {
  if (options.fischer_burmeister) {
    FischerBurmeisterMap<R> map{system, {}, {}, {}};
    const auto eps = [](double error) { return 1e-2 * std::min(1.0, std::sqrt(error)); };
    newton_on(map, eps, system, options.most, tolerance, budget, best);
  } else {
    AlartCurnierMap<R> map{system, options.rho, {}, {}};
    const auto eps = [&](double error) {
      return std::min(1e-2, std::max(options.least_regularisation, options.regularisation * error));
    };
    newton_on(map, eps, system, options.most, tolerance, budget, best);
  }
}

template void newton(const ContactSystem<3>&, const NewtonOptions&, double, Budget&, Iterate<3>&);
template void newton(const ContactSystem<6>&, const NewtonOptions&, double, Budget&, Iterate<6>&);

}  // namespace perp
