// What a computation costs: CPU seconds of the thread that does it, free of what else the machine is doing.
#pragma once

#include <functional>

#include "perp/core/types.hpp"

namespace perp {

/// CPU time that the calling thread has used so far [s].
[[nodiscard]] double thread_cpu_seconds();

struct TimingOptions {
  double spend = 0.02;       ///< a computation is repeated until it has taken so long in all [s]; 0: once
  double least_span = 2e-3;  ///< one measurement takes at least so long: short computations go in batches [s]
  int least_repeats = 3;     ///< measurements at least, where one is shorter than `spend`
};

/// The least CPU time that `work` took: the best of repeated measurements, since everything that disturbs only adds.
/// A computation of `spend` seconds or more runs once.
[[nodiscard]] double best_cpu_seconds(const std::function<void()>& work, const TimingOptions& options = {});

}  // namespace perp
