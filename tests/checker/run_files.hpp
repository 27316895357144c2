// What a run left in its files: trajectory.csv, contacts.csv, joints.csv, report.csv, read as anyone may read them.
#pragma once

#include "mechanics.hpp"

namespace checker {

/// A CSV file, columns by name; an empty cell is NaN.
class Csv {
 public:
  explicit Csv(const std::string& path);  // throws std::runtime_error
  std::size_t rows() const { return rows_.size(); }
  bool has(const std::string& column) const { return columns_.contains(column); }
  const std::string& text(std::size_t row, const std::string& column) const;
  double number(std::size_t row, const std::string& column) const;

 private:
  std::map<std::string, std::size_t> columns_;
  std::vector<std::vector<std::string>> rows_;
};

struct ContactRow {
  double t = 0, gap = 0, p_n = 0;
  std::string contact, mode;
  Vector3d normal = Vector3d::Zero(), p = Vector3d::Zero(), f = Vector3d::Zero();
  int half = 0;
};
struct JointReport {
  std::string joint, mode;
  double coordinate = 0, rate = 0, friction = 0;
  Vector3d force = Vector3d::Zero(), moment = Vector3d::Zero();
};
struct StepRow {
  double t = 0, h = 0;
  bool advanced = false;
  std::string status, solver;
  std::map<std::string, double> of;  // all other columns
};

struct Run {
  std::vector<State> states;                      // one more than steps
  std::vector<StepRow> steps;                     // those that advanced
  std::vector<std::vector<ContactRow>> contacts;  // of each step
  std::vector<std::vector<JointReport>> joints;   // of each step, a row a coordinate
  bool failed = false;                            // the last row of report.csv did not advance
};

[[nodiscard]] Run read_run(const Scene& scene, const std::string& folder);

}  // namespace checker
