// Measures the solvers of contact problems, each alone and the chain, over families and files:
//   contact_problems [--seed N] [--count C] [--family NAME]... [--out DIR] [FILE...]
//   contact_problems --warm [--seed N] [--count C] [--family NAME]...
// --warm: q changed by 1 % of |q| in a random direction of the range of W, solved from the answer before. Without --family and FILE all families are run. Prints a table a family and for all: how many problems each solver
// brings to 1e-8, 1e-10 and 1e-12 (relative; absolute to a hundred times that), CPU times, the chain's stages. DIR
// gets performance-profile.csv, .gp and, where gnuplot is installed, .svg [DM02]: the share of
// problems that a solver brings to 1e-10 within a factor of the fastest one's time.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <filesystem>
#include <fstream>
#include <functional>
#include <map>
#include <random>
#include <string>
#include <vector>

#include "../../src/solve/friction/friction_stages.hpp"
#include "../../src/solve/friction/global_form.hpp"
#include "perp/solve/friction_io.hpp"
#include "perp/solve/friction_solver.hpp"
#include "perp/study/friction_families.hpp"

#ifdef PERP_HAS_SICONOS
#include "siconos_solvers.hpp"
#endif

using namespace perp;

namespace {

struct Run {
  double relative = infinity, absolute = infinity, seconds = infinity;
  std::string stage;
  bool passes(double tolerance) const { return relative <= tolerance && absolute <= 100 * tolerance; }
};

double cpu_seconds() {
  timespec now{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

/// Best of up to five solves; long ones are not repeated.
Run timed(const FrictionProblem& problem, const std::function<Vector(std::string&)>& solve) {
  Run run;
  Vector r;
  for (int repeat = 0; repeat < 5; ++repeat) {
    const double begin = cpu_seconds();
    r = solve(run.stage);
    run.seconds = std::min(run.seconds, cpu_seconds() - begin);
    if (run.seconds > 0.05) break;
  }
  if (!r.allFinite()) return run;
  const FrictionResidual residual = friction_residual(problem, r);
  run.relative = residual.relative;
  run.absolute = residual.absolute;
  return run;
}

Vector solve_by(FrictionMethod method, const FrictionProblem& problem, std::string& stage) {
  const FrictionSolution s = solve_friction(problem, {.method = method});
  stage = s.status == FrictionStatus::NoSolution ? "no-solution" : to_string(s.stage);
  return s.r;
}

/// Alart-Curnier Newton as the literature has it: no regularisation, from zero.
Vector plain_newton(const FrictionProblem& problem) {
  const ContactSystem<3> system = contact_system<3>(to_local(problem));
  Iterate<3> best;
  best.r = Columns<3>::Zero(3, system.n);
  evaluate(system, best);
  Budget budget;
  newton(system, {.most = 200, .regularisation = 0, .least_regularisation = 0}, 1e-10, budget, best);
  return system.reaction(best.r, problem.offsets());
}

struct Solver {
  std::string name;
  Eigen::Index most_contacts;
  std::function<Vector(const FrictionProblem&, std::string&)> solve;
};

std::vector<Solver> solvers() {
  const auto stage = [](FrictionMethod method) {
    return [method](const FrictionProblem& p, std::string& s) { return solve_by(method, p, s); };
  };
  std::vector<Solver> all{
      {"plain newton", 100000, [](const FrictionProblem& p, std::string&) { return plain_newton(p); }},
      {"newton", 100000, stage(FrictionMethod::Newton)},
      {"interior-point", 100000, stage(FrictionMethod::InteriorPoint)},
      {"proximal", 60, stage(FrictionMethod::Proximal)},
      {"gauss-seidel", 60, stage(FrictionMethod::GaussSeidel)},
      {"ipopt", 25, stage(FrictionMethod::Ipopt)},
      {"chain", 100000, stage(FrictionMethod::Chain)}};
#ifdef PERP_HAS_SICONOS
  for (const SiconosSolver& other : siconos_solvers())
    all.push_back(
        {other.name, 1000, [other](const FrictionProblem& p, std::string&) { return other.solve(p); }});
#endif
  return all;
}

/// The problem with q changed by `share` of |q| along W rho, both in the scaled problem, rho random.
FrictionProblem changed(FrictionProblem global, double share, unsigned seed) {
  const ContactSystem<3> system = contact_system<3>(global, MassResponse(global));
  std::mt19937_64 engine(seed);
  Columns<3> rho(3, system.n), change;
  for (double& x : rho.reshaped()) x = 2 * static_cast<double>(engine() >> 11) * 0x1p-53 - 1;
  system.W->apply(rho, change);
  rho *= share * system.q.norm() / change.norm();
  global.f += global.H.times(system.reaction(rho, global.offsets()));
  return global;
}

void print_warm_starts(const std::vector<std::string>& families, std::uint64_t seed, int count) {
  std::printf("%-16s %5s %12s %5s %5s %9s\n", "family", "run", "newton alone", "<= 6", "<= 4", "unsolved");
  for (const std::string& family : families) {
    int run = 0, newton = 0, six = 0, four = 0, unsolved = 0;
    for (int i = 0; i < count; ++i) {
      const FrictionProblem problem = friction_family(family, seed, i);
      const FrictionSolution before = solve_friction(problem, {.use_ipopt = false});
      if (!before.solved()) continue;
      const FrictionProblem next = changed(problem, 0.01, static_cast<unsigned>(i));
      const auto within = [&](int most) {
        return solve_friction(next, {.start = before.r, .max_iterations = most, .use_ipopt = false}).solved();
      };
      const FrictionSolution after = solve_friction(next, {.start = before.r, .use_ipopt = false});
      ++run;
      unsolved += !after.solved();
      if (!after.solved() || after.stage > FrictionStage::Newton) continue;
      ++newton;
      six += within(6);
      four += within(4);
    }
    std::printf("%-16s %5d %12d %5d %5d %9d\n", family.c_str(), run, newton, six, four, unsolved);
  }
}

struct Case {
  std::string group, name;
  FrictionProblem problem;
  std::map<std::string, Run> runs;
};

void print_table(const std::string& title, const std::vector<const Case*>& cases,
                 const std::vector<Solver>& all) {
  std::printf("\n%s: %zu problems\n%-16s %5s %6s %6s %6s  %10s %10s\n", title.c_str(), cases.size(), "solver",
              "run", "1e-8", "1e-10", "1e-12", "median ms", "p90 ms");
  for (const Solver& solver : all) {
    std::vector<double> times;
    int pass[3] = {};
    std::map<std::string, int> stages;
    for (const Case* c : cases) {
      const auto found = c->runs.find(solver.name);
      if (found == c->runs.end()) continue;
      times.push_back(found->second.seconds * 1e3);
      for (int k = 0; k < 3; ++k) pass[k] += found->second.passes(std::pow(10.0, -8 - 2 * k));
      if (solver.name == "chain") ++stages[found->second.stage];
    }
    if (times.empty()) continue;
    std::sort(times.begin(), times.end());
    std::printf("%-16s %5zu %6d %6d %6d  %10.3f %10.3f", solver.name.c_str(), times.size(), pass[0], pass[1],
                pass[2], times[times.size() / 2], times[times.size() * 9 / 10]);
    for (const auto& [stage, count] : stages) std::printf("  %s %d", stage.c_str(), count);
    std::printf("\n");
  }
}

void write_profile(const std::vector<Case>& cases, const std::vector<Solver>& all, const std::string& out) {
  std::filesystem::create_directories(out);
  const std::string base = out + "/performance-profile";
  std::ofstream csv(base + ".csv"), script(base + ".gp");
  csv << "factor";
  for (const Solver& solver : all) csv << ',' << solver.name;
  csv << '\n';
  for (double exponent = 0; exponent <= 4.0001; exponent += 0.05) {
    const double factor = std::pow(10.0, exponent);
    csv << factor;
    for (const Solver& solver : all) {
      int within = 0;
      for (const Case& c : cases) {
        double fastest = infinity;
        for (const auto& [name, run] : c.runs)
          if (run.passes(1e-10)) fastest = std::min(fastest, run.seconds);
        const auto found = c.runs.find(solver.name);
        if (found != c.runs.end() && found->second.passes(1e-10))
          within += found->second.seconds <= factor * fastest;
      }
      csv << ',' << static_cast<double>(within) / static_cast<double>(cases.size());
    }
    csv << '\n';
  }
  script << "set terminal svg size 720,480\nset output '" << base << ".svg'\nset datafile separator ','\n"
         << "set logscale x\nset xlabel 'time / fastest time'\nset ylabel 'share of problems to 1e-10'\n"
         << "set yrange [0:1.02]\nset key bottom right\nplot ";
  for (size_t k = 0; k < all.size(); ++k)
    script << (k > 0 ? ", " : "") << "'" << base << ".csv' using 1:" << k + 2 << " with steps lw 2 title '"
           << all[k].name << "'";
  script << '\n';
  script.close();
  csv.close();
  if (std::system(("gnuplot " + base + ".gp").c_str()) != 0) std::printf("no picture: gnuplot did not run\n");
}

}  // namespace

int main(int argc, char** argv) {
  std::uint64_t seed = 1;
  int count = 30;
  bool warm = false;
  std::string out = "out";
  std::vector<std::string> families, files;
  for (int k = 1; k < argc; ++k) {
    const std::string argument = argv[k];
    const bool has_value = k + 1 < argc;
    if (argument == "--seed" && has_value)
      seed = std::stoull(argv[++k]);
    else if (argument == "--count" && has_value)
      count = std::stoi(argv[++k]);
    else if (argument == "--family" && has_value)
      families.emplace_back(argv[++k]);
    else if (argument == "--out" && has_value)
      out = argv[++k];
    else if (argument == "--warm")
      warm = true;
    else
      files.push_back(argument);
  }
  if (families.empty() && files.empty())
    for (const std::string& family : friction_families())
      if (family != "infeasible-peg") families.push_back(family);

  if (warm) {
    print_warm_starts(families, seed, count);
    return 0;
  }
  std::vector<Case> cases;
  for (const std::string& family : families)
    for (int i = 0; i < count; ++i)
      cases.push_back({family, std::to_string(i), friction_family(family, seed, i), {}});
  for (const std::string& file : files) cases.push_back({"files", file, read_friction_problem(file), {}});

  const std::vector<Solver> all = solvers();
  for (Case& c : cases) {
    for (const Solver& solver : all)
      if (c.problem.blocks() <= solver.most_contacts)
        c.runs[solver.name] =
            timed(c.problem, [&](std::string& stage) { return solver.solve(c.problem, stage); });
    if (c.group != "files") continue;
    std::printf("%s, %ld contacts:", std::filesystem::path(c.name).filename().c_str(),
                long{c.problem.blocks()});
    for (const auto& [name, run] : c.runs)
      std::printf(" %s %.3f ms (%.0e);", name.c_str(), run.seconds * 1e3, run.relative);
    std::printf("\n");
  }
  std::vector<const Case*> everything;
  std::map<std::string, std::vector<const Case*>> groups;
  for (const Case& c : cases) {
    everything.push_back(&c);
    groups[c.group].push_back(&c);
  }
  for (const auto& [group, members] : groups) print_table(group, members, all);
  print_table("all", everything, all);
  write_profile(cases, all, out);
}
