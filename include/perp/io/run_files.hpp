// A run as tables for other programs: trajectory.csv, contacts.csv, joints.csv, report.csv.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <string>

#include "perp/step/simulate.hpp"

namespace perp {

/// For each table where its next row goes: bytes of CSV, rows of HDF5.
using RunPositions = std::map<std::string, std::uintmax_t>;

struct RunFilesOptions {
  int every = 1;  ///< >= 1: keeps the steps every, 2 every, ... and the last
  const StepReport* failed =
      nullptr;  ///< of write_run: the step at which the run ended, if it failed: a last row of report.csv
  bool hdf5 = false;            ///< the tables as groups of run.h5, in place of CSV files
  bool halves = false;          ///< whether contacts.csv has a column for them: Stepper::halves of the method
  bool events = false;          ///< of RunFiles: whether there is a table of events
  std::size_t taken = 0;        ///< steps that the tables already have, of a run that is taken up again
  RunPositions positions = {};  ///< of these; what follows them is given up
  /// If there is one: of each state kept its distance from the motion [m, rad], in a last column error_estimate of report.csv.
  std::function<double(const State&)> error_estimate = {};
};

/// A run of a model as files in a folder, written while it goes on. All vectors in world axes, units SI, angles in radians.
///
/// trajectory.csv: t, then the coordinates and velocities of each body, in the model's order: spatial
///   and prescribed NAME.x .y .z .qw .qx .qy .qz .vx .vy .vz .wx .wy .wz, planar NAME.x .y .angle .vx .vy .omega, particle NAME.x .y
///   .z .vx .vy .vz, generalized NAME.q1 .. .v1 ... A row for the first state and one for the end of each step kept.
/// contacts.csv: t,contact,a,b,gap,nx,ny,nz,pn,px,py,pz,fx,fy,fz,mode: a row for each contact point in reach in a step
///   kept; t and gap at the step's end, p the impulse on b over the step [N s], f = p/h the force [N]. With `halves` one more
///   column, half: 0 the sum, 1 and 2 its halves, each with its own normal (StepReport::halves), f over h too.
/// report.csv: t,h,status,advanced,solver,iterations,res_newton_euler,res_kinematic,res_joints,res_normal,res_friction,
///   gap_min,joint_error,energy,energy_friction,energy_impact,energy_load,energy_motor,energy_surface,energy_overlap,energy_left,
///   projection: the StepFigures of the steps kept; advanced is 1 or 0; nan where the method has no such part. error_estimate, if asked for.
/// joints.csv: t,joint,coordinate,rate,fx,fy,fz,mx,my,mz,friction,mode: a row for each coordinate of each joint (JOINT.COORDINATE
///   where it has several; a joint that has none has one row without) in a step kept; coordinate and rate at the step's end; f and m
///   what the joint's equations give to b at its anchor there, world axes [N, N m], friction what its dry friction gives along
///   the coordinate; mode stick where friction holds it, else slip.
///
/// events.csv, of methods that locate events, and of runs that have events of the user's: t,kind,contact,before,after; modes open, stick, slip. There the trajectory has the
///   accepted steps and two rows at an event, the second of length 0, where an impact's contacts have impulses and no force; f is
///   the force at t.
///
/// What a run has come to is on the disk within a quarter of a second, or a step where that takes longer: rows are whole whenever it ends.
/// Throws std::invalid_argument if every < 1 or a file cannot be made, std::runtime_error if the disk refuses what is written or a
/// file is no longer there.
class RunFiles : public RunSink {
 public:
  RunFiles(const std::filesystem::path& folder, const Model& model, const State& start,
           const RunFilesOptions& options = {});
  ~RunFiles() override;  ///< what was not flushed is lost

  void step(const State& x, const StepReport& report) override;
  void event(const Event& event) override;

  void flush();                    ///< all rows so far are in the files
  RunPositions positions() const;  ///< after flush(), with the run at a step that is kept or to be passed
  void finish(const StepReport* failed =
                  nullptr);  ///< the last row, and the step at which the run ended, if it failed

 private:
  struct Tables;
  std::unique_ptr<Tables> tables_;
};

/// All of a run that was kept in memory.
void write_run(const std::filesystem::path& folder, const Model& model, const Trajectory& run,
               const RunFilesOptions& options = {});

}  // namespace perp
