// perp check: a scene read, counted, and looked at where it starts.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <memory>
#include <string>
#include <vector>

#include "cli/check_prices.hpp"
#include "cli/commands.hpp"
#include "cli/parameters.hpp"
#include "cli/start_faults.hpp"
#include "perp/core/errors.hpp"
#include "perp/instant/reduced_system.hpp"
#include "perp/io/scene_file.hpp"
#include "perp/step/simulate.hpp"
#include "step/parts/joint_projection.hpp"

namespace perp {
namespace {

const char* name_of(BodyKind kind) {
  constexpr const char* names[] = {"ground", "prescribed", "particle", "planar", "spatial", "generalized"};
  return names[static_cast<std::size_t>(kind)];
}

std::string triple(const Vector3& v) {
  return "(" + shortest(v.x()) + ", " + shortest(v.y()) + ", " + shortest(v.z()) + ")";
}

std::string moments(const Contact& c) {
  std::string text;
  if (c.torsion > 0) text += ", torsion = " + shortest(c.torsion) + " m";
  if (c.rolling > 0) text += ", rolling = " + shortest(c.rolling) + " m";
  if (c.friction_axes)
    text += " along t and " + shortest(c.friction_axes->mu.y()) + " along o of axes fixed to " +
            (c.friction_axes->of == FrictionAxes::Of::A ? "a" : "b");
  return text;
}

/// Those that may touch; of many pairs of shapes their number alone.
void report_contacts(const Model& model) {
  constexpr std::size_t most_lines = 1000;
  if (model.touching_contacts() > std::max(most_lines, model.contacts().size())) {
    std::printf("%zu contacts, and up to %zu pairs of shapes that may touch\n", model.contacts().size(),
                model.touching_contacts() - model.contacts().size());
    return;
  }
  model.each_contact([&](int i) {
    const ContactView c = model.contact(i);
    std::printf("contact %s: %s on %s, %d point%s, mu = %s%s, e = %s\n", model.contact_name(i).c_str(),
                model.body(c.b).name.c_str(), model.body(c.a).name.c_str(), c.gap.points(),
                c.gap.points() == 1 ? "" : "s", shortest(c.law.mu).c_str(), moments(c.law).c_str(),
                shortest(c.law.e).c_str());
  });
}

void report_model(const Scene& scene, const Instant& now) {
  const Model& model = scene.model;
  std::printf("%s: %s\n", scene.name.c_str(), scene.what.c_str());
  std::printf("t_end = %s s, gravity = %s m/s^2\n", shortest(scene.t_end).c_str(),
              triple(model.gravity()).c_str());
  for (const SceneParameter& p : scene.parameters)
    std::printf("parameter %s = %s  %s\n", p.name.c_str(), shortest(p.value).c_str(), p.what.c_str());
  for (int i = 1; i < static_cast<int>(model.bodies().size()); ++i) {
    const Body& b = model.body({i});
    std::printf("body %s: %s", b.name.c_str(), name_of(b.kind));
    if (b.nv > 0 && b.mass > 0) std::printf(", %s kg", shortest(b.mass).c_str());
    std::printf(", at %s m\n", triple(now.X[static_cast<std::size_t>(i)].p).c_str());
  }
  for (const BodyShape& s : model.shapes())
    std::printf("shape %s.%s: %s%s\n", model.body(s.body).name.c_str(), s.name.c_str(),
                std::string(s.shape.name()).c_str(), s.material.empty() ? "" : (", " + s.material).c_str());
  report_contacts(model);
  for (const JointGeometry& j : model.joints())
    std::printf("joint %s: %s to %s, %zu equations\n", j.name.c_str(), model.body(j.a).name.c_str(),
                model.body(j.b).name.c_str(), j.rows.size());
  std::printf("springs %zu, forces %zu\n", model.springs().size(), model.forces().size());
  const int rank = joint_rank(model, now);
  std::printf("degrees of freedom %d: %d velocities, %zu joint equations of rank %d\n", model.nv() - rank,
              model.nv(), now.joint_rows.size(), rank);
}

/// What the file has that the scene does not.
void report_unused(const Scene& scene) {
  for (const std::string& what : scene.unused) std::printf("not used: %s\n", what.c_str());
  if (!scene.unused.empty()) std::printf("%zu things of the file are not used\n", scene.unused.size());
}

/// What does not fit together at the start; returns how many contacts and joints.
int report_start(const Scene& scene, const Instant& now) {
  const Model& model = scene.model;
  const StartJudge judge(scene, now);
  int found = 0;
  const auto report = [&](const std::vector<StartFault>& faults) {
    for (const StartFault& fault : faults) std::printf("inconsistent: %s\n", fault.what.c_str());
    found += faults.empty() ? 0 : 1;
  };
  for (const ContactInstant& c : now.contacts) {
    std::printf("gap %s = %.6g m, changing at %.6g m/s\n",
                (*model.point_names())[static_cast<std::size_t>(c.point)].c_str(), c.psi_n,
                c.velocity(scene.start.nu)[0]);
    report(judge.contact(c));
  }
  for (std::size_t j = 0; j < model.joints().size(); ++j) {
    const auto [error, speed] = judge.joint_error(j);
    std::printf("joint error %s = %.6g, changing at %.6g\n", model.joints()[j].name.c_str(), error, speed);
    report(judge.joint(j));
  }
  return found;
}

/// What assembly would make of a start that is not consistent.
void report_assembly(const Scene& scene) {
  State x = scene.start;
  const Projection found = project_onto_constraints(scene.model, x);
  if (found.reached) {
    std::printf("perp run --assemble moves it by %.6g m or rad and %.6g m/s or rad/s to one that is\n",
                found.moved, found.moved_velocity);
    return;
  }
  std::printf("no start near to it is: after %d steps of assembly\n", found.iterations);
  Instant now;
  evaluate(scene.model, x, now);
  for (int j = 0; j < static_cast<int>(scene.model.joints().size()); ++j) {
    double error = 0;
    for (const JointRowInstant& row : now.joint_rows)
      if (row.joint == j) error = std::max(error, std::abs(row.psi_b));
    if (error > 1e-9 * found.joint_error && error > 0)
      std::printf("joint %s disagrees with others by %.6g m or rad\n", scene.model.joint({j}).name.c_str(),
                  error);
  }
}

/// Where joints can't hold what motions ask for: followed from the start through the run's time, as assembly follows them, wherever
/// equations are more than the freedoms that they take.
void report_motion(const Scene& scene, const Instant& now) {
  constexpr int looks = 64;
  const bool redundant = joint_rank(scene.model, now) < static_cast<int>(now.joint_rows.size());
  if (!redundant) return;
  State x = scene.start;
  for (int i = 1; i <= looks; ++i) {
    x.t = scene.start.t + (scene.t_end - scene.start.t) * i / looks;
    const std::string names = contradicting_joints(scene.model, x);
    if (names.empty()) continue;
    std::printf("joints contradict each other at t = %s s: open at best %s\n", shortest(x.t).c_str(),
                names.c_str());
    return;
  }
}

}  // namespace

void add_check_command(CLI::App& perp, int& status) {
  struct Arguments {
    std::string scene;
    std::vector<std::string> set;
  };
  CLI::App* command =
      perp.add_subcommand("check", "Read a scene, say what is in it and whether its start is consistent");
  const auto arguments = std::make_shared<Arguments>();
  command
      ->add_option("SCENE", arguments->scene,
                   "a scene file, a robot (.urdf), or a built-in scene (perp scenes)")
      ->required();
  command->add_option("--set", arguments->set, "a parameter of the scene, repeatable")
      ->type_name("KEY=VALUE")
      ->expected(1)
      ->take_all();
  command->callback([&status, arguments] {
    const Scene scene = load_scene(arguments->scene, read_parameters("perp check", arguments->set));
    Instant now;
    evaluate(scene.model, scene.start, now);
    if (!now.fault.empty()) refuse("perp check", "the start", now.fault, "needs to be finite");
    report_model(scene, now);
    report_unused(scene);
    const int found = report_start(scene, now);
    std::printf(found == 0 ? "the start is consistent\n" : "the start is not consistent; it can be run\n");
    if (found > 0)
      report_assembly(scene);
    else
      report_motion(scene, now);
    print_prices(scene);
    status = Done;
  });
}

}  // namespace perp
