#include <algorithm>
#include <array>
#include <cmath>

#include "friction_maps.hpp"
#include "friction_stages.hpp"

namespace perp {
namespace {

constexpr size_t memory = 10;        // merits that the search may fall back on
constexpr double sufficient = 1e-4;  // Armijo's fraction of the predicted decrease
constexpr int most_halvings = 12;

template <class Map, class Regularisation>
void newton_on(Map& map, const Regularisation& regularisation, const ContactSystem& system, int most,
               double tolerance, Budget& budget, Iterate& best) {
  Blocks3 A(system.n), B(system.n);
  Iterate point = best;
  Columns3 minus_F, step, W_step, r, u;
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

void newton(const ContactSystem& system, const NewtonOptions& options, double tolerance, Budget& budget,
            Iterate& best) {
  if (options.fischer_burmeister) {
    FischerBurmeisterMap map{system, {}, {}, {}};
    const auto eps = [](double error) { return 1e-2 * std::min(1.0, std::sqrt(error)); };
    newton_on(map, eps, system, options.most, tolerance, budget, best);
  } else {
    AlartCurnierMap map{system, options.rho, {}, {}};
    const auto eps = [&](double error) {
      return std::min(1e-2, std::max(options.least_regularisation, options.regularisation * error));
    };
    newton_on(map, eps, system, options.most, tolerance, budget, best);
  }
}

}  // namespace perp
