// The part of `perp study` that sweeps parameters.
#pragma once

#include <string>
#include <vector>

#include "cli/commands.hpp"
#include "perp/io/study_folder.hpp"

namespace perp {

struct SweepArguments {
  std::vector<std::string> sweep, draw, ask;
  std::string pass;
  long long draws = 1, seed = 1;

  bool given() const { return !sweep.empty() || !draw.empty(); }
};

void add_sweep_options(CLI::App& command, SweepArguments& arguments);

/// Runs the sweep that study's other arguments and these ask for; refuses those of study that a sweep has no use for.
[[nodiscard]] int run_sweep_command(const CLI::App& command, const SweepArguments& arguments,
                                    const StudyRequest& study, const StudyOptions& options,
                                    const std::string& folder);
[[nodiscard]] int merge_sweep_command(const std::vector<std::string>& folders, const std::string& folder);

}  // namespace perp
