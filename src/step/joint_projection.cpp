#include "step/joint_projection.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace perp {

double joint_rounding(const Model& model, const Instant& s) {
  double length = 0;
  for (const JointGeometry& j : model.joints())
    length = std::max(
        {length, j.anchor_a.norm(), j.anchor_b.norm(), s.X[static_cast<std::size_t>(j.b.index)].p.norm()});
  return 32 * std::numeric_limits<double>::epsilon() * std::max(length, 1.0);
}

double JointProjection::move_onto(const Model& model, State& x, Instant& s) {
  constexpr int most_steps = 20;
  const double accepted = joint_rounding(model, s), error_start = s.joint_error();
  if (!(error_start > accepted)) return 0;
  q_start_ = q_best_ = x.q;
  islands_.find(model, s, {});
  const auto islands = islands_.get();
  if (reduced_.size() < islands.size()) reduced_.resize(islands.size());
  still_.setZero(model.nv());
  const auto rows = static_cast<Eigen::Index>(s.joint_rows.size());
  reactions_.resize(rows);
  bias_.resize(rows);

  double error = error_start;
  for (int step = 0; step < most_steps && error > accepted; ++step) {
    for (Eigen::Index i = 0; i < rows; ++i) {
      JointRowInstant& row = s.joint_rows[static_cast<std::size_t>(i)];
      bias_[i] = row.psi_b;
    }
    impulse_.setZero(model.nv());
    for (std::size_t i = 0; i < islands.size(); ++i) {
      rows_ = islands[i];
      rows_.joint_frictions.clear();
      reduced_[i].assemble(model, s, rows_, still_, bias_);
      reduced_[i].add_impulses(s, rows_, nothing_, impulse_, reactions_);
    }
    solve_mass(model, s, impulse_, d_);
    move(model, d_, 1, x.q);
    evaluate(model, x, s);
    const double now = s.joint_error();
    if (!s.fault.empty() || !(now < error)) break;
    error = now;
    q_best_ = x.q;
  }
  if (x.q != q_best_) {
    x.q = q_best_;
    evaluate(model, x, s);
  }
  return (q_best_ - q_start_).lpNorm<Eigen::Infinity>();
}

}  // namespace perp
