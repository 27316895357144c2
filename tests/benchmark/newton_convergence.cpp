// How Newton's method of the implicit steps goes on curved gaps: residuals per iteration, iterations per step, failures.
//   newton_convergence [STEPS] [SEED]
#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <numbers>

#include "tests/step/newton_cases.hpp"

using namespace perp;
using namespace perp::testing;

namespace {

struct Tally {
  int steps = 0, failed = 0, slid_or_changed = 0;
  std::vector<int> iterations;  // of steps that were not converged at the start
  double gap = 0;
  std::vector<double> example;  // residuals of the longest run of Newton
};

template <class Method>
void tally(Method& method, const NewtonCase& c, double h, int steps, Tally& out) {
  State x = c.x;
  ContactMode before[2] = {ContactMode::Open, ContactMode::Open};
  for (int k = 0; k < steps; ++k) {
    const StepReport report = method.step(c.model, x, h);
    ++out.steps;
    if (!report.advanced()) {
      ++out.failed;
      return;
    }
    const std::vector<double>& residuals = method.history().residuals;
    if (residuals.size() > 1) out.iterations.push_back(static_cast<int>(residuals.size()) - 1);
    if (residuals.size() > out.example.size()) out.example = residuals;
    out.gap = std::min(out.gap, report.gap_min);
    bool counts = false;
    for (std::size_t i = 0; i < report.contacts.size() && i < 2; ++i) {
      counts = counts || report.contacts[i].mode == ContactMode::Slip || report.contacts[i].mode != before[i];
      before[i] = report.contacts[i].mode;
    }
    out.slid_or_changed += counts ? 1 : 0;
  }
}

void print(const char* method, const char* body, double h, Tally& t) {
  std::sort(t.iterations.begin(), t.iterations.end());
  const auto quantile = [&](double q) {
    return t.iterations.empty() ? 0
                                : t.iterations[static_cast<std::size_t>(q * double(t.iterations.size() - 1))];
  };
  std::printf("%-6s %-36s %7.0e %6d %6d %8d %7d %6d %9.1e  ", method, body, h, t.steps, t.failed,
              t.slid_or_changed, quantile(0.5), quantile(1), -t.gap);
  for (const double r : t.example) std::printf(" %.0e", r);
  std::printf("\n");
}

}  // namespace

int main(int argc, char** argv) {
  const int total = argc > 1 ? std::atoi(argv[1]) : 5000;
  std::mt19937 random(argc > 2 ? static_cast<unsigned>(std::atoi(argv[2])) : 1U);
  const double sizes[] = {1e-4, 1e-3, 1e-2, 1e-1};
  const int runs = 4, each = std::max(1, total / (2 * 2 * 4 * 4 * runs));  // methods, bodies, starts, sizes
  std::printf("%-6s %-36s %7s %6s %6s %8s %7s %6s %9s   residuals of the longest [m/s]\n", "method", "body",
              "h", "steps", "failed", "slid|chg", "median", "most", "overlap");
  for (const double h : sizes)
    for (const bool rod : {false, true}) {
      Tally one, two;
      const char* name = "";
      for (const Start start : starts)
        for (int run = 0; run < runs; ++run) {
          const double mu = run % 2 == 0 ? 0.3 : 0.05;
          const NewtonCase c = rod ? rod_case(start, mu, random) : ellipsoid_case(start, mu, random);
          NcpStepper ncp;
          Ncp2Stepper ncp2;
          tally(ncp, c, h, each, one);
          tally(ncp2, c, h, each, two);
          name = rod ? "rod with two spheres in a cylinder" : "ellipsoid on a plane";
        }
      print("ncp", name, h, one);
      print("ncp2", name, h, two);
    }
}
