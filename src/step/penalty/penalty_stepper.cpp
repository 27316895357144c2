#include "perp/step/penalty_stepper.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <Eigen/LU>

#include "core/index.hpp"
#include "instant/scales.hpp"
#include "perp/core/errors.hpp"
#include "step/certificate/certificate.hpp"
#include "step/implicit/implicit_step.hpp"
#include "step/parts/free_rotation.hpp"
#include "step/parts/joint_projection.hpp"
#include "step/parts/stable_step.hpp"
#include "step/penalty/penalty_laws.hpp"
#include "step/run/step_record.hpp"

namespace perp {
namespace {

constexpr int most_iterations = 60;
constexpr double pass = 1e-10;  // of the speeds in the step

void need_positive(const char* what, double value, bool zero) {
  if (std::isnan(value)) return;
  if (!(value > 0 || (zero && value == 0)) || !std::isfinite(value))
    refuse("penalty", what, value, zero ? "needs to be 0 or positive" : "needs to be positive");
}

}  // namespace

struct PenaltyStepper::Workspace {
  StartInstant start;
  Instant end;
  State moved;
  std::vector<PenaltyContact> laws;
  std::vector<int> active;
  Vector load, nu_free, gap_term, nu, lambda, misfit, trial_nu, trial_misfit;
  Matrix mass, K;  // of (nu, lambda), without and with the laws' slopes
  double slip = 0, joint_slip = 0, speed = 0;
  Answer answer;
  StepAnswer step;
  Certificate certificate;
  JointProjection projection;

  void begin(const Model& model, const State& x, const PenaltyOptions& options, double h, const Instant& s);
  void impulses(const Instant& s, const Vector& at_nu, bool implicit, double h, Matrix* slopes);
  void residual(const Model& model, const Instant& s, double h, Matrix* slopes);
  void assemble_mass(const Model& model, const Instant& s);
  Vector solve_linear(const Matrix& A, const Vector& b) const;
  bool solve_implicit(const Model& model, const Instant& s, double h, StepReport& report);
  void solve_explicit(const Model& model, const Instant& s, const State& x, double h);
  bool solve(const Model& model, const State& x, const Instant& s, const PenaltyOptions& options, double h,
             StepReport& report);
  void judge(const Model& model, const State& x, const Instant& s, const StepRequest& request, bool end,
             StepReport& report);
  StepGain gain(const Model& model, const State& x, const Instant& s, const StepReport& report) const;
};

PenaltyStepper::PenaltyStepper(PenaltyOptions options)
    : options_(options), work_(std::make_unique<Workspace>()) {
  need_positive("stiffness", options.stiffness, false);
  need_positive("damping", options.damping, true);
  need_positive("slip_speed", options.slip_speed, false);
}
PenaltyStepper::~PenaltyStepper() = default;
std::unique_ptr<Stepper> PenaltyStepper::anew() const { return std::make_unique<PenaltyStepper>(options_); }

/// nu_free, the laws of all contacts, and what is slow.
void PenaltyStepper::Workspace::begin(const Model& model, const State& x, const PenaltyOptions& options,
                                      double h, const Instant& s) {
  load = s.k;
  implicit_gyroscopic(model, x, h, load);
  solve_mass(model, s, load, nu_free);
  nu_free = x.nu + h * nu_free;
  const Scales scales = scales_of(model, x, s);
  constexpr double still = 1e-9;  // of the speeds, where no load says what is slow
  slip = std::isnan(options.slip_speed) ? std::max(h * scales.acceleration, still * scales.speed)
                                        : options.slip_speed;
  slip = std::max(slip, std::numeric_limits<double>::min());
  joint_slip = slip / scales.length;
  speed = std::max({x.nu.lpNorm<Eigen::Infinity>(), nu_free.lpNorm<Eigen::Infinity>(),
                    std::numeric_limits<double>::min()});
  laws.clear();
  active.clear();
  for (std::size_t i = 0; i < s.contacts.size(); ++i) {
    laws.emplace_back(model, s, s.contacts[i], options, h, slip);
    active.push_back(static_cast<int>(i));
    speed = std::max(speed, s.contacts[i].velocity(nu_free).cwiseAbs().maxCoeff());
    if (s.contacts[i].psi_n < 0) speed = std::max(speed, -s.contacts[i].psi_n / h);
  }
  gap_term = Vector::Zero(static_cast<Eigen::Index>(s.contacts.size()));
}

/// The laws' impulses at a velocity into `answer`; their derivatives W p'(u) W^T taken off `slopes`.
void PenaltyStepper::Workspace::impulses(const Instant& s, const Vector& at_nu, bool implicit, double h,
                                         Matrix* slopes) {
  answer.impulse.setZero(at_nu.size());
  const auto take_off = [&](const auto& W, const auto& slope) {
    const auto pairs = std::array{std::tuple{W.va, W.na, &W.A}, std::tuple{W.vb, W.nb, &W.B}};
    for (const auto& [row, rows, left] : pairs)
      for (const auto& [column, columns, right] : pairs)
        slopes->block(row, column, rows, columns) -=
            left->topRows(rows) * slope * right->topRows(columns).transpose();
  };
  for (std::size_t i = 0; i < s.contacts.size(); ++i) {
    const ContactInstant& c = s.contacts[i];
    Matrix3 slope;
    const Vector3 p = laws[i].impulse(c.velocity(at_nu), implicit, slope);
    answer.p.col(static_cast<Eigen::Index>(i)) = p;
    c.W.add_impulse(p, answer.impulse);
    if (slopes != nullptr) take_off(c.W, slope);
  }
  for (std::size_t i = 0; i < s.joint_frictions.size(); ++i) {
    const JointRowInstant& row = s.joint_frictions[i];
    const bool turns = row.world.linear.isZero();
    Eigen::Matrix<double, 1, 1> p, slope;
    p[0] = regularised_friction(h * row.friction, row.velocity(at_nu), turns ? joint_slip : slip, slope(0));
    answer.joint_friction[static_cast<Eigen::Index>(i)] = p[0];
    row.W.add_impulse(p, answer.impulse);
    if (slopes != nullptr) take_off(row.W, slope);
  }
}

/// M (nu - nu_free) - W p(nu) - W_b lambda and (28) into `misfit`, at nu and lambda.
void PenaltyStepper::Workspace::residual(const Model& model, const Instant& s, double h, Matrix* slopes) {
  const Eigen::Index n = nu.size(), m = lambda.size();
  impulses(s, nu, true, h, slopes);
  misfit.resize(n + m);
  Vector momentum;
  multiply_mass(model, s, nu - nu_free, momentum);
  Vector joints = Vector::Zero(n);
  for (Eigen::Index i = 0; i < m; ++i) {
    const JointRowInstant& row = s.joint_rows[at(i)];
    row.W.add_impulse(Eigen::Matrix<double, 1, 1>(lambda[i]), joints);
    misfit[n + i] = row.velocity(nu) + row.psi_b / h;
  }
  answer.impulse += joints;
  misfit.head(n) = momentum - answer.impulse;
}

/// M, W_b and (28) as one matrix over (nu, lambda).
void PenaltyStepper::Workspace::assemble_mass(const Model& model, const Instant& s) {
  const Eigen::Index n = nu_free.size(), m = static_cast<Eigen::Index>(s.joint_rows.size());
  mass.setZero(n + m, n + m);
  Vector column;
  for (Eigen::Index i = 0; i < n; ++i) {
    multiply_mass(model, s, Vector::Unit(n, i), column);
    mass.block(0, i, n, 1) = column;
  }
  for (Eigen::Index i = 0; i < m; ++i) {
    column.setZero(n);
    s.joint_rows[at(i)].W.add_impulse(Eigen::Matrix<double, 1, 1>(1), column);
    mass.block(0, n + i, n, 1) = -column;
    mass.block(n + i, 0, 1, n) = column.transpose();
  }
}

/// Joints that repeat each other leave the matrix singular, and any of their impulses will do.
Vector PenaltyStepper::Workspace::solve_linear(const Matrix& A, const Vector& b) const {
  if (lambda.size() == 0) return A.partialPivLu().solve(b);
  return A.fullPivLu().solve(b);
}

/// Forces of the start are constants, and one linear system has the rest.
void PenaltyStepper::Workspace::solve_explicit(const Model& model, const Instant& s, const State& x,
                                               double h) {
  impulses(s, x.nu, false, h, nullptr);
  const Eigen::Index n = nu_free.size(), m = lambda.size();
  Vector b(n + m), momentum;
  multiply_mass(model, s, nu_free, momentum);
  b.head(n) = momentum + answer.impulse;
  for (Eigen::Index i = 0; i < m; ++i)
    b[n + i] = -s.joint_rows[at(i)].psi_b_t - s.joint_rows[at(i)].psi_b / h;
  const Vector z = solve_linear(mass, b);
  nu = z.head(n);
  lambda = z.tail(m);
  for (Eigen::Index i = 0; i < m; ++i)
    s.joint_rows[at(i)].W.add_impulse(Eigen::Matrix<double, 1, 1>(lambda[i]), answer.impulse);
}

/// Newton's method for nu and lambda, each step as long as the misfit falls.
bool PenaltyStepper::Workspace::solve_implicit(const Model& model, const Instant& s, double h,
                                               StepReport& report) {
  const Eigen::Index n = nu_free.size();
  const auto misses = [&] {  // as speeds
    Vector v;
    solve_mass(model, s, misfit.head(n), v);
    const double joints = lambda.size() > 0 ? misfit.tail(lambda.size()).lpNorm<Eigen::Infinity>() : 0;
    return std::max(v.size() > 0 ? v.lpNorm<Eigen::Infinity>() : 0, joints);
  };
  nu = nu_free;
  for (int i = 0; i < most_iterations; ++i) {
    K = mass;
    residual(model, s, h, &K);
    const double before = misses();
    if (before <= pass * speed) return true;
    const Vector way = solve_linear(K, -misfit), nu_old = nu, lambda_old = lambda;
    double best = infinity, best_t = 1;
    const auto go = [&](double t) {
      nu = nu_old + t * way.head(n);
      lambda = lambda_old + t * way.tail(lambda.size());
      residual(model, s, h, nullptr);
    };
    for (double t = 1; t > 1e-3; t *= 0.5) {
      go(t);
      const double now = misses();
      if (now < best) best = now, best_t = t;
      if (now < (1 - 0.1 * t) * before) break;
    }
    go(best_t);
    ++answer.iterations;
  }
  constexpr double rounding = 1e3;  // of the mark, in a stiff system
  if (misses() <= rounding * pass * speed) return true;
  report.message = "Newton's method on the penalty forces did not converge in " +
                   std::to_string(most_iterations) + " iterations, " + shortest(misses()) +
                   " m/s are left: needs a smaller step, less stiffness or a larger slip_speed";
  return false;
}

bool PenaltyStepper::Workspace::solve(const Model& model, const State& x, const Instant& s,
                                      const PenaltyOptions& options, double h, StepReport& report) {
  lambda = Vector::Zero(static_cast<Eigen::Index>(s.joint_rows.size()));
  assemble_mass(model, s);
  if (!options.explicit_forces) return solve_implicit(model, s, h, report);
  for (std::size_t i = 0; i < laws.size(); ++i) {
    if (!(s.contacts[i].psi_n < 0) || laws[i].followed(h)) continue;
    report.message = "an explicit step of " + shortest(h) + " s cannot follow the contact '" +
                     (*model.point_names())[at(s.contacts[i].point)] + "' of stiffness " +
                     shortest(laws[i].k) + " N/m and damping " + shortest(laws[i].c) + " N s/m";
    return false;
  }
  solve_explicit(model, s, x, h);
  return true;
}

/// Residuals and energies: the certificate's, but for contacts, whose laws are the penalty's own.
void PenaltyStepper::Workspace::judge(const Model& model, const State& x, const Instant& s,
                                      const StepRequest& request, bool implicit, StepReport& report) {
  for (std::size_t i = 0; i < laws.size(); ++i)
    answer.slips[i] = s.contacts[i].velocity(nu).tail<2>().norm() >= slip;
  list_impulses(model, s, answer, active, gap_term, step.first);
  record(model, s, answer, active, end, report);
  step.h = request.h;
  step.max_correction_speed = request.max_correction_speed;
  step.nu_q = nu;
  step.joint_bias.resize(lambda.size());
  for (Eigen::Index i = 0; i < lambda.size(); ++i)
    step.joint_bias[i] = s.joint_rows[at(i)].psi_b / request.h + s.joint_rows[at(i)].psi_b_t;
  (void)certificate.certify(model, s, x, start.energy(model), end, moved, step, report);
  Residuals& e = report.residuals;
  e.normal = e.friction = 0;
  Matrix3 slope;
  for (std::size_t i = 0; i < laws.size(); ++i) {
    const Vector3 p = answer.p.col(static_cast<Eigen::Index>(i));
    const Vector3 by_law = laws[i].impulse(s.contacts[i].velocity(implicit ? nu : x.nu), implicit, slope);
    e.normal = std::max(e.normal, laws[i].w * std::abs(p.x() - by_law.x()));
    e.friction = std::max(e.friction, laws[i].w * (p - by_law).tail<2>().norm());
  }
}

/// What contacts gave beyond what their springs had stored, and what is left of the balance without a cause.
StepGain PenaltyStepper::Workspace::gain(const Model& model, const State& x, const Instant& s,
                                         const StepReport& report) const {
  double stored = 0, most_stored = 0;
  for (std::size_t i = 0; i < laws.size(); ++i) {
    const int after = end.contact_of_point.empty() ? -1 : end.contact_of_point[at(s.contacts[i].point)];
    const double now = after < 0 ? 0 : laws[i].stored(end.contacts[at(after)].psi_n);
    const double first = laws[i].stored(s.contacts[i].psi_n);
    stored += now - first;
    most_stored += std::max(now, first);
  }
  StepGain gain;
  const double given = report.energy_left + report.energy_impact + report.energy_overlap + stored;
  gain.measure = std::max(model.kinetic_energy(x), model.kinetic_energy(moved)) + most_stored +
                 std::abs(report.energy_friction) + std::abs(report.energy_load);
  constexpr double rounding = 64 * std::numeric_limits<double>::epsilon();
  gain.from_nothing = std::max(0.0, given - rounding * (std::abs(report.energy) + gain.measure));
  if (!std::isfinite(given)) gain.from_nothing = given;
  return gain;
}

void PenaltyStepper::advance(const Model& model, State& x, const StepRequest& request, StepReport& report) {
  Workspace& w = *work_;
  const double h = request.h;
  const bool end = !options_.explicit_forces;
  const auto fail = [&](StepStatus status, const std::string& why) {
    report.status = status;
    report.message = why;
  };
  const Instant& s = w.start.at(model, x, h);
  if (!s.fault.empty()) return fail(StepStatus::NotFinite, s.fault);
  w.begin(model, x, options_, h, s);
  w.answer.clear(s, w.nu_free);
  w.answer.solver = end ? "newton" : "explicit";
  if (!w.solve(model, x, s, options_, h, report))
    return fail(StepStatus::NotSolved, report.message + joints_at_odds(model, x, request.t_end, h));
  w.answer.nu = w.nu;
  w.answer.reactions = w.lambda;
  w.answer.speed_scale = w.speed;

  w.moved = x;
  w.moved.t = request.t_end;
  w.moved.nu = w.nu;
  move(model, w.nu, h, w.moved.q);
  if (!w.moved.q.allFinite() || !w.nu.allFinite())
    return fail(StepStatus::NotFinite, "the step's velocities are not finite");
  evaluate(model, w.moved, w.end, nullptr, w.start.near());
  if (!w.end.fault.empty()) return fail(StepStatus::NotFinite, w.end.fault);
  if (w.start.widen(model, w.end)) return advance(model, x, request, report);
  w.step.q_moved = w.moved.q;
  if (!s.joint_rows.empty()) report.projection = w.projection.move_onto(model, w.moved, w.end);
  w.judge(model, x, s, request, end, report);
  constexpr double rounding = 1e4;  // of the mark
  if (!(std::max(report.residuals.normal, report.residuals.friction) <= rounding * pass * w.speed))
    return fail(StepStatus::Inexact, "the penalty forces miss their laws");
  if (const std::string spring = unstable_spring(model, s, w.nu, h, Damping::Explicit, w.speed);
      !spring.empty())
    return fail(StepStatus::NotSolved, spring);
  if (!keeps_energy(model, x, request, w.gain(model, x, s, report), report)) return;
  report.status = StepStatus::Solved;
  x = w.moved;
  w.start.go_on_from(model, x, report.energy, w.end);
}

}  // namespace perp
