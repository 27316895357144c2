#include "run_files.hpp"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <sstream>
#include <stdexcept>

namespace checker {

Csv::Csv(const std::string& path) {
  std::ifstream file(path);
  if (!file) throw std::runtime_error("cannot read " + path);
  std::string line;
  const auto cells = [&] {
    std::vector<std::string> all(1);
    bool quoted = false;
    for (const char c : line) {
      if (c == '"') quoted = !quoted;
      if (c == ',' && !quoted)
        all.emplace_back();
      else if (c != '"')
        all.back() += c;
    }
    return all;
  };
  std::getline(file, line);
  const auto header = cells();
  for (std::size_t i = 0; i < header.size(); ++i) columns_[header[i]] = i;
  while (std::getline(file, line)) {
    rows_.push_back(cells());
    if (rows_.back().size() != header.size())
      throw std::runtime_error(path + ": a row of another length than the header");
  }
}

const std::string& Csv::text(std::size_t row, const std::string& column) const {
  const auto found = columns_.find(column);
  if (found == columns_.end()) throw std::runtime_error("no column " + column);
  return rows_[row][found->second];
}

double Csv::number(std::size_t row, const std::string& column) const {
  const std::string& cell = text(row, column);
  if (cell.empty()) return not_given;
  char* end = nullptr;
  const double value = std::strtod(cell.c_str(), &end);
  if (*end != 0) throw std::runtime_error("'" + cell + "' in column " + column + " is no number");
  return value;
}

namespace {

Vector3d vector(const Csv& csv, std::size_t row, const std::string& x, const std::string& y,
                const std::string& z) {
  return {csv.number(row, x), csv.number(row, y), csv.number(row, z)};
}

State read_state(const Scene& scene, const Csv& csv, std::size_t row) {
  State x;
  x.t = csv.number(row, "t");
  x.bodies.resize(scene.bodies.size());
  prescribe(scene, x);
  for (std::size_t i = 0; i < scene.bodies.size(); ++i) {
    const Body& body = scene.bodies[i];
    if (!body.moves()) continue;
    BodyState& s = x.bodies[i];
    const std::string of = body.name + ".";
    if (body.kind == Kind::Planar) {
      s.at.p = {csv.number(row, of + "x"), csv.number(row, of + "y"), 0};
      s.angle = csv.number(row, of + "angle");
      s.at.q = Quaterniond(Eigen::AngleAxisd(s.angle, Vector3d::UnitZ()));
      s.v = {csv.number(row, of + "vx"), csv.number(row, of + "vy"), 0};
      s.w = {0, 0, csv.number(row, of + "omega")};
      continue;
    }
    s.at.p = vector(csv, row, of + "x", of + "y", of + "z");
    s.v = vector(csv, row, of + "vx", of + "vy", of + "vz");
    if (body.kind == Kind::Particle) continue;
    s.at.q = Quaterniond(csv.number(row, of + "qw"), csv.number(row, of + "qx"), csv.number(row, of + "qy"),
                         csv.number(row, of + "qz"));
    s.w = vector(csv, row, of + "wx", of + "wy", of + "wz");
  }
  return x;
}

ContactRow read_contact(const Csv& csv, std::size_t row) {
  ContactRow c;
  c.t = csv.number(row, "t");
  c.contact = csv.text(row, "contact");
  c.mode = csv.text(row, "mode");
  c.gap = csv.number(row, "gap");
  c.normal = vector(csv, row, "nx", "ny", "nz");
  c.p_n = csv.number(row, "pn");
  c.p = vector(csv, row, "px", "py", "pz");
  c.f = vector(csv, row, "fx", "fy", "fz");
  if (csv.has("half")) c.half = static_cast<int>(csv.number(row, "half"));
  return c;
}

/// What a row of contacts.csv belongs to: a step of length, an impact, or a change of modes; 0 where it does not say.
enum class RowOf { Any, Step, Impact, Change };
RowOf row_of(const ContactRow& row) {
  if (std::isnan(row.f.x())) return RowOf::Impact;
  if (row.p.isZero(0)) return row.f.isZero(0) ? RowOf::Any : RowOf::Change;
  return RowOf::Step;
}

/// The rows of a time, shared out to the step that ends there and to those of length 0 that follow it there: a name that comes again,
/// or a row of another kind, begins the next one's.
void share_out(const std::vector<ContactRow>& rows, std::size_t step, Run& run) {
  std::size_t at = step;
  RowOf kind = RowOf::Any;
  for (const ContactRow& row : rows) {
    const auto same_name = [&](const ContactRow& c) { return c.contact == row.contact; };
    auto& before = run.contacts[at];
    const bool again = row.half == 0 && std::any_of(before.begin(), before.end(), same_name);
    const RowOf is = row_of(row);
    const bool other = is != RowOf::Any && kind != RowOf::Any && is != kind;
    const bool jumps = at + 1 < run.steps.size() && run.steps[at + 1].t == run.steps[step].t;
    const bool late = at == step && run.steps[step].h > 0 && (is == RowOf::Impact || is == RowOf::Change);
    if (jumps && (again || other || late)) {
      ++at;
      kind = RowOf::Any;
    }
    if (is != RowOf::Any) kind = is;
    run.contacts[at].push_back(row);
  }
}

}  // namespace

Run read_run(const Scene& scene, const std::string& folder) {
  Run run;
  const Csv trajectory(folder + "/trajectory.csv"), contacts(folder + "/contacts.csv"),
      joints(folder + "/joints.csv"), report(folder + "/report.csv");
  for (std::size_t i = 0; i < trajectory.rows(); ++i) run.states.push_back(read_state(scene, trajectory, i));
  for (std::size_t i = 0; i < report.rows(); ++i) {
    StepRow row;
    row.t = report.number(i, "t");
    row.h = report.number(i, "h");
    row.status = report.text(i, "status");
    row.solver = report.text(i, "solver");
    row.advanced = report.number(i, "advanced") != 0;
    for (const char* column :
         {"res_newton_euler", "res_kinematic", "res_joints", "res_normal", "res_friction", "gap_min",
          "joint_error", "energy", "energy_friction", "energy_impact", "energy_load", "energy_motor",
          "energy_surface", "energy_overlap", "energy_left", "projection"})
      if (report.has(column)) row.of[column] = report.number(i, column);
    if (row.advanced)
      run.steps.push_back(row);
    else
      run.failed = true;
  }
  if (run.states.size() != run.steps.size() + 1)
    throw std::runtime_error("trajectory.csv and report.csv do not fit together");
  run.contacts.resize(run.steps.size());
  run.joints.resize(run.steps.size());
  std::size_t at = 0;
  for (std::size_t i = 0; i < run.steps.size(); ++i) {
    std::vector<ContactRow> rows;
    for (; at < contacts.rows() && contacts.number(at, "t") == run.steps[i].t; ++at)
      rows.push_back(read_contact(contacts, at));
    share_out(rows, i, run);
  }
  if (at != contacts.rows()) throw std::runtime_error("contacts.csv has rows of no step");

  const std::size_t each = run.steps.empty() ? 0 : joints.rows() / run.steps.size();
  if (each * run.steps.size() != joints.rows()) throw std::runtime_error("joints.csv: rows are missing");
  for (std::size_t i = 0; i < run.steps.size(); ++i)
    for (std::size_t k = i * each; k < (i + 1) * each; ++k)
      run.joints[i].push_back({joints.text(k, "joint"), joints.text(k, "mode"),
                               joints.number(k, "coordinate"), joints.number(k, "rate"),
                               joints.number(k, "friction"), vector(joints, k, "fx", "fy", "fz"),
                               vector(joints, k, "mx", "my", "mz")});
  return run;
}

}  // namespace checker
