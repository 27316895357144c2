#include "perp/io/saved_run.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "io/run_columns.hpp"
#include "io/run_folder.hpp"
#include "io/saved_table.hpp"
#include "perp/core/errors.hpp"
#include "perp/step/simulate.hpp"
#include "step/run/dense_output.hpp"

namespace perp {
namespace {

/// Rows of trajectory.csv as states.
class SavedStates {
 public:
  SavedStates(const std::filesystem::path& folder, const Model& model)
      : model_(model), table_(read_saved_table(folder, "trajectory", {})) {
    for (const RunColumn& column : trajectory_header(model)) {
      names_.push_back(column.name);
      columns_.push_back(&table_.column(column.name));
    }
    if (table_.header.size() != names_.size())
      throw std::invalid_argument(table_.place + ": " + std::to_string(table_.header.size()) +
                                  " columns, needs the " + std::to_string(names_.size()) + " of the scene");
    if (table_.rows == 0) throw std::invalid_argument(table_.place + ": no row, needs one");
  }

  std::size_t size() const { return table_.rows; }

  /// Row i; `last` is the state before it, whose joints' turns it counts on from.
  State read(std::size_t i, const State& last) {
    row_ = i;
    column_ = 0;
    State x = last;
    x.t = next();
    if (i > 0 && x.t < last.t) table_.refuse_cell("t", i, "needs to be no earlier than the row before");
    for (int b = 1; b < static_cast<int>(model_.bodies().size()); ++b) body(x, {b});
    model_.follow_turns(x);
    return x;
  }

 private:
  double next() {
    const double value = (*columns_[column_])[row_];
    if (!std::isfinite(value)) table_.refuse_cell(names_[column_], row_, "needs to be a finite number");
    ++column_;
    return value;
  }
  Vector3 next_vector() {
    const double x = next(), y = next(), z = next();
    return {x, y, z};
  }

  void body(State& x, BodyId id) {
    const Body& b = model_.body(id);
    constexpr std::size_t prescribed = 13;  // its motion is the scene's
    if (b.kind == BodyKind::Prescribed) {
      column_ += prescribed;
      return;
    }
    const std::size_t first = column_;
    for (int i = 0; i < b.nq; ++i) x.q[b.q0 + i] = next();
    if (b.kind != BodyKind::Spatial) {
      for (int i = 0; i < b.nv; ++i) x.nu[b.v0 + i] = next();
      return;
    }
    constexpr double allowed = 1e-6;  // files hold unit quaternions to rounding
    if (std::abs(x.q.segment<4>(b.q0 + 3).norm() - 1) > allowed)
      table_.refuse_cell(names_[first + 3], row_, "needs a quaternion of length 1");
    const Vector3 v = next_vector(), w = next_vector();
    model_.set_velocity(x, id, v, w);
  }

  const Model& model_;
  SavedTable table_;
  std::vector<std::string> names_;
  std::vector<const std::vector<double>*> columns_;
  std::size_t row_ = 0, column_ = 0;
};

constexpr std::array figures{std::pair{"h", &StepFigures::h},
                             std::pair{"gap_min", &StepFigures::gap_min},
                             std::pair{"joint_error", &StepFigures::joint_error},
                             std::pair{"projection", &StepFigures::projection},
                             std::pair{"energy", &StepFigures::energy},
                             std::pair{"energy_friction", &StepFigures::energy_friction},
                             std::pair{"energy_impact", &StepFigures::energy_impact},
                             std::pair{"energy_load", &StepFigures::energy_load},
                             std::pair{"energy_motor", &StepFigures::energy_motor},
                             std::pair{"energy_surface", &StepFigures::energy_surface},
                             std::pair{"energy_overlap", &StepFigures::energy_overlap},
                             std::pair{"energy_left", &StepFigures::energy_left}};
constexpr std::array residuals{
    std::pair{"res_newton_euler", &Residuals::newton_euler},
    std::pair{"res_kinematic", &Residuals::kinematic}, std::pair{"res_joints", &Residuals::joints},
    std::pair{"res_normal", &Residuals::normal}, std::pair{"res_friction", &Residuals::friction}};

/// The steps that report.csv has and that moved the state.
std::vector<StepReport> read_reports(const std::filesystem::path& folder) {
  const SavedTable table = read_saved_table(folder, "report", {"status", "solver"});
  std::vector<StepReport> all;
  for (std::size_t i = 0; i < table.rows; ++i) {
    if (!(table.column("advanced")[i] == 1)) continue;
    StepReport& report = all.emplace_back();
    report.t = table.column("t")[i];
    report.status = StepStatus::Solved;
    report.solver = "saved";
    report.iterations = static_cast<int>(table.column("iterations")[i]);
    for (const auto& [name, member] : figures) report.*member = table.column(name)[i];
    for (const auto& [name, member] : residuals) report.residuals.*member = table.column(name)[i];
  }
  return all;
}

template <class Word>
Word word(const SavedTable& table, const char* column, std::size_t row, std::initializer_list<Word> all) {
  const std::string& text = table.text_column(column)[row];
  for (const Word each : all)
    if (name_of(each) == text) return each;
  table.refuse_cell(column, row, "needs a word that perp run writes there");
}

std::vector<Event> read_events(const std::filesystem::path& folder) {
  using enum EventKind;
  const auto kinds = {Touch, Lift, Stick, Slip, Reverse, Stop, Impact, Zeno, Painleve, Load, User};
  const auto modes = {ContactMode::Open, ContactMode::Stick, ContactMode::Slip};
  const SavedTable table = read_saved_table(folder, "events", {"kind", "contact", "before", "after"});
  std::vector<Event> all;
  for (std::size_t i = 0; i < table.rows; ++i)
    all.push_back({.t = table.column("t")[i],
                   .kind = word(table, "kind", i, kinds),
                   .contact = table.text_column("contact")[i],
                   .before = word(table, "before", i, modes),
                   .after = word(table, "after", i, modes)});
  return all;
}

/// Integrated anew, as the run was: from the row before, or, where that alone is no start (a ball at rest in the origin says nothing of
/// how long a length is), from one further back.
auto integrated(const Model& model, const RunRecipe& recipe) {
  return
      [kept = std::make_shared<const Model>(model), recipe](const Trajectory& run, std::size_t i, double t) {
        for (std::size_t back = 0;; back = 2 * back + 1) {
          const std::size_t row = i - std::min(i, back);
          const std::unique_ptr<Stepper> stepper = make_stepper(recipe.method, recipe.options);
          try {
            return simulate(*kept, *stepper, run.state(row), {.t_end = t}).back();
          } catch (const StepFailure&) {
            if (row == 0) throw;
          }
        }
      };
}

}  // namespace

SavedRun read_saved_run(const std::filesystem::path& folder) {
  if (!std::filesystem::is_directory(folder))
    refuse("read_saved_run", "folder", folder.string(), "needs to be a folder that perp run wrote");
  const RunRecord record = RunFolder::record_in(folder);
  SavedRun saved{.scene = make_scene(record.recipe),
                 .method = record.recipe.method,
                 .complete = record.exit_status == 0,
                 .ended = record.ended,
                 .run = {}};
  const Model& model = saved.scene.model;
  SavedStates states(folder, model);
  const std::vector<StepReport> reports = read_reports(folder);
  State x = states.read(0, saved.scene.start);
  saved.run = Trajectory(x, states.size() - 1);
  for (std::size_t i = 1; i < states.size() && i <= reports.size(); ++i) {
    x = states.read(i, x);
    if (reports[i - 1].t != x.t)
      throw std::invalid_argument(folder.string() +
                                  ": the report's step to t = " + shortest(reports[i - 1].t) +
                                  " s, needs to be that of the trajectory's row, " + shortest(x.t));
    saved.run.add(x, reports[i - 1]);
  }
  if (has_saved_table(folder, "events")) saved.run.events = read_events(folder);
  saved.run.locates_events = method(saved.method).adaptive;
  saved.run.between = saved.run.locates_events ? decltype(saved.run.between)(integrated(model, record.recipe))
                                               : cubics(model);
  return saved;
}

}  // namespace perp
