#include "perp/study/cpu_time.hpp"

#include <algorithm>
#include <cmath>
#include <ctime>

namespace perp {

double thread_cpu_seconds() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

double best_cpu_seconds(const std::function<void()>& work, const TimingOptions& options) {
  const auto measure = [&](int batch) {
    const double begin = thread_cpu_seconds();
    for (int i = 0; i < batch; ++i) work();
    return thread_cpu_seconds() - begin;
  };
  double spent = measure(1), best = spent;
  if (spent >= options.spend) return best;
  const int batch = static_cast<int>(std::ceil(options.least_span / std::max(spent, 1e-7)));
  for (int i = 0; i < options.least_repeats || spent < options.spend; ++i) {
    const double span = measure(batch);
    spent += span;
    best = std::min(best, span / batch);
  }
  return best;
}

}  // namespace perp
