#include "perp/io/run_files.hpp"

#include <chrono>
#include <cmath>
#include <optional>
#include <string>
#include <vector>

#include "io/run_columns.hpp"
#include "io/run_hdf5.hpp"
#include "io/run_table.hpp"
#include "model/motion_columns.hpp"
#include "perp/core/errors.hpp"

namespace perp {

std::vector<RunColumn> trajectory_header(const Model& model) {
  std::vector<RunColumn> header{{"t"}};
  for (std::string& name : motion_columns(model)) header.push_back({std::move(name)});
  return header;
}

namespace {

void add_state(RunTable& file, const Model& model, const State& x, std::vector<double>& row) {
  file.cell(x.t);
  motion_row(model, x, row);
  for (const double value : row) file.cell(value);
  file.end_row();
}

void add_contact(RunTable& file, const Model& model, const StepReport& report, const ContactRow& row,
                 bool halves) {
  const ContactView contact = model.contact(row.contact);
  file.cell(report.t).cell((*report.point_names)[static_cast<std::size_t>(row.point)]);
  file.cell(model.body(contact.a).name).cell(model.body(contact.b).name).cell(row.gap);
  for (const double n : row.normal) file.cell(n);
  file.cell(row.p_n);
  for (const double p : row.impulse) file.cell(p);
  for (int i = 0; i < 3; ++i)
    file.cell(report.h > 0 ? std::isnan(row.force[i]) ? row.impulse[i] / report.h : row.force[i]
                           : row.force[i]);
  file.cell(name_of(row.mode));
  if (model.contact_with_moments() != nullptr)
    for (const double m : row.moment) file.cell(m);
  if (halves) file.cell(row.half);
  file.end_row();
}

void add_contacts(RunTable& file, const Model& model, const StepReport& report, bool halves) {
  auto half = report.halves.begin();
  for (const ContactRow& row : report.contacts) {
    add_contact(file, model, report, row, halves);
    if (!halves) continue;
    for (; half != report.halves.end() && half->point == row.point; ++half)
      add_contact(file, model, report, *half, halves);
  }
}

void add_joints(RunTable& file, const StepReport& report) {
  for (std::size_t i = 0; i < report.joints.size(); ++i) {
    const JointImpulse& joint = report.joints[i];
    file.cell(report.t).cell((*report.joint_names)[i]).cell(joint.value).cell(joint.rate);
    for (const double p : joint.impulse) file.cell(p / report.h);
    for (const double p : joint.moment) file.cell(p / report.h);
    file.cell(joint.friction / report.h).cell(name_of(joint.mode)).end_row();
  }
}

/// `error`: null where there is no such column.
void add_figures(RunTable& file, const StepFigures& step, const double* error) {
  const Residuals& r = step.residuals;
  file.cell(step.t).cell(step.h).cell(name_of(step.status)).cell(step.advanced() ? 1 : 0);
  file.cell(step.solver).cell(step.iterations);
  for (const double value :
       {r.newton_euler, r.kinematic, r.joints, r.normal, r.friction, step.gap_min, step.joint_error,
        step.energy, step.energy_friction, step.energy_impact, step.energy_load, step.energy_motor,
        step.energy_surface, step.energy_overlap, step.energy_left, step.projection}) {
    file.cell(value);
  }
  if (error != nullptr) file.cell(*error);
  file.end_row();
}

std::vector<RunColumn> columns(std::initializer_list<const char*> names) {
  std::vector<RunColumn> all;
  for (const std::string_view name : names) {
    const bool text = name.ends_with(':');
    all.push_back({std::string(name.substr(0, name.size() - (text ? 1 : 0))), text});
  }
  return all;
}

// Their columns; those of text end in a colon.
const auto contact_columns = {"t",  "contact:", "a:", "b:", "gap", "nx", "ny", "nz",
                              "pn", "px",       "py", "pz", "fx",  "fy", "fz", "mode:"};
const auto joint_columns = {"t",  "joint:", "coordinate", "rate", "fx",       "fy",
                            "fz", "mx",     "my",         "mz",   "friction", "mode:"};
const auto report_columns = {"t",
                             "h",
                             "status:",
                             "advanced",
                             "solver:",
                             "iterations",
                             "res_newton_euler",
                             "res_kinematic",
                             "res_joints",
                             "res_normal",
                             "res_friction",
                             "gap_min",
                             "joint_error",
                             "energy",
                             "energy_friction",
                             "energy_impact",
                             "energy_load",
                             "energy_motor",
                             "energy_surface",
                             "energy_overlap",
                             "energy_left",
                             "projection"};
const auto event_columns = {"t", "kind:", "contact:", "before:", "after:"};

}  // namespace

struct RunFiles::Tables {
  using Clock = std::chrono::steady_clock;

  Tables(const Model& m, const RunFilesOptions& options)
      : model(m),
        every(static_cast<std::size_t>(options.every)),
        taken(options.taken),
        halves(options.halves),
        error_estimate(options.error_estimate) {}

  const Model& model;
  std::size_t every, taken;
  bool halves;
  std::function<double(const State&)> error_estimate;
  std::map<std::string, std::unique_ptr<RunTable>> all;
  RunTable *trajectory = nullptr, *contacts = nullptr, *joints = nullptr, *report = nullptr,
           *events = nullptr;
  bool pending = false;  // the last step is not kept, unless it stays the last
  State last;
  std::vector<double> row;
  StepReport last_report;
  Clock::time_point flushed = Clock::now();

  void keep(const State& x, const StepReport& step) {
    add_state(*trajectory, model, x, row);
    add_contacts(*contacts, model, step, halves);
    add_joints(*joints, step);
    const double error = error_estimate ? error_estimate(x) : not_set;
    add_figures(*report, step, error_estimate ? &error : nullptr);
  }
};

RunFiles::RunFiles(const std::filesystem::path& folder, const Model& model, const State& start,
                   const RunFilesOptions& options) {
  if (options.every < 1) refuse("write_run", "every", options.every, "needs to be at least 1");
  tables_ = std::make_unique<Tables>(model, options);
  std::optional<Hdf5Tables> hdf5;
  if (options.hdf5) hdf5.emplace(folder, !options.positions.empty());
  const auto open = [&](const char* name, const std::vector<RunColumn>& header) {
    const auto at = options.positions.find(name);
    const std::uintmax_t position = at == options.positions.end() ? 0 : at->second;
    std::unique_ptr<RunTable>& table = tables_->all[name];
    if (hdf5)
      table = hdf5->table(name, header, position);
    else
      table = std::make_unique<CsvTable>(folder / (std::string(name) + ".csv"), header, position);
    return table.get();
  };
  tables_->trajectory = open("trajectory", trajectory_header(model));
  std::vector<RunColumn> contacts = columns(contact_columns);
  if (model.contact_with_moments() != nullptr)
    for (const char* name : {"tx", "ty", "tz"}) contacts.push_back({name});
  if (options.halves) contacts.push_back({"half"});
  tables_->contacts = open("contacts", contacts);
  tables_->joints = open("joints", columns(joint_columns));
  std::vector<RunColumn> report = columns(report_columns);
  if (options.error_estimate) report.push_back({"error_estimate"});
  tables_->report = open("report", report);
  if (options.events) tables_->events = open("events", columns(event_columns));
  if (options.positions.empty()) add_state(*tables_->trajectory, model, start, tables_->row);
  flush();
}

RunFiles::~RunFiles() = default;

void RunFiles::step(const State& x, const StepReport& report) {
  Tables& t = *tables_;
  t.pending = ++t.taken % t.every != 0;
  if (t.pending) {
    t.last = x;
    t.last_report = report;
    return;
  }
  t.keep(x, report);
  constexpr auto soon = std::chrono::milliseconds(250);
  if (Tables::Clock::now() - t.flushed >= soon) flush();
}

void RunFiles::event(const Event& event) {
  if (tables_->events == nullptr) return;
  tables_->events->cell(event.t)
      .cell(name_of(event.kind))
      .cell(event.contact)
      .cell(name_of(event.before))
      .cell(name_of(event.after))
      .end_row();
}

void RunFiles::flush() {
  for (const auto& [name, table] : tables_->all) table->flush();
  tables_->flushed = Tables::Clock::now();
}

RunPositions RunFiles::positions() const {
  RunPositions positions;
  for (const auto& [name, table] : tables_->all) positions[name] = table->position();
  return positions;
}

void RunFiles::finish(const StepReport* failed) {
  Tables& t = *tables_;
  if (t.pending) t.keep(t.last, t.last_report);
  t.pending = false;
  if (failed != nullptr) add_figures(*t.report, *failed, t.error_estimate ? &not_set : nullptr);
  for (const auto& [name, table] : t.all) table->close();
}

void write_run(const std::filesystem::path& folder, const Model& model, const Trajectory& run,
               const RunFilesOptions& options) {
  RunFilesOptions how = options;
  how.events = run.locates_events || !run.events.empty();
  RunFiles files(folder, model, run.size() > 0 ? run.front() : model.rest(), how);
  for (std::size_t i = 0; i < run.steps(); ++i) files.step(run.state(i + 1), run.report(i));
  for (const Event& event : run.events) files.event(event);
  files.finish(options.failed);
}

}  // namespace perp
