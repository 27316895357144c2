// What `perp run` left in a folder, read back to be looked at.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "perp/core/pose.hpp"
#include "perp/study/scene.hpp"

namespace perp {

/// Where a body is at one row, and how it moves. World axes.
struct Moment {
  Pose X;
  Twist V;
};

/// A body's motion as trajectory.csv has it.
struct BodyMotion {
  enum class Kind { Spatial, Planar, Particle, Generalized } kind = Kind::Spatial;
  std::string name;
  std::vector<Moment> moments;  ///< one a row; of a generalized body none
  std::vector<double> q, v;     ///< of a generalized body: `freedoms` numbers a row
  int freedoms = 0;
};

/// A series of numbers over the times of rows of its own.
struct Series {
  std::string name;  ///< "energy", "hinge.angle", ...
  std::vector<double> t, y;
};

struct RunEvent {
  double t = 0;
  std::string kind, contact, before, after;
};

/// A contact point over one step: force on b [N] in world axes (impulse over h; of an impact, whose step has no length, zero).
struct ContactMoment {
  int name = 0;  ///< in RecordedRun::contact_names
  double gap = 0;
  Vector3 normal = Vector3::UnitZ();
  Vector3 force = Vector3::Zero();
  double normal_force = 0;
  char mode = 'o';  ///< o open, k stick, p slip
};

/// A run's folder: trajectory.csv, report.csv, and, where they are, contacts.csv, joints.csv, events.csv, run.json.
struct RecordedRun {
  std::string name;  ///< of the scene, else of the folder
  std::string method,
      status;  ///< from run.json; empty if it is not there. `status` says why a run ended early
  std::optional<Scene> scene;      ///< of run.json; without it bodies have no solids
  std::string no_scene;            ///< why there is no scene, a sentence
  std::vector<double> t;           ///< of trajectory.csv's rows
  std::vector<BodyMotion> bodies;  ///< in the file's order
  std::vector<Series> series;      ///< numbers of report.csv and joints.csv
  std::vector<RunEvent> events;
  std::vector<double> contact_t;                     ///< times of contacts.csv, ascending, each once
  std::vector<std::vector<ContactMoment>> contacts;  ///< at each of them
  std::vector<std::string> contact_names, contact_bodies_a, contact_bodies_b;

  int find_body(std::string_view body) const;  ///< -1 if there is none
};

/// Reads `folder`. Throws std::invalid_argument naming the file, line and column for a folder that holds no run, a table that
/// does not fit, rows whose time goes back, and the first NaN among coordinates and velocities.
[[nodiscard]] RecordedRun read_recorded_run(const std::filesystem::path& folder);

}  // namespace perp
