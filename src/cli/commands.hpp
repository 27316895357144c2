// The subcommands of the program `perp`, one file each: what a command reads, does and prints stands there.
#pragma once

#include <CLI/CLI.hpp>
#include <cstdio>
#include <exception>
#include <string>
#include <vector>

namespace perp {

/// How a command ended; also the exit status of `perp`. With several files the largest.
enum ExitStatus {
  Done = 0,
  ToleranceNotReached = 1,  ///< a step or a problem; what was computed is written
  BadInput = 2,             ///< arguments, scene or data file: std::invalid_argument, or CLI11's own errors
  InternalError = 3,        ///< any other exception
};

/// What an exception says; never nothing.
[[nodiscard]] std::string sentence_of(const std::exception& error);

/// Flushes standard output; throws std::runtime_error with the system's reason if it did not take all that was printed.
void need_written(std::FILE* out);

// Each adds its subcommand to `perp`. When the command line names it, it runs while the line is parsed and
// leaves in `status` how it ended; it throws as the library does.
void add_run_command(CLI::App& perp, const std::vector<std::string>& command_line, int& status);
void add_view_command(CLI::App& perp, int& status);
void add_study_command(CLI::App& perp, int& status);
void add_fit_command(CLI::App& perp, int& status);
void add_scenes_command(CLI::App& perp, int& status);
void add_check_command(CLI::App& perp, int& status);
void add_methods_command(CLI::App& perp, int& status);
void add_solve_command(CLI::App& perp, int& status);
void add_generate_command(CLI::App& perp, int& status);
void add_exam_command(CLI::App& perp, int& status);

}  // namespace perp
