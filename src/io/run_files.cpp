#include "perp/io/run_files.hpp"

#include <cmath>
#include <string>
#include <vector>

#include "perp/core/errors.hpp"
#include "perp/io/csv_file.hpp"

namespace perp {
namespace {

std::vector<std::string> trajectory_header(const Model& model) {
  std::vector<std::string> header{"t"};
  const auto add = [&](const Body& body, std::initializer_list<const char*> parts) {
    for (const char* part : parts) header.push_back(body.name + "." + part);
  };
  for (const Body& body : model.bodies()) {
    switch (body.kind) {
      case BodyKind::Spatial:
        add(body, {"x", "y", "z", "qw", "qx", "qy", "qz", "vx", "vy", "vz", "wx", "wy", "wz"});
        break;
      case BodyKind::Planar:
        add(body, {"x", "y", "angle", "vx", "vy", "omega"});
        break;
      case BodyKind::Particle:
        add(body, {"x", "y", "z", "vx", "vy", "vz"});
        break;
      case BodyKind::Generalized:
        for (int i = 1; i <= body.nq; ++i) header.push_back(body.name + ".q" + std::to_string(i));
        for (int i = 1; i <= body.nv; ++i) header.push_back(body.name + ".v" + std::to_string(i));
        break;
      case BodyKind::Ground:
      case BodyKind::Prescribed:
        break;  // no coordinates
    }
  }
  return header;
}

/// Coordinates and velocities as the state has them, except a spatial body's angular velocity, there in body axes.
void add_state(CsvFile& file, const Model& model, const State& x) {
  file.cell(x.t);
  for (int b = 0; b < static_cast<int>(model.bodies().size()); ++b) {
    const Body& body = model.body({b});
    const bool spatial = body.kind == BodyKind::Spatial;
    for (int i = 0; i < body.nq; ++i) file.cell(x.q[body.q0 + i]);
    for (int i = 0; i < (spatial ? 3 : body.nv); ++i) file.cell(x.nu[body.v0 + i]);
    if (!spatial) continue;
    for (const double w : model.angular_velocity(x, {b})) file.cell(w);
  }
  file.end_row();
}

void add_contacts(CsvFile& file, const Model& model, const StepReport& report) {
  for (const ContactRow& row : report.contacts) {
    const Contact& contact = model.contacts()[static_cast<std::size_t>(row.contact)];
    file.cell(report.t).cell((*report.point_names)[static_cast<std::size_t>(row.point)]);
    file.cell(model.body(contact.a).name).cell(model.body(contact.b).name).cell(row.gap);
    for (const double n : row.normal) file.cell(n);
    file.cell(row.p_n);
    for (const double p : row.impulse) file.cell(p);
    for (int i = 0; i < 3; ++i)
      file.cell(report.h > 0 ? std::isnan(row.force[i]) ? row.impulse[i] / report.h : row.force[i]
                             : row.force[i]);
    file.cell(name_of(row.mode)).end_row();
  }
}

void add_joints(CsvFile& file, const StepReport& report) {
  for (std::size_t i = 0; i < report.joints.size(); ++i) {
    const JointImpulse& joint = report.joints[i];
    file.cell(report.t).cell((*report.joint_names)[i]).cell(joint.value).cell(joint.rate);
    for (const double p : joint.impulse) file.cell(p / report.h);
    for (const double p : joint.moment) file.cell(p / report.h);
    file.cell(joint.friction / report.h).cell(name_of(joint.mode)).end_row();
  }
}

void add_figures(CsvFile& file, const StepFigures& step) {
  const Residuals& r = step.residuals;
  file.cell(step.t).cell(step.h).cell(name_of(step.status)).cell(step.advanced() ? 1 : 0);
  file.cell(step.solver).cell(step.iterations);
  for (const double value :
       {r.newton_euler, r.kinematic, r.joints, r.normal, r.friction, step.gap_min, step.joint_error,
        step.energy, step.energy_friction, step.energy_impact, step.projection}) {
    file.cell(value);
  }
  file.end_row();
}

}  // namespace

void write_run(const std::filesystem::path& folder, const Model& model, const Trajectory& run,
               const RunFilesOptions& options) {
  if (options.every < 1) refuse("write_run", "every", options.every, "needs to be at least 1");
  CsvFile trajectory(folder / "trajectory.csv", trajectory_header(model));
  CsvFile contacts(folder / "contacts.csv", {"t", "contact", "a", "b", "gap", "nx", "ny", "nz", "pn", "px",
                                             "py", "pz", "fx", "fy", "fz", "mode"});
  CsvFile joints(folder / "joints.csv", {"t", "joint", "coordinate", "rate", "fx", "fy", "fz", "mx", "my",
                                         "mz", "friction", "mode"});
  CsvFile report(folder / "report.csv",
                 {"t", "h", "status", "advanced", "solver", "iterations", "res_newton_euler", "res_kinematic",
                  "res_joints", "res_normal", "res_friction", "gap_min", "joint_error", "energy",
                  "energy_friction", "energy_impact", "projection"});
  if (run.size() > 0) add_state(trajectory, model, run.front());
  for (std::size_t step = 0; step < run.steps(); ++step) {
    const std::size_t taken = step + 1;
    if (taken % static_cast<std::size_t>(options.every) != 0 && taken != run.steps()) continue;
    add_state(trajectory, model, run.state(taken));
    const StepReport taken_step = run.report(step);
    add_contacts(contacts, model, taken_step);
    add_joints(joints, taken_step);
    add_figures(report, run.figures(step));
  }
  if (options.failed != nullptr) add_figures(report, *options.failed);
  if ((run.between || !run.events.empty())) {
    CsvFile events(folder / "events.csv", {"t", "kind", "contact", "before", "after"});
    for (const Event& event : run.events)
      events.cell(event.t)
          .cell(name_of(event.kind))
          .cell(event.contact)
          .cell(name_of(event.before))
          .cell(name_of(event.after))
          .end_row();
    events.finish();
  }
  trajectory.finish();
  contacts.finish();
  joints.finish();
  report.finish();
}

}  // namespace perp
