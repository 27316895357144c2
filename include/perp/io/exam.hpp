// The exam: questions with known answers, put to methods and to motions from elsewhere, with one tolerance and one step for all.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "perp/study/scene.hpp"

namespace perp {

/// How a value is held against the right one.
enum class ExamRule {
  Near,    ///< |value - right| <= tolerance
  AtMost,  ///< value <= right + tolerance
  AtLeast  ///< value >= right - tolerance
};

/// One number of a motion. `what` is an expression of t and of coordinates as trajectory.csv names them ("ball.x", "hypot" not among
/// them), at the state nearest to the time t; or one of
///   error        configuration_error against the scene's exact motion at t [m, rad]
///   moved        the largest configuration_error of any state against the first [m, rad]
///   overlap      the deepest, max(0, -min psi_n) over the run [m]
///   joint_error  the largest over the run [m, rad]
///   speed        the largest |nu| at t [m/s, rad/s]
///   energy_gain  how far the energy ever rises above that of the start [J]
///   energy_drift the largest |E - E at the start| [J]
///   turning_lost the largest relative change of the angular momentum about the centre of mass of the first body [-]
struct ExamQuantity {
  std::string what;
  double t = 0;  ///< [s]
  double right = 0, tolerance = 0;
  ExamRule rule = ExamRule::Near;
};

struct ExamQuestion {
  std::string name;
  std::string scene;  ///< a built-in one
  SceneParameters set = {};
  double until = 1, step = 1e-3;  ///< T and h of methods with steps of fixed size [s]; others have rtol 1e-9
  bool quick = false;             ///< part of the quick exam
  std::vector<ExamQuantity> quantities = {};
  std::string why = {};  ///< what it tells methods apart by, one sentence
};

enum class ExamVerdict { Pass, Fail, SaidSo, NotApplicable };
[[nodiscard]] std::string_view name_of(ExamVerdict verdict);  ///< "pass", "fail", "said-so", "not-applicable"

/// A row of exam.csv.
struct ExamAnswer {
  std::string method, question, quantity;
  double value = not_set, right = 0, tolerance = 0;
  ExamVerdict verdict = ExamVerdict::Fail;
  std::string reason = {};   ///< of said-so and not-applicable, and of what ran out of time
  double seconds = not_set;  ///< CPU time of the run
};

[[nodiscard]] const std::vector<ExamQuestion>& exam_questions();
[[nodiscard]] const ExamQuestion& exam_question(std::string_view name);

/// A motion graded: an answer for each quantity. A motion that ends before a quantity's time fails in it, and so does a value that is
/// no number.
[[nodiscard]] std::vector<ExamAnswer> grade(const ExamQuestion& question, const Scene& scene,
                                            const std::vector<State>& motion, const std::string& method);

/// The question put to a method: its run, graded. A step that fails is said-so with its reason, which is not passed; a run that takes
/// more than `seconds` of CPU fails.
[[nodiscard]] std::vector<ExamAnswer> take(const ExamQuestion& question, const std::string& method,
                                           double seconds = 60);

/// exam.csv: method,question,quantity,value,right,tolerance,verdict,rule,reason,seconds.
void write_exam_csv(const std::filesystem::path& path, const std::vector<ExamAnswer>& answers);

/// DIR/QUESTION/question.json and, of scenes that a file can say, scene.toml.
void write_exam(const std::filesystem::path& folder, bool quick);

/// The motion in DIR/QUESTION/trajectory.csv; columns as `perp run` writes them, of the bodies that have velocities. Throws
/// std::invalid_argument naming file, line and column.
[[nodiscard]] std::vector<State> read_motion(const Model& model, const std::filesystem::path& trajectory);

/// How the questions of part C went, methods side by side: the page doc/failures.md, as Markdown.
[[nodiscard]] std::string failures_page(const std::vector<ExamAnswer>& answers);

}  // namespace perp
