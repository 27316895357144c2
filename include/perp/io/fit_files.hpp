// A fit as files: tables, residuals drawn, a page.
#pragma once

#include <filesystem>
#include <string>

#include "perp/study/fit.hpp"

namespace perp {

/// Writes into `folder` (which it makes)
///   fit.csv         name,value,low,high,identifiable,note: a row a free quantity; identifiable 1 or 0, the numbers empty where 0
///   residuals.csv   motion,column,t,measured,fitted,residual,held_back: a row a measured cell
///   prediction.csv  motion,body,what,rows,rms,largest,end: of what was held back
///   residuals.svg   with residuals.gnuplot, which draws it
///   fit.html        a page with all of it
/// and returns why there is no picture, or an empty text. Throws std::runtime_error if the disk refuses what is written.
[[nodiscard]] std::string write_fit(const FitResult& result, const std::filesystem::path& folder);

/// The fit in lines for a terminal.
[[nodiscard]] std::string summary_of(const FitResult& result);

}  // namespace perp
