#include "step/extrapolated/extrapolated_flow.hpp"

#include <algorithm>
#include <cmath>

#include "core/index.hpp"
#include "perp/core/errors.hpp"

namespace perp {
namespace {

/// Substeps of column j = 1, 2, ...
int substeps_of(int column) { return 2 * column; }

/// What a step costs beside its substeps, in these: it is projected, sampled for events, and written down.
constexpr int around = 12;

/// Evaluations of a step of k columns.
double cost(int k) {
  int sum = around;
  for (int j = 1; j <= k; ++j) sum += substeps_of(j);
  return sum;
}

/// d with b = a ⊕ d.
void difference(const Model& model, const Vector& a, const Vector& b, Eigen::Ref<Vector> d) {
  for (const Body& body : model.bodies()) {
    if (body.nv == 0) continue;
    const int n = body.kind == BodyKind::Generalized ? body.nq : 3;
    d.segment(body.v0, n) = b.segment(body.q0, n) - a.segment(body.q0, n);
    if (body.kind != BodyKind::Spatial) continue;
    const auto orientation = [&](const Vector& q) {
      return Quaternion(q[body.q0 + 3], q[body.q0 + 4], q[body.q0 + 5], q[body.q0 + 6]);
    };
    d.segment<3>(body.v0 + 3) = rotation_vector(orientation(a).conjugate() * orientation(b));
  }
}

}  // namespace

ExtrapolatedFlow::ExtrapolatedFlow(ModeDynamics& dynamics, const Options& options)
    : d_(dynamics),
      options_(options),
      row_(at(most_columns)),
      best_h_(at(most_columns + 1)),
      work_(at(most_columns + 1)) {}

bool ExtrapolatedFlow::start(const State&, double h) {
  d_.stabilise = 0;
  h_ = h;
  if (target_ == 0) {
    const double digits = -std::log10(options_.rtol);
    target_ = std::clamp(static_cast<int>(0.5 * digits + 1.5), 2, most_columns - 1);
  }
  rejected_ = false;
  return true;
}

/// What all columns share: the forces at x, and what errors are measured by.
bool ExtrapolatedFlow::begin_step(const State& x) {
  columns_ = 0;
  if (!d_.rows(x)) return false;
  ++d_.evaluations;
  d_.kick(first_);
  first_rates_.begin(d_);
  const Model& model = d_.model();
  weight_.resize(2 * model.nv());
  for (const Body& b : model.bodies()) {
    if (b.nv == 0) continue;
    const int n = b.kind == BodyKind::Generalized ? b.nq : 3;
    weight_.segment(b.v0, n) = x.q.segment(b.q0, n).cwiseAbs();
    if (b.kind == BodyKind::Spatial) weight_.segment<3>(b.v0 + 3).setOnes();  // an angle [rad]
  }
  weight_.tail(model.nv()) = x.nu.cwiseAbs();
  weight_ = (options_.rtol * weight_.array() + options_.atol).inverse();
  return true;
}

/// Leaves now_ at x.t + H. Impulses are summed at odd k, whose sum is what leads from nu_0 to nu_n.
bool ExtrapolatedFlow::substeps(const State& x, double H, int n) {
  const Model& model = d_.model();
  const double h = H / n;
  now_ = before_ = x;
  sum_.setZero(RowRates::size(d_));
  rates_ = first_rates_;
  for (int k = 0; k < n; ++k) {
    const double dt = k == 0 ? h : 2 * h;
    const ModeKick& kick = k == 0 ? first_ : kick_;
    next_ = before_;
    next_.t = x.t + (k + 1) * h;
    move(model, now_.nu, dt, next_.q);
    next_.nu += dt * kick.free;
    ++d_.evaluations;
    if (!next_.q.allFinite() || !d_.rows(next_) || !d_.meet(kick, next_, z_)) return false;
    if (k % 2 == 1) rates_.add(d_, now_, z_, dt, sum_);
    if (k + 1 < n) {
      if (z_.size() > 0) d_.turn(next_);  // else nothing has changed since rows()
      d_.kick(kick_);
      if (k % 2 == 0) rates_.assemble(d_, next_);
    }
    std::swap(before_, now_);
    std::swap(now_, next_);
  }
  return true;
}

/// The next row of Neville's table.
bool ExtrapolatedFlow::add_column(const State& x, double H) {
  const int j = ++columns_, nv = d_.model().nv();
  if (!substeps(x, H, substeps_of(j))) return false;
  if (j == 1) base_ = now_.q;
  Vector T(2 * nv + sum_.size());
  difference(d_.model(), base_, now_.q, T.head(nv));
  T.segment(nv, nv) = now_.nu;
  T.tail(sum_.size()) = sum_;
  for (int k = 1; k < j; ++k) {  // row_[k - 1] is T_j-1,k; T is T_j,k
    const double ratio = double(substeps_of(j)) / substeps_of(j - k);
    last_ = T;
    T += (T - row_[at(k - 1)]) / (ratio * ratio - 1);
    row_[at(k - 1)] = last_;
  }
  row_[at(j - 1)] = T;
  return T.allFinite();
}

/// |T_kk - T_k,k-1| in tolerances.
double ExtrapolatedFlow::error() const {
  if (weight_.size() == 0) return 0;
  const auto n = weight_.size();
  return (row_[at(columns_ - 1)] - last_).head(n).cwiseProduct(weight_).lpNorm<Eigen::Infinity>();
}

bool ExtrapolatedFlow::finish(const State& x, double H, State& end) {
  const Vector& T = row_[at(columns_ - 1)];
  const int nv = d_.model().nv();
  end = x;
  end.t = x.t + H;
  end.q = base_;
  move(d_.model(), T.head(nv), 1, end.q);
  end.nu = T.segment(nv, nv);
  if (!std::isfinite(d_.project(end))) return false;
  row_sums_ = RowRates::unpack(d_, T.tail(sum_.size()), x, end);
  if (columns_ == 1 || nv == 0) return true;
  const Vector change = T - last_;
  Vector momentum;
  multiply_mass(d_.model(), d_.instant(), change.segment(nv, nv), momentum);
  row_sums_.momentum_residual = momentum.lpNorm<Eigen::Infinity>();
  row_sums_.kinematic_residual = change.head(nv).lpNorm<Eigen::Infinity>();
  return true;
}

bool ExtrapolatedFlow::fixed(double H, State& x) {
  for (int k = 0; k < options_.order / 2; ++k)
    if (!add_column(x, H)) return false;
  State end;
  if (!finish(x, H, end)) return false;
  x = end;
  return true;
}

bool ExtrapolatedFlow::step(double t_stop, State& x) {
  const double H_all = t_stop - x.t;
  const State from = x;
  if (!begin_step(from)) {
    message = "the equations cannot be evaluated at t = " + shortest(x.t);
    return false;
  }
  if (options_.order > 0) {
    const bool done = fixed(H_all, x);
    if (done) x.t = t_stop;
    if (!done) message = "the equations cannot be evaluated after t = " + shortest(from.t);
    return done;
  }
  double H = h_ > 0 ? h_ : first_guess(from);
  constexpr int most_attempts = 60;
  for (int attempt = 0; attempt < most_attempts; ++attempt) {
    constexpr double nearly = 1.01;  // what is left of the way is taken along
    const bool to_stop = nearly * H >= H_all;
    if (to_stop)
      H = H_all;
    else if (2 * H > H_all)
      H = 0.5 * H_all;  // two equal steps, not a long one and what it leaves
    if (!(from.t + H > from.t)) break;
    State end;
    if (try_step(from, H, end)) {
      x = end;
      if (to_stop) x.t = t_stop;
      return true;
    }
  }
  message = "steps have become too short at t = " + shortest(from.t);
  return false;
}

/// A time in which velocities, or where they are zero positions, change by a part of themselves.
double ExtrapolatedFlow::first_guess(const State& x) const {
  const double size =
      weight_.size() > 0 ? weight_.cwiseInverse().lpNorm<Eigen::Infinity>() / options_.rtol : 0;
  const double rate = std::max(first_.free.size() > 0 ? first_.free.lpNorm<Eigen::Infinity>() : 0.0,
                               x.nu.size() > 0 ? x.nu.lpNorm<Eigen::Infinity>() : 0.0);
  return rate > 0 ? 0.1 * size / rate : infinity;
}

/// Whether the error after k columns says that target_ + 1 of them may be enough [HNW93, II.9].
bool ExtrapolatedFlow::fits(int k, double error) const {
  const auto n = [](int column) { return static_cast<double>(substeps_of(column)); };
  double allowed = 1;
  for (int j = k; j <= target_; ++j) allowed *= n(j + 1) / n(1);
  return error <= allowed * allowed;
}

/// Columns until the error is one tolerance; false with a shorter H where that is not to be expected.
bool ExtrapolatedFlow::try_step(const State& x, double& H, State& end) {
  columns_ = 0;
  const int most = std::min(target_ + 1, most_columns);
  for (int k = 1; k <= most; ++k) {
    if (!add_column(x, H)) return retreat(H, false), false;
    if (k == 1) continue;
    const double e = error();
    constexpr double safety = 0.94, aim = 0.65, least = 0.05, most_growth = 6;
    const double factor = safety * std::pow(aim / std::max(e, 1e-30), 1.0 / (2 * k - 1));
    best_h_[at(k)] = H * std::clamp(factor, least, most_growth);
    work_[at(k)] = cost(k) / best_h_[at(k)];
    if (k < target_ - 1) continue;
    if (e <= 1) {
      if (!finish(x, H, end)) return retreat(H, false), false;
      choose_next(H);
      return true;
    }
    if (!fits(k, e)) break;
  }
  retreat(H, true);
  return false;
}

/// H and the number of columns after a step of columns_ of them.
void ExtrapolatedFlow::choose_next(double H) {
  const int k = columns_, most = most_columns - 1;
  int next = k;
  const auto work = [&](int j) { return j >= 2 && j <= k ? work_[at(j)] : infinity; };
  if (work(k - 1) < 0.8 * work(k))
    next = k - 1;
  else if (work(k) < 0.9 * work(k - 1) || k == 2)
    next = k + 1;
  next = std::clamp(rejected_ ? std::min(next, k) : next, 2, most);
  h_ = next <= k ? best_h_[at(next)] : best_h_[at(k)] * cost(next) / cost(k);
  if (rejected_) h_ = std::min(h_, H);
  target_ = next;
  rejected_ = false;
}

void ExtrapolatedFlow::retreat(double& H, bool finite) {
  rejected_ = true;
  if (!finite || columns_ < 2) {
    H *= 0.25;
    return;
  }
  int k = std::min(columns_, target_);
  if (k > 2 && work_[at(k - 1)] < 0.8 * work_[at(k)]) --k;
  target_ = std::max(k, 2);
  H = std::min(best_h_[at(k)], 0.9 * H);
}

}  // namespace perp
