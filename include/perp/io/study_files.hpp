// A study as tables and charts: study.csv, orders.csv, error against step, error against CPU time.
#pragma once

#include <filesystem>
#include <vector>

#include "perp/io/chart.hpp"
#include "perp/study/convergence.hpp"

namespace perp {

/// study.csv: scene,method,parameter,h,rtol,error_q,error_v,seconds,steps,iterations,failed,error_limit,message,reference,bar_q,bar_v,error_path,error_p;
/// a row a run, StudyRun and Reference say what each is; errors within the reference's bar are empty. Appears whole or not at all; throws like CsvFile.
void write_study_csv(const std::filesystem::path& path, const std::vector<ConvergenceTable>& tables);

/// orders.csv: scene,method,parameter,reference,order,order_v,points,expected,failed,note,bar,h_least,h_most,slopes,why,order_path,order_p; a row an
/// OrderRow, `slopes` the local ones from the largest steps to the smallest. Orders that errors do not show are empty, and the note says
/// why.
void write_orders_csv(const std::filesystem::path& path, const std::vector<ConvergenceTable>& tables);

/// What a row has to say besides its numbers: why there is no order, which runs failed.
[[nodiscard]] std::string note_of(const OrderRow& row);

/// Slopes between neighbouring points, "0.98 1.01 1.00", the largest steps first.
[[nodiscard]] std::string local_slopes(const ObservedOrder& order);

/// Error in configuration over the step h, a line a method; dashed where it is against the method's own limit, and dotted
/// where the method stays away from the exact motion; a triangle for each order expected; a cross for a run that failed.
[[nodiscard]] Chart convergence_chart(const ConvergenceTable& table);

/// Error in configuration over CPU seconds, a line a method.
[[nodiscard]] Chart work_chart(const ConvergenceTable& table);

}  // namespace perp
