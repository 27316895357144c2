// A study as one page that opens from the disk: charts, orders, failures, machines.
#pragma once

#include <filesystem>
#include <set>
#include <string>
#include <vector>

#include "perp/io/study_folder.hpp"

namespace perp {

struct StudyPage {
  const StudyRequest& request;
  const StudyOutcome& outcome;
  const std::set<std::string>& machines;
  std::vector<const ScenePlan*> scenes;  ///< as long as outcome.tables
};

/// Stem of the files of a scene's charts: its name, with '-' for what does not belong into a file's name.
[[nodiscard]] std::string chart_name(const std::string& scene);

/// HTML with nothing outside of it: the charts CHART_NAME-convergence.svg and -work.svg are taken from the folder.
[[nodiscard]] std::string write_page(const StudyPage& page, const std::filesystem::path& folder);

}  // namespace perp
