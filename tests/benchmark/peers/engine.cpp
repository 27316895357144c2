#include "engine.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <exception>

namespace peers {
namespace {

double cpu_time() {
  timespec t{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
  return double(t.tv_sec) + 1e-9 * double(t.tv_nsec);
}

struct Run {
  double seconds = 0;
  long steps = 0;
  bool ended = true;
};

Run take(World& world, long n, double limit) {
  Run run;
  const double start = cpu_time();
  for (long k = 0; k < (world.whole_run() ? 1 : n); ++k) {
    world.step();
    if (k % 16 == 15 && cpu_time() - start > limit) {
      run.ended = k + 1 >= n;
      break;
    }
  }
  run.seconds = cpu_time() - start;
  run.steps = world.whole_run() ? world.steps() : n;
  return run;
}

double error_at_end(const Scene& scene, World& world) {
  const std::vector<Vec> right = scene.end();
  double error = 0;
  for (std::size_t i = 0; i < right.size(); ++i) {
    const double e = norm(world.centre(i) - right[i]);
    error = std::isfinite(e) ? std::max(error, e) : HUGE_VAL;
  }
  return error;
}

}  // namespace

int measure(int argc, char** argv, const char* engine, const std::string& version,
            const MakeWorld& make) try {
  if (argc < 4) {
    std::fprintf(stderr, "usage: %s SCENE CONFIGURATION H [SECONDS]\n", argv[0]);
    return 2;
  }
  const Scene s = scene(argv[1]);
  const std::string configuration = argv[2];
  const double h = std::atof(argv[3]), limit = argc > 4 ? std::atof(argv[4]) : 2;
  const long n = std::max(1L, std::lround(s.t_end / h));
  const auto say = [&](long steps, double error, double seconds, const char* status) {
    std::printf("%s,%s,%s,%s,%g,%ld,%.4g,%.4g,%s\n", s.name.c_str(), engine, version.c_str(),
                configuration.c_str(), h, steps, error, seconds, status);
    return 0;
  };

  const std::unique_ptr<World> world = make(s, configuration, h);
  if (!world) return say(0, NAN, NAN, "has-not");
  Run run = take(*world, n, limit);
  if (!run.ended) return say(run.steps, NAN, run.seconds, "gave-up");
  const double error = error_at_end(s, *world);
  if (!std::isfinite(error) || error > 1e3) return say(run.steps, NAN, run.seconds, "diverged");

  std::vector<double> seconds{run.seconds};
  for (double spent = run.seconds; seconds.size() < 5 && spent < limit; spent += seconds.back())
    seconds.push_back(take(*make(s, configuration, h), n, limit).seconds);
  std::nth_element(seconds.begin(), seconds.begin() + long(seconds.size()) / 2, seconds.end());
  return say(run.steps, error, seconds[seconds.size() / 2], "ended");
} catch (const std::exception& e) {
  std::fprintf(stderr, "%s: %s\n", engine, e.what());
  return 3;
}

}  // namespace peers
