#include "step/modes/acceleration_problem.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "core/index.hpp"
#include "perp/instant/friction_polygon.hpp"
#include "perp/solve/lcp.hpp"
#include "solve/friction/even_friction.hpp"
#include "solve/friction/vanishing_compliance.hpp"
#include "step/parts/contact_blocks.hpp"

namespace perp {
namespace {

constexpr double joint_rounding = 1e-8;  // of what adds up to an acceleration: less is zero [-]

/// The friction problem as an LCP in z = (c_n and polygon coordinates and sigma of each block): the instantaneous form of (39).
class PolygonalForm {
 public:
  PolygonalForm(const FrictionProblem& problem, int edges) {
    const std::vector<Eigen::Index> rows = problem.offsets();
    const std::vector<Vector2> polygon = friction_polygon(edges);
    struct Sigma {
      Eigen::Index normal, first, last;  // columns: of c_n (or -1), of the polygon's coordinates
      double bound;                      // mu, or c_max
    };
    std::vector<Sigma> sigmas;
    std::vector<Eigen::Triplet<double>> entries;
    Eigen::Index z = 0;
    for (Eigen::Index i = 0; i < problem.blocks(); ++i) {
      const Eigen::Index row = rows[at(i)];
      const BlockKind kind = problem.kind(i);
      Sigma sigma{-1, 0, 0, problem.mu[i]};
      if (kind != BlockKind::Interval) {
        sigma.normal = z;
        entries.emplace_back(row, z++, 1.0);
      }
      sigma.first = z;
      if (kind == BlockKind::Cone)
        for (const Vector2& d : polygon) {
          entries.emplace_back(row + 1, z, d.x());
          entries.emplace_back(row + 2, z++, d.y());
        }
      else if (kind != BlockKind::HalfLine)
        for (const double sign : {1.0, -1.0})
          entries.emplace_back(row + (kind == BlockKind::Planar ? 1 : 0), z++, sign);
      sigma.last = z;
      if (sigma.last > sigma.first) sigmas.push_back(sigma);
    }
    forces_ = z;
    const auto count = static_cast<Eigen::Index>(sigmas.size());
    D.setZero(problem.rows(), z);
    for (const auto& e : entries) D(e.row(), e.col()) = e.value();
    const Matrix W = problem.W.to_dense();
    lcp.A.setZero(z + count, z + count);
    lcp.b.setZero(z + count);
    lcp.A.topLeftCorner(z, z) = D.transpose() * W * D;
    lcp.b.head(z) = D.transpose() * problem.q;
    for (Eigen::Index s = 0; s < count; ++s) {
      const Sigma& sigma = sigmas[at(s)];
      lcp.A.block(sigma.first, z + s, sigma.last - sigma.first, 1).setOnes();
      lcp.A.block(z + s, sigma.first, 1, sigma.last - sigma.first).setConstant(-1);
      if (sigma.normal >= 0)
        lcp.A(z + s, sigma.normal) = sigma.bound;
      else
        lcp.b[z + s] = sigma.bound;
    }
  }

  Vector forces(const Vector& z) const { return D * z.head(forces_); }

  Lcp lcp;

 private:
  Matrix D;
  Eigen::Index forces_ = 0;
};

}  // namespace

void AccelerationProblem::assemble(const Model& model, const State& x, const Instant& instant,
                                   const Modes& modes) {
  modes_ = modes;
  island_ = {};
  contact_index.clear();
  for (const ClosedContact& c : modes.contacts) {
    contact_index.push_back(instant.contact_of_point[at(c.point)]);
    island_.contacts.push_back(contact_index.back());
  }
  island_.joint_rows.resize(instant.joint_rows.size());
  std::iota(island_.joint_rows.begin(), island_.joint_rows.end(), 0);
  island_.joint_frictions.resize(instant.joint_frictions.size());
  std::iota(island_.joint_frictions.begin(), island_.joint_frictions.end(), 0);

  biases_.evaluate(model, x, instant, contact_index);
  accelerations_ = instant;
  for (const int i : contact_index) accelerations_.contacts[at(i)].bias = biases_.contacts[at(i)];
  for (std::size_t i = 0; i < biases_.moments.size(); ++i)
    accelerations_.moments[i].bias = biases_.moments[i];
  Vector joint_bias(static_cast<Eigen::Index>(instant.joint_rows.size()));
  for (std::size_t i = 0; i < instant.joint_rows.size(); ++i)
    joint_bias[static_cast<Eigen::Index>(i)] = biases_.joint_rows[i];
  for (std::size_t i = 0; i < instant.joint_frictions.size(); ++i)
    accelerations_.joint_frictions[i].psi_b_t = biases_.joint_frictions[i];
  solve_mass(model, instant, instant.k, free_);
  reduced_.assemble(model, accelerations_, island_, free_, joint_bias);

  // rows that are kept, and what a force along each of them is along all rows
  acceleration_scale = 0;
  const auto scale = [&](double a) { acceleration_scale = std::max(acceleration_scale, std::abs(a)); };
  ContactBlocks blocks;
  columns_.setZero(reduced_.size(), reduced_.size());
  known_.setZero(reduced_.size());
  problem = {};
  for (std::size_t i = 0; i < contact_index.size(); ++i) {
    const ContactInstant& c = accelerations_.contacts[at(contact_index[i])];
    const MomentInstant* m = accelerations_.moments_of(c);
    const ClosedContact& mode = modes.contacts[i];
    const int row = reduced_.rows_of(static_cast<int>(i));
    const auto column = static_cast<Eigen::Index>(blocks.rows.size());
    const int stays = blocks.add(accelerations_, c, row, mode.slides, mode.rolls);
    for (Eigen::Index k = column; k < column + stays; ++k) columns_(blocks.rows[at(k)], k) = 1;
    if (c.tangents > 0 && m == nullptr && mode.slides) {
      columns_(row + 1, column) = -c.mu * c.frame.col(1).dot(mode.direction);
      if (c.tangents == 2) columns_(row + 2, column) = -c.mu * c.frame.col(2).dot(mode.direction);
    }
    if (m != nullptr && (mode.slides || mode.rolls)) {
      const Vector3 none = Vector3::Zero();
      const FrictionShare share = friction_share(c, *m, mode.slides ? mode.direction : none,
                                                 mode.rolls ? mode.rolling : none, mode.lever);
      for (int t = 1; t <= c.tangents; ++t) columns_(row + t, column) = share.force[t - 1];
      const std::array<int, 3> of = m->columns(c.tangents);
      for (int k = 0; k < m->rows(c.tangents); ++k)
        columns_(moment_row(c, row) + k, column) = share.moment[of[at(k)]];
    }
    for (const double a : c.W.velocity(free_)) scale(a);
    for (const double a : c.bias) scale(a);
    if (m == nullptr) continue;
    for (const double a : m->W.velocity(free_)) scale(mode.lever * a);
    for (const double a : m->bias) scale(mode.lever * a);
  }
  for (std::size_t i = 0; i < island_.joint_frictions.size(); ++i) {
    const JointRowInstant& joint = accelerations_.joint_frictions[i];
    const int row = reduced_.friction_row(static_cast<int>(i));
    scale(joint.W.velocity(free_)[0]);
    scale(joint.psi_b_t);
    if (modes.joints[i] != 0) {
      known_[row] = -modes.joints[i] * joint.friction;
      scale(reduced_.W(row, row) * joint.friction);
      continue;
    }
    columns_(row, static_cast<Eigen::Index>(blocks.rows.size())) = 1;
    blocks.add_interval(row, joint.friction);
  }
  for (std::size_t i = 0; i < island_.joint_rows.size(); ++i) {
    scale(accelerations_.joint_rows[i].W.velocity(free_)[0]);
    scale(biases_.joint_rows[i]);
  }
  const std::vector<int>& kept = blocks.rows;
  const auto n = static_cast<Eigen::Index>(kept.size());
  columns_.conservativeResize(Eigen::NoChange, n);
  blocks.give(problem);
  const Matrix full = reduced_.W * columns_;
  const Vector q = reduced_.q + reduced_.W * known_;
  problem.W = Matrix(full(kept, Eigen::all));
  problem.q = q(kept);
  give_.setZero(reduced_.size());
  if (n == 0 || (!even && compliance == 0)) return;
  Matrix C;
  Vector k;
  reduced_.compliance(model, accelerations_, island_, C, k);
  C_ = (C * columns_)(kept, Eigen::all);
  k_ = (k + C * known_)(kept);
  if (compliance == 0) return;
  const double of_one =
      compliance * std::exp((reduced_.diagonal.array() / C.diagonal().array()).log().mean());
  give_ = of_one * C.diagonal();
  problem.W = Matrix(problem.W.dense() + of_one * C_);
  problem.q += of_one * k_;
}

AccelerationAnswer AccelerationProblem::read(const Model& model, const Vector& c) const {
  AccelerationAnswer answer;
  const Vector r = columns_ * c + known_;
  const Vector u = reduced_.W * r + reduced_.q;
  Vector force = Vector::Zero(model.nv());
  answer.reactions.setZero(static_cast<Eigen::Index>(accelerations_.joint_rows.size()));
  reduced_.add_impulses(accelerations_, island_, r, force, answer.reactions);
  solve_mass(model, accelerations_, force, answer.nu_dot);
  answer.nu_dot += free_;
  for (std::size_t i = 0; i < contact_index.size(); ++i) {
    const ContactInstant& contact = accelerations_.contacts[at(contact_index[i])];
    const int row = reduced_.rows_of(static_cast<int>(i)), rows = 1 + contact.tangents;
    Vector3 f = Vector3::Zero();
    f.head(rows) = r.segment(row, rows);
    answer.force.push_back(f);
    Vector3 a = contact.velocity(answer.nu_dot);
    a.tail(2 - contact.tangents).setZero();
    answer.acceleration.push_back(a);
    answer.moment.emplace_back(Vector3::Zero());
    answer.angular_acceleration.emplace_back(Vector3::Zero());
    if (const MomentInstant* m = accelerations_.moments_of(contact)) {
      const std::array<int, 3> of = m->columns(contact.tangents);
      for (int k = 0; k < m->rows(contact.tangents); ++k)
        answer.moment.back()[of[at(k)]] = r[moment_row(contact, row) + k];
      answer.angular_acceleration.back() = m->velocity(answer.nu_dot);
    }
    answer.small.push_back(1e-13 * reduced_.W.row(row).cwiseAbs().dot(r.cwiseAbs().transpose()));
  }
  const auto frictions = static_cast<Eigen::Index>(island_.joint_frictions.size());
  answer.joint_force = r.tail(frictions);
  answer.joint_acceleration = u.tail(frictions);
  answer.joint_small.resize(frictions);
  for (Eigen::Index i = 0; i < frictions; ++i) {  // what adds up to it, in its own unit
    const Eigen::Index row = reduced_.size() - frictions + i;
    answer.joint_small[i] = joint_rounding * (std::abs(reduced_.q[row]) +
                                              reduced_.W.row(row).cwiseAbs().dot(r.cwiseAbs().transpose())) +
                            10 * give_[row] * std::abs(r[row]);
  }
  return answer;
}

double AccelerationProblem::choices() const {
  double all = 1;
  for (Eigen::Index i = 0; i < problem.blocks(); ++i)
    all *= problem.kind(i) == BlockKind::HalfLine ? 2 : problem.kind(i) == BlockKind::Planar ? 4 : 3;
  const bool few = std::all_of(problem.kinds.begin(), problem.kinds.end(), [](BlockKind k) {
    return k == BlockKind::HalfLine || k == BlockKind::Planar || k == BlockKind::Interval;
  });
  return few ? all : infinity;
}

/// All forces c that some choice of modes allows, those with the same velocities once. Blocks: a half line is open or closed; planar
/// friction is open, sticks, slips either way; an interval holds or yields either way. `one_limit` is false if the rule for redundant
/// forces picks none of those of some modes, or more than one.

FrictionSolution AccelerationProblem::solve_friction() const {
  const FrictionOptions how{.use_ipopt = false};
  return even ? solve_evenly(problem, C_, k_, how) : perp::solve_friction(problem, how);
}

AccelerationAnswer AccelerationProblem::any_solution(const Model& model) const {
  AccelerationAnswer answer;
  if (problem.rows() == 0) {
    answer = read(model, Vector());
    answer.residual = 0;
  } else {
    const FrictionSolution s = solve_friction();
    if (!s.solved()) return answer;
    answer = read(model, s.r);
    answer.residual = s.residual;
  }
  answer.status = Cp1Status::Unique;
  return answer;
}

AccelerationAnswer AccelerationProblem::solve(const Model& model, const Cp1Options& options) const {
  if (problem.rows() == 0) {
    AccelerationAnswer answer = read(model, Vector());
    answer.status = Cp1Status::Unique;
    answer.complete = true;
    answer.residual = 0;
    return answer;
  }
  bool complete = choices() <= most_choices, one_limit = true;
  std::vector<Vector> all;
  if (complete) all = enumerate(one_limit);
  Vector c;
  double residual = not_set;
  bool solved = false;
  if (options.edges != 0) {
    const PolygonalForm form(problem, options.edges);
    const LcpSolution z = solve_lcp(form.lcp);
    solved = z.solved();
    if (solved) c = form.forces(z.z), residual = lcp_relative_residual(form.lcp.A, form.lcp.b, z.z);
  } else {
    const FrictionSolution s = solve_friction();
    solved = s.solved();
    if (solved) c = s.r, residual = s.residual;
  }
  if (!solved && !complete && choices() <= all_choices) {
    complete = true;
    all = enumerate(one_limit);
  }
  AccelerationAnswer answer;
  answer.complete = complete;
  if (complete && all.empty()) return answer;
  if (complete && (all.size() > 1 || !solved)) {
    c = *std::min_element(all.begin(), all.end(),
                          [](const Vector& a, const Vector& b) { return a.squaredNorm() < b.squaredNorm(); });
    residual = 0;
    solved = true;
  }
  if (!solved) return answer;
  answer = read(model, c);
  answer.complete = complete;
  answer.residual = residual;
  answer.status = all.size() > 1 || !one_limit ? Cp1Status::Several : Cp1Status::Unique;
  return answer;
}

}  // namespace perp
