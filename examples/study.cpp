// A study: three methods on one scene with a known motion, and the orders that their errors show.
#include <cmath>
#include <cstdio>
#include <perp/perp.hpp>

int main() {
  perp::ConvergenceStudy study{.scene = perp::scene("oblique-sphere"), .t_end = 0.2};
  study.steps = perp::halvings(0.02, 6);
  perp::NcpStepper ncp;
  perp::Ncp2Stepper ncp2;
  const perp::ConvergenceTable table = study.run({&ncp, &ncp2});
  const double first = table.order("ncp"), second = table.order("ncp2");
  std::printf("observed orders: ncp %.2f, ncp2 %.2f\n", first, second);
  return std::abs(first - 1) < 0.1 && std::abs(second - 2) < 0.1 ? 0 : 1;
}
