#include "step/impacts/inelastic_step.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "perp/instant/reduced_system.hpp"
#include "perp/solve/friction_solver.hpp"
#include "perp/step/simulate.hpp"
#include "solve/friction/even_friction.hpp"
#include "step/certificate/certificate.hpp"
#include "step/parts/contact_blocks.hpp"
#include "step/parts/free_rotation.hpp"
#include "step/parts/moment_laws.hpp"
#include "step/run/step_record.hpp"

namespace perp {

namespace {

/// The step in hand: what closes within it, and the impulses found.
class InelasticStep {
 public:
  InelasticStep(const Model& model, const State& x, double h) : model_(model), x_(x), h_(h) {}

  bool find_velocity(Vector& nu, int& iterations);
  void report_contacts(StepReport& report);
  void report_joints(StepReport& report);

  const Instant& start() const { return s_; }
  StepAnswer answer;

 private:
  void begin();
  bool add_closing(const Vector& nu);
  FrictionProblem pose();

  const Model& model_;
  const State& x_;
  double h_;
  Instant s_;
  Vector nu_free_, joint_bias_;
  Island island_;
  std::vector<char> taken_;  // of the contacts: in the island
  ReducedSystem reduced_;
  Vector r_, reactions_;  // impulses of the problem's rows, of the joint rows
};

void InelasticStep::begin() {
  Vector load = s_.k;
  implicit_gyroscopic(model_, x_, h_, load);
  solve_mass(model_, s_, load, nu_free_);
  nu_free_ = x_.nu + h_ * nu_free_;
  island_.joint_rows.resize(s_.joint_rows.size());
  std::iota(island_.joint_rows.begin(), island_.joint_rows.end(), 0);
  island_.joint_frictions.resize(s_.joint_frictions.size());
  std::iota(island_.joint_frictions.begin(), island_.joint_frictions.end(), 0);
  joint_bias_.resize(static_cast<Eigen::Index>(s_.joint_rows.size()));
  for (std::size_t i = 0; i < s_.joint_rows.size(); ++i)
    joint_bias_[static_cast<Eigen::Index>(i)] = s_.joint_rows[i].psi_b_t;
  reactions_.setZero(joint_bias_.size());
  taken_.assign(s_.contacts.size(), 0);
  answer.joint_bias = joint_bias_;
}

/// Takes the contacts that close within h at nu; whether any.
bool InelasticStep::add_closing(const Vector& nu) {
  bool added = false;
  for (std::size_t i = 0; i < s_.contacts.size(); ++i) {
    if (taken_[i] != 0 || s_.contacts[i].psi_n + h_ * s_.contacts[i].velocity(nu).x() > 0) continue;
    taken_[i] = 1;
    added = true;
    auto& contacts = island_.contacts;
    contacts.insert(std::upper_bound(contacts.begin(), contacts.end(), int(i)), int(i));
  }
  return added;
}

FrictionProblem InelasticStep::pose() {
  reduced_.assemble(model_, s_, island_, nu_free_, joint_bias_);
  FrictionProblem problem;
  problem.W = reduced_.W;
  problem.q = reduced_.q;
  ContactBlocks blocks;
  for (std::size_t i = 0; i < island_.contacts.size(); ++i) {
    const ContactInstant& c = s_.contacts[static_cast<std::size_t>(island_.contacts[i])];
    const int row = reduced_.rows_of(static_cast<int>(i));
    (void)blocks.add(s_, c, row);
    // the projection takes overlaps away, without adding velocity
    problem.q[row] += std::max(c.psi_n, 0.0) / h_;
  }
  for (std::size_t i = 0; i < s_.joint_frictions.size(); ++i)
    blocks.add_interval(reduced_.friction_row(static_cast<int>(i)), h_ * s_.joint_frictions[i].friction);
  blocks.give(problem);
  return problem;
}

/// nu+, over all contacts that close within h at it.
bool InelasticStep::find_velocity(Vector& nu, int& iterations) {
  evaluate(model_, x_, s_);
  if (!s_.fault.empty()) return false;
  begin();
  nu = nu_free_;
  add_closing(nu);
  Vector impulse, k;
  Matrix C;
  do {
    const FrictionProblem problem = pose();
    r_.setZero(reduced_.size());
    if (problem.rows() > 0) {
      reduced_.compliance(model_, s_, island_, C, k);
      const FrictionSolution solution = solve_evenly(problem, C, k);
      if (!solution.solved()) return false;
      r_ = solution.r;
      iterations += solution.iterations;
    }
    impulse.setZero(model_.nv());
    reduced_.add_impulses(s_, island_, r_, impulse, reactions_);
    solve_mass(model_, s_, impulse, nu);
    nu += nu_free_;
  } while (add_closing(nu));
  return true;
}

void InelasticStep::report_contacts(StepReport& report) {
  constexpr double at_bound = 1 - 1e-9;  // of the law's bound: less is in it
  for (std::size_t i = 0; i < island_.contacts.size(); ++i) {
    const ContactInstant& c = s_.contacts[static_cast<std::size_t>(island_.contacts[i])];
    const int row = reduced_.rows_of(static_cast<int>(i));
    Vector3 p = Vector3::Zero(), p_m = Vector3::Zero();
    p.head(1 + c.tangents) = r_.segment(row, 1 + c.tangents);
    answer.first.push_back({.source = c.point, .p = p, .gap = std::max(c.psi_n, 0.0) / h_});
    double pull = p.tail<2>().norm(), bound = c.mu * p.x();
    if (const MomentInstant* m = s_.moments_of(c); m != nullptr) {
      for (int j = 0; j < m->rows(c.tangents); ++j)
        p_m[m->columns(c.tangents)[static_cast<std::size_t>(j)]] = r_[moment_row(c, row) + j];
      const double lever = lever_of(model_, s_, c, *m);
      answer.first.push_back({.of = Reaction::Of::Moments, .source = c.point, .p = p_m, .lever = lever});
      pull = sliding_pull(c, *m, p, p_m, lever);
      bound = p.x();
    }
    if (!(p.x() > 0)) continue;
    const bool sticks = c.tangents > 0 && pull < bound * at_bound;
    report.contacts.push_back(contact_row(c, p, sticks ? ContactMode::Stick : ContactMode::Slip));
    report.contacts.back().moment = c.frame * p_m;
    report.contacts.back().gap = 0;
    report.contacts.back().force = c.frame * p / h_;
  }
}

void InelasticStep::report_joints(StepReport& report) {
  constexpr double at_bound = 1 - 1e-9;
  begin_joints(model_, report);
  const auto give = [&](Reaction::Of of, std::size_t i, double p) {
    answer.first.push_back({.of = of, .source = static_cast<int>(i), .p = {p, 0, 0}});
  };
  for (std::size_t i = 0; i < s_.joint_rows.size(); ++i) {
    const double p = reactions_[static_cast<Eigen::Index>(i)];
    give(Reaction::Of::JointRow, i, p);
    add_joint_reaction(s_.joint_rows[i], p, report);
  }
  for (std::size_t i = 0; i < s_.joint_frictions.size(); ++i) {
    const double p = r_[reduced_.friction_row(static_cast<int>(i))],
                 most = h_ * s_.joint_frictions[i].friction;
    give(Reaction::Of::JointFriction, i, p);
    add_joint_friction(s_.joint_frictions[i], p,
                       std::abs(p) < most * at_bound ? ContactMode::Stick : ContactMode::Slip, report);
  }
}

}  // namespace

bool inelastic_step(const Model& model, State& x, double h, StepReport& report) {
  InelasticStep step(model, x, h);
  State moved = x;
  if (!step.find_velocity(moved.nu, report.iterations)) return false;
  move(model, moved.nu, h, moved.q);
  moved.t = x.t + h;
  model.follow_turns(moved);
  step.answer.h = h;
  step.answer.nu_q = moved.nu;
  step.answer.q_moved = moved.q;
  if (!moved.q.allFinite() || !moved.nu.allFinite()) return false;
  const Vector nu = moved.nu;
  const Projection projection = project_onto_constraints(model, moved);
  moved.nu = nu;  // what would change it is an impulse
  if (!projection.reached) return false;
  report.projection = projection.moved;

  step.report_contacts(report);
  step.report_joints(report);
  Instant end;
  evaluate(model, moved, end);
  end_joints(end, moved.nu, report);
  report.h = h;
  (void)Certificate().certify(model, step.start(), x, model.energy(x), end, moved, step.answer, report);
  x = moved;
  return true;
}

}  // namespace perp
