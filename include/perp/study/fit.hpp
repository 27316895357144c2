// A scene's parameters from measured motions: bounded least squares, intervals, and what the data cannot tell.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "perp/step/methods.hpp"
#include "perp/study/scene.hpp"

namespace perp {

/// What was measured of one motion: rows at times, some of the columns of trajectory.csv.
struct MeasuredMotion {
  std::string name;                       ///< of the file, without folder and extension
  std::vector<std::string> columns = {};  ///< BODY.x ..., without t
  std::vector<double> t = {};             ///< by the data's own clock, rising [s]
  Matrix values = {};                     ///< (rows, columns); NaN: not measured
};

/// Something that a fit may change, within bounds:
///   a parameter of the scene                                    mu
///   where a body starts (each motion has its own)               BODY.x .y .z .rx .ry .rz, or .qw .qx .qy .qz for all of the
///                                                               rotation; planar BODY.angle; generalized BODY.q1 ...
///   how it starts                                               BODY.vx .vy .vz .wx .wy .wz; BODY.omega; BODY.v1 ...
///   all of that                                                 BODY.start
///   the data's clock: model time = offset + rate t              clock.offset [s] (each motion its own), clock.rate [-]
///   the data's frame: p_data = scale R p + d                    frame.x .y .z [m], frame.rx .ry .rz [rad], frame.scale [-]
/// rx, ry, rz are a rotation vector in world axes [rad] that turns the scene's start.
struct FreeQuantity {
  std::string name;
  double low = -infinity, high = infinity;
};

struct FitProblem {
  /// The scene with some of its parameters set; may throw std::invalid_argument for values that it cannot take.
  std::function<Scene(const SceneParameters&)> scene;
  std::vector<MeasuredMotion> measured;        ///< fitted to
  std::vector<MeasuredMotion> held_back = {};  ///< predicted, with a start found from their beginning
  std::vector<FreeQuantity> free;
  SceneParameters set = {};  ///< parameters that start from, or stay at, these values
  std::string method = "ncp2";
  MethodOptions options = {};
  double h =
      not_set;  ///< step of methods that need one [s]; a sixteenth of the data's median interval if not set
  double hold_back =
      0;  ///< in [0, 1): this share of `measured` moves to `held_back`; of one motion alone its last rows
  unsigned seed = 1;  ///< of which motions those are, and of the search
  int jobs = 1;       ///< threads
  /// Each motion's own quantities from its rows before the first contact, and kept: where these are far better known than the model
  /// follows what comes after. They then have no intervals.
  bool starts_first = false;
  long search_runs =
      -1;  ///< runs for the derivative-free search at most; -1: by the number of parameters; 0: none
  std::function<void(const std::string& what)> progress = {};  ///< called now and then
};

/// One row of the answer.
struct FittedValue {
  std::string name;        ///< NAME, or NAME\@MOTION of what each of several motions has its own
  double value = not_set;  ///< NaN where the data do not tell
  double low = not_set, high = not_set;  ///< 95 % interval from curvature, within the bounds
  bool identifiable = false;             ///< whether the data tell it
  std::string note = {};                 ///< "at its upper bound", or the flat direction it belongs to
};

/// How far a motion is from what was measured.
struct FitResidual {
  std::string motion, column;
  double t = 0, measured = 0, fitted = 0;
  bool held_back = false;  ///< it had no part in the fit
};

/// The error of the prediction of one body's motion, over rows that had no part in the fit: of a position or velocity the length of
/// the difference, of an orientation the angle of the rotation between.
struct PredictionError {
  std::string motion, body;
  std::string what;  ///< position [m], rotation [rad], velocity [m/s], spin [rad/s], coordinate, rate
  int rows = 0;      ///< predicted
  double rms = 0, largest = 0, end = 0;  ///< over them; at the last one
};

enum class FitStatus {
  Converged,    ///< at a minimum
  BudgetSpent,  ///< iterations ran out before
  NoRun,        ///< no start was found from which the scene runs: there is no answer
};

struct FitResult {
  FitStatus status = FitStatus::NoRun;
  std::string message;                   ///< how it ended, a sentence
  std::vector<std::string> search = {};  ///< how each NLopt search ended, a sentence each
  std::vector<FittedValue> values = {};  ///< in the order of `free`
  std::vector<std::string> flat = {};    ///< directions along which the data do not change, a sentence each
  std::vector<FitResidual> residuals = {};
  std::vector<PredictionError> prediction = {};
  struct Noise {
    std::string column;
    double sigma = 0;  ///< standard deviation of its residuals, in the column's unit
    long cells = 0;
  };
  std::vector<Noise> noise = {};
  double correlation =
      0;  ///< of neighbouring residuals; intervals are wider by what it takes from the data's number
  long runs = 0, failed = 0;  ///< of the scene, all together; those that failed, each of which cost a penalty
  bool fitted() const { return status != FitStatus::NoRun; }
};

/// Bounded least squares: min over the free quantities of sum rho((model - measured)/sigma), a derivative-free search (NLopt)
/// over the parameters first, then Levenberg-Marquardt over all, the motions' beginnings before their ends. sigma is each column's,
/// found with the rest. doc/fit.md says how. Throws std::invalid_argument for a problem that is none.
[[nodiscard]] FitResult fit(const FitProblem& problem);

}  // namespace perp
