#include "perp/io/exam.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <nlohmann/json.hpp>

#include "core/files.hpp"
#include "io/observables.hpp"
#include "perp/core/errors.hpp"
#include "perp/instant/instant.hpp"
#include "perp/io/csv_file.hpp"
#include "perp/io/csv_reader.hpp"
#include "perp/io/scene_file.hpp"
#include "perp/step/methods.hpp"
#include "perp/step/simulate.hpp"
#include "perp/study/cpu_time.hpp"
#include "perp/study/error_measure.hpp"

namespace perp {
namespace {

constexpr double rtol = 1e-9;  // of methods that choose their steps

/// The state at t, the last of those; null if the motion ends before.
const State* state_at(const std::vector<State>& motion, double t, double t_start) {
  const double near = 1e-9 * (t - t_start);
  if (motion.empty() || motion.back().t < t - near) return nullptr;
  const State* best = nullptr;
  for (const State& x : motion) {
    if (best == nullptr || std::abs(x.t - t) <= std::abs(best->t - t)) best = &x;
    if (x.t > t + near) break;
  }
  return best;
}

/// The largest over the motion's states up to t.
double largest(const std::vector<State>& motion, double t, const std::function<double(const State&)>& of) {
  double most = 0;
  for (const State& x : motion) {
    if (x.t > t * (1 + 1e-9) + 1e-12) break;
    const double value = of(x);
    if (!(value <= most)) most = value;
    if (std::isnan(most)) break;
  }
  return most;
}

double overlap_at(const Model& model, const State& x) {
  Instant s;
  evaluate(model, x, s);
  return s.fault.empty() ? std::max(0.0, -s.gap_min()) : not_set;
}

double joints_at(const Model& model, const State& x) {
  Instant s;
  evaluate(model, x, s);
  return s.joint_error();
}

double measured(const ExamQuantity& quantity, const Scene& scene, const std::vector<State>& motion) {
  const Model& model = scene.model;
  const State& start = scene.start;
  const State* at = state_at(motion, quantity.t, start.t);
  if (at == nullptr || !at->q.allFinite() || !at->nu.allFinite()) return not_set;
  const auto most = [&](const std::function<double(const State&)>& of) {
    return largest(motion, quantity.t, of);
  };
  const std::string& what = quantity.what;
  if (what == "error") return configuration_error(model, *at, scene.exact(quantity.t));
  if (what == "moved") return most([&](const State& x) { return configuration_error(model, x, start); });
  if (what == "overlap") return most([&](const State& x) { return overlap_at(model, x); });
  if (what == "joint_error") return most([&](const State& x) { return joints_at(model, x); });
  if (what == "speed") return at->nu.size() == 0 ? 0 : at->nu.lpNorm<Eigen::Infinity>();
  const double before = model.energy(start);
  if (what == "energy_gain")
    return most([&](const State& x) { return std::max(0.0, model.energy(x) - before); });
  if (what == "energy_drift") return most([&](const State& x) { return std::abs(model.energy(x) - before); });
  if (what == "turning_lost") {
    const Body& b = model.body({1});
    const auto L = [&](const State& x) -> Vector3 {
      return model.pose(x, {1}).q * (b.J * Vector3(x.nu.segment<3>(b.v0 + 3)));
    };
    return most([&](const State& x) { return (L(x) - L(start)).norm() / L(start).norm(); });
  }
  const std::vector<Observable> all = observables_of(model);
  std::vector<std::string> names;
  for (const Observable& q : all) names.push_back(q.name);
  return observed(Expression(what, {}, names), all)(model, *at);
}

bool passes(const ExamQuantity& q, double value) {
  if (q.rule == ExamRule::Near) return std::abs(value - q.right) <= q.tolerance;
  return q.rule == ExamRule::AtMost ? value <= q.right + q.tolerance : value >= q.right - q.tolerance;
}

const char* name_of(ExamRule rule) {
  return rule == ExamRule::Near ? "near" : rule == ExamRule::AtMost ? "at-most" : "at-least";
}

/// All quantities of a question with one verdict.
std::vector<ExamAnswer> all_of(const ExamQuestion& question, const std::string& method, ExamVerdict verdict,
                               const std::string& reason) {
  std::vector<ExamAnswer> answers;
  for (const ExamQuantity& q : question.quantities)
    answers.push_back({.method = method,
                       .question = question.name,
                       .quantity = q.what,
                       .right = q.right,
                       .tolerance = q.tolerance,
                       .verdict = verdict,
                       .reason = reason});
  return answers;
}

}  // namespace

std::string_view name_of(ExamVerdict verdict) {
  constexpr std::array<std::string_view, 4> names{"pass", "fail", "said-so", "not-applicable"};
  return names[static_cast<std::size_t>(verdict)];
}

std::vector<ExamAnswer> grade(const ExamQuestion& question, const Scene& scene,
                              const std::vector<State>& motion, const std::string& method) {
  std::vector<ExamAnswer> answers = all_of(question, method, ExamVerdict::Fail, "");
  for (std::size_t i = 0; i < answers.size(); ++i) {
    const ExamQuantity& q = question.quantities[i];
    answers[i].value = measured(q, scene, motion);
    if (passes(q, answers[i].value)) answers[i].verdict = ExamVerdict::Pass;
    if (std::isnan(answers[i].value))
      answers[i].reason =
          state_at(motion, q.t, scene.start.t) == nullptr ? "the motion ends before" : "no number";
  }
  return answers;
}

std::vector<ExamAnswer> take(const ExamQuestion& question, const std::string& method_name, double seconds) {
  const Scene s = scene(question.scene, question.set);
  const Method& method = perp::method(method_name);
  if (method.adaptive && !has_sundials())
    return all_of(question, method_name, ExamVerdict::NotApplicable, "perp was built without SUNDIALS");
  const auto stepper = method.make({.tolerance = rtol});
  const double begin = thread_cpu_seconds();
  const auto spent = [&] { return thread_cpu_seconds() - begin; };
  std::vector<ExamAnswer> answers;
  try {
    const Trajectory run = simulate(
        s.model, *stepper, s.start,
        {.t_end = question.until, .h = question.step, .progress = [&](double) { return spent() < seconds; }});
    std::vector<State> motion;
    for (std::size_t i = 0; i < run.size(); ++i) motion.push_back(run.state(i));
    const bool late = spent() >= seconds && motion.back().t < question.until;
    answers = grade(question, s, motion, method_name);
    for (ExamAnswer& a : answers)
      if (late) a.verdict = ExamVerdict::Fail, a.reason = "not done in " + shortest(seconds) + " s";
  } catch (const StepFailure& failure) {
    answers = all_of(question, method_name, ExamVerdict::SaidSo, failure.what());
  }
  for (ExamAnswer& a : answers) a.seconds = spent();
  return answers;
}

void write_exam_csv(const std::filesystem::path& path, const std::vector<ExamAnswer>& answers) {
  CsvFile csv(path, {"method", "question", "quantity", "value", "right", "tolerance", "verdict", "rule",
                     "reason", "seconds"});
  for (const ExamAnswer& a : answers) {
    const ExamQuestion& question = exam_question(a.question);
    const auto q = std::find_if(question.quantities.begin(), question.quantities.end(),
                                [&](const ExamQuantity& other) { return other.what == a.quantity; });
    csv.cell(a.method).cell(a.question).cell(a.quantity).cell(a.value).cell(a.right).cell(a.tolerance);
    csv.cell(name_of(a.verdict)).cell(name_of(q->rule)).cell(a.reason).cell(a.seconds).end_row();
  }
  csv.finish();
}

void write_exam(const std::filesystem::path& folder, bool quick) {
  using Json = nlohmann::ordered_json;
  for (const ExamQuestion& question : exam_questions()) {
    if (quick && !question.quick) continue;
    const std::filesystem::path place = folder / question.name;
    std::filesystem::create_directories(place);
    const Scene s = scene(question.scene, question.set);
    std::string text, why_not;
    try {
      text = write_scene(s);
      replace_file(place / "scene.toml", text);
    } catch (const std::invalid_argument& error) {
      why_not = error.what();
    }
    Json quantities = Json::array();
    for (const ExamQuantity& q : question.quantities)
      quantities.push_back({{"quantity", q.what},
                            {"t", q.t},
                            {"right", q.right},
                            {"tolerance", q.tolerance},
                            {"rule", name_of(q.rule)}});
    Json json = {{"question", question.name}, {"why", question.why},     {"scene", question.scene},
                 {"set", question.set},       {"until", question.until}, {"step", question.step},
                 {"quick", question.quick},   {"quantities", quantities}};
    if (!why_not.empty()) json["no_scene_file"] = why_not;
    replace_file(place / "question.json", json.dump(2) + "\n");
  }
}

std::vector<State> read_motion(const Model& model, const std::filesystem::path& trajectory) {
  CsvReader csv(trajectory);
  const int time = csv.need("t");
  std::vector<State> motion;
  while (csv.next()) {
    State x = model.rest();
    x.t = csv.number(time);
    if (!motion.empty() && !(x.t >= motion.back().t)) csv.refuse_cell(time, "needs not to go back");
    for (int i = 1; i < static_cast<int>(model.bodies().size()); ++i) {
      const Body& b = model.body({i});
      if (b.nv == 0) continue;
      const auto cell = [&](const std::string& name) { return csv.number(csv.need(b.name + "." + name)); };
      if (b.kind == BodyKind::Generalized) {
        for (int k = 0; k < b.nv; ++k) {
          x.q[b.q0 + k] = cell("q" + std::to_string(k + 1));
          x.nu[b.v0 + k] = cell("v" + std::to_string(k + 1));
        }
      } else if (b.kind == BodyKind::Planar) {
        x.q.segment<3>(b.q0) << cell("x"), cell("y"), cell("angle");
        x.nu.segment<3>(b.v0) << cell("vx"), cell("vy"), cell("omega");
      } else {
        x.q.segment<3>(b.q0) << cell("x"), cell("y"), cell("z");
        x.nu.segment<3>(b.v0) << cell("vx"), cell("vy"), cell("vz");
      }
      if (b.kind == BodyKind::Spatial) {
        Quaternion q(cell("qw"), cell("qx"), cell("qy"), cell("qz"));
        if (!(std::abs(q.norm() - 1) < 1e-6))
          csv.refuse_cell(csv.need(b.name + ".qw"), "needs a unit quaternion");
        q.normalize();
        x.q.segment<4>(b.q0 + 3) << q.w(), q.x(), q.y(), q.z();
        x.nu.segment<3>(b.v0 + 3) = q.conjugate() * Vector3(cell("wx"), cell("wy"), cell("wz"));
      }
    }
    motion.push_back(std::move(x));
  }
  return motion;
}

}  // namespace perp
