#include "step/parts/joint_projection.hpp"

#include <algorithm>
#include <cmath>

#include "perp/core/errors.hpp"
#include "step/certificate/closeness.hpp"
#include "step/implicit/nonsmooth_newton.hpp"

namespace perp {
namespace {

double mobility(const Model& model, const Instant& s, const JointRowInstant& row) {
  return inverse_mass(model, s, three_columns(row.W, 0), Law::Equality);
}

}  // namespace

/// d_ = M^-1 W_b lambda with W_bᵀ d_ = -psi_b, in the least-squares sense where there is none.
void JointProjection::shortest_move(const Model& model, const Instant& s) {
  islands_.find(model, s, {});
  const auto islands = islands_.get();
  if (reduced_.size() < islands.size()) reduced_.resize(islands.size());
  still_.setZero(model.nv());
  const auto rows = static_cast<Eigen::Index>(s.joint_rows.size());
  reactions_.resize(rows);
  bias_.resize(rows);
  for (Eigen::Index i = 0; i < rows; ++i) bias_[i] = s.joint_rows[static_cast<std::size_t>(i)].psi_b;
  impulse_.setZero(model.nv());
  for (std::size_t i = 0; i < islands.size(); ++i) {
    rows_ = islands[i];
    rows_.joint_frictions.clear();
    reduced_[i].assemble(model, s, rows_, still_, bias_);
    reduced_[i].add_impulses(s, rows_, nothing_, impulse_, reactions_);
  }
  solve_mass(model, s, impulse_, d_);
}

double JointProjection::move_onto(const Model& model, State& x, Instant& s) {
  constexpr int most_steps = 20;
  const double misfit_start = closeness::joint_misfit(model, s);
  if (!(misfit_start > 1)) return 0;
  q_start_ = q_best_ = x.q;
  double misfit = misfit_start;
  for (int step = 0; step < most_steps && misfit > 1; ++step) {
    shortest_move(model, s);
    move(model, d_, 1, x.q);
    evaluate(model, x, s);
    const double now = closeness::joint_misfit(model, s);
    if (!s.fault.empty() || !(now < misfit)) break;
    misfit = now;
    q_best_ = x.q;
  }
  if (x.q != q_best_) {
    x.q = q_best_;
    evaluate(model, x, s);
  }
  return (q_best_ - q_start_).lpNorm<Eigen::Infinity>();
}

bool JointProjection::contradictory(const Model& model, State& x, Instant& s) {
  constexpr int most_steps = 50, most_halvings = 10;
  constexpr double no_less = 0.9;  // of what is left, by the best small motion: none
  constexpr double above_rounding =
      1e3;  // of Gauss and Newton's end, which is not at rounding where rows nearly repeat
  const auto left = [&](const Vector* d) {
    double sum = 0;
    for (const JointRowInstant& row : s.joint_rows) {
      const double psi = row.psi_b + (d == nullptr ? 0 : row.W.velocity(*d)[0]);
      sum += psi * psi / mobility(model, s, row);
    }
    return std::sqrt(sum);
  };
  for (int step = 0; step < most_steps; ++step) {
    if (!s.fault.empty() || !(closeness::joint_misfit(model, s) > above_rounding)) return false;
    shortest_move(model, s);
    const double now = left(nullptr);
    if (!d_.allFinite() || !(left(&d_) < no_less * now)) return d_.allFinite();
    const Vector q = x.q;
    double part = 1;
    for (int halvings = 0;; ++halvings, part /= 2) {
      x.q = q;
      move(model, d_, part, x.q);
      evaluate(model, x, s);
      if (left(nullptr) < now) break;
      if (halvings == most_halvings) {
        x.q = q;
        evaluate(model, x, s);
        return false;
      }
    }
  }
  return false;
}

std::string joints_open(const Model& model, const Instant& s,
                        const std::function<double(const JointRowInstant&)>& open,
                        const std::function<double(const JointRowInstant&)>& tolerance) {
  struct Open {
    double share, by;  // of the tolerance
    const JointRowInstant* row;
  };
  std::vector<Open> worst;  // of each joint
  for (const JointRowInstant& row : s.joint_rows) {
    const double by = open(row), share = by / tolerance(row);
    if (!(share > 1)) continue;
    if (worst.empty() || worst.back().row->joint != row.joint)
      worst.push_back({share, by, &row});
    else if (share > worst.back().share)
      worst.back() = {share, by, &row};
  }
  std::stable_sort(worst.begin(), worst.end(),
                   [](const Open& a, const Open& b) { return a.share > b.share; });
  std::string names;
  for (const Open& o : worst)
    names += (names.empty() ? "'" : ", '") + model.joint({o.row->joint}).name + "' by " + shortest(o.by) +
             (o.row->world.linear.isZero(0) ? " rad" : " m");
  return names;
}

std::string contradicting_joints(const Model& model, State& x) {
  if (model.joints().empty()) return "";
  Instant s;
  evaluate(model, x, s);
  JointProjection projection;
  if (!projection.contradictory(model, x, s)) return "";
  constexpr double part = 1e-3;  // of the largest: less is not what the others quarrel about
  double most = 0;
  const auto share = [&](const JointRowInstant& row) {
    return std::abs(row.psi_b) / std::sqrt(mobility(model, s, row));
  };
  for (const JointRowInstant& row : s.joint_rows) most = std::max(most, share(row));
  return joints_open(
      model, s, [](const JointRowInstant& row) { return std::abs(row.psi_b); },
      [&](const JointRowInstant& row) {
        return std::max(part * most * std::sqrt(mobility(model, s, row)),
                        closeness::joint_rounding(model, s, row));
      });
}

std::string joints_at_odds(const Model& model, const State& x, double t_end, double h) {
  if (model.joints().empty()) return "";
  State then = x;
  then.t = t_end;
  if (const std::string names = contradicting_joints(model, then); !names.empty())
    return "; joints that contradict each other stay open: " + names;
  constexpr double noticed = 1e-3;  // of the velocity that bodies give the row
  Instant s;
  evaluate(model, x, s);
  const std::string names = joints_open(
      model, s, [&](const JointRowInstant& row) { return h * std::abs(row.velocity(x.nu)); },
      [&](const JointRowInstant& row) {
        const auto size = [&](int v, int n, const WrenchMap<1>::Block& W) {
          return W.head(n).cwiseAbs().dot(x.nu.segment(v, n).cwiseAbs());
        };
        return noticed * h * (size(row.W.va, row.W.na, row.W.A) + size(row.W.vb, row.W.nb, row.W.B)) +
               closeness::joint_rounding(model, s, row);
      });
  return names.empty() ? "" : "; joints that the velocities at its start would open: " + names;
}

}  // namespace perp
