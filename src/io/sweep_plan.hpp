// A sweep made definite: the values of each run, and the request as text.
#pragma once

#include <string>
#include <vector>

#include "perp/io/sweep.hpp"

namespace perp {

struct SweepRun {
  long number = 0;  ///< from 0, in the order of sweep.csv
  std::size_t method = 0;
  std::vector<double> values;  ///< of the axes
};

/// Throws std::invalid_argument for a request that cannot be run.
void check_sweep(const SweepRequest& request);

[[nodiscard]] long sweep_size(const SweepRequest& request);
[[nodiscard]] SweepRun sweep_run(const SweepRequest& request, long number);

/// The request as text, a line "WORD VALUE" for each thing asked, and back. A file is named by its whole path.
[[nodiscard]] std::string write_sweep_request(const SweepRequest& request);
[[nodiscard]] SweepRequest read_sweep_request(const std::filesystem::path& file);

}  // namespace perp
