#include "step/sensitivity/held_laws.hpp"

#include <algorithm>
#include <cmath>

#include "core/index.hpp"

namespace perp {
namespace {

/// Of the step's speeds: what is less is not told from zero in an answer that is solved to 1e-10 [-].
constexpr double on_border = 1e-9;

bool has_bound(const Reaction& r) {
  return r.law == Law::Planar || r.law == Law::Cone || r.law == Law::Interval;
}

}  // namespace

Vector3 sliding_direction(const Reaction& r) {
  Vector3 d = Vector3::Zero();
  if (r.law == Law::Interval)
    d.y() = r.u.y() > 0 ? 1 : -1;
  else if (r.law == Law::Planar)
    d.y() = r.u.y() > 0 ? 1 : -1;
  else if (r.law == Law::Cone)
    d.tail<2>() = r.u.tail<2>().normalized();
  return d;
}

HeldMode mode_of(const Reaction& r, double speed, std::string& border) {
  const double small = on_border * speed;
  HeldMode mode{.held = Held::Rests};
  border.clear();
  if (r.law != Law::Equality && r.law != Law::Interval) {
    const double load = r.w * r.p.x();
    if (!(load > 0 && load > r.u.x())) mode.held = Held::Open;
    if (load <= small && std::abs(r.u.x()) <= small)
      border = "touches without a load, so that it may be closed or open";
    if (mode.held == Held::Open) return mode;
  }
  if (!has_bound(r)) return mode;
  const bool line = r.law == Law::Interval;
  const double bound = line ? r.mu : r.mu * r.p.x();
  const Vector2 p_f = line ? Vector2(r.p.y(), 0) : Vector2(r.p.tail<2>());
  const Vector2 u_f = line ? Vector2(r.u.y(), 0) : Vector2(r.u.tail<2>());
  if (!(bound > 0)) {  // no friction, and a direction only where it slides
    mode.held = u_f.norm() > small ? Held::Slides : Held::Tied;
  } else {
    if ((p_f - u_f / r.w).norm() > bound) mode.held = Held::Slides;
    if (u_f.norm() <= small && p_f.norm() >= (1 - on_border) * bound)
      border = "is at the bound of its friction without sliding, so that it may stick or slip";
  }
  if (mode.held == Held::Slides) mode.d = sliding_direction(r);
  return mode;
}

int unknowns_of(std::span<const Reaction> all, std::span<const HeldMode> modes) {
  int n = 0;
  for (std::size_t i = 0; i < all.size(); ++i)
    if (modes[i].held != Held::Open) n += rows_of(all[i].law).second;
  return n;
}

void held_equations(std::span<const Reaction> all, std::span<const HeldMode> modes, const Vector& R,
                    Vector& out) {
  const Eigen::Index nv = R.size();
  out.resize(nv + unknowns_of(all, modes));
  out.head(nv) = R;
  Vector impulse = Vector::Zero(nv);
  Eigen::Index row = nv;
  for (std::size_t i = 0; i < all.size(); ++i) {
    if (modes[i].held == Held::Open) continue;
    const Reaction& r = all[i];
    r.W.add_impulse(r.p, impulse);
    Vector3 miss = r.u;
    if (modes[i].held != Held::Rests) {
      const Vector3 d = modes[i].held == Held::Slides ? sliding_direction(r) : modes[i].d;
      if (r.law == Law::Interval)
        miss.y() = r.p.y() + r.mu * d.y();
      else
        miss.tail<2>() = r.p.tail<2>() + r.mu * r.p.x() * d.tail<2>();
    }
    const auto [first, count] = rows_of(r.law);
    out.segment(row, count) = miss.segment(first, count);
    row += count;
  }
  out.head(nv) -= impulse;
}

void add_impulses(std::span<const HeldMode> modes, const Vector& z, double t, std::span<Reaction> all) {
  Eigen::Index row = z.size() - unknowns_of(all, modes);
  for (std::size_t i = 0; i < all.size(); ++i) {
    if (modes[i].held == Held::Open) continue;
    const auto [first, count] = rows_of(all[i].law);
    all[i].p.segment(first, count) += t * z.segment(row, count);
    row += count;
  }
}

namespace {

/// Slopes of one reaction's laws: by nu of its bodies, and by its own p.
void law_slopes(const Reaction& r, const HeldMode& mode, Reaction::Slope& by_nu, Matrix3& by_p) {
  by_nu = r.G;
  by_p.setZero();
  if (mode.held == Held::Rests) return;
  by_nu.bottomRows<2>().setZero();
  by_p(1, 1) = by_p(2, 2) = 1;
  if (r.law == Law::Interval) return;
  by_p.block<2, 1>(1, 0) = r.mu * mode.d.tail<2>();
  const double slip = r.u.tail<2>().norm();
  if (mode.held != Held::Slides || r.law != Law::Cone || !(slip > 0)) return;
  const Vector2 d = mode.d.tail<2>();
  by_nu.bottomRows<2>() =
      r.mu * r.p.x() / slip * (Eigen::Matrix2d::Identity() - d * d.transpose()) * r.G.bottomRows<2>();
}

}  // namespace

std::string HeldSystem::factor(const Model& model, const std::vector<Coupling>& K,
                               std::span<const Reaction> all, std::span<const HeldMode> modes) {
  const Eigen::Index nv = model.nv(), n = nv + unknowns_of(all, modes);
  A_.setZero(n, n);
  columns_.setOnes(n);
  for (const Coupling& c : K) {
    const Body &row = model.bodies()[at(c.row)], &column = model.bodies()[at(c.column)];
    A_.block(row.v0, column.v0, row.nv, column.nv) += c.value.topLeftCorner(row.nv, column.nv);
  }
  Eigen::Index place = nv;
  for (std::size_t i = 0; i < all.size(); ++i) {
    if (modes[i].held == Held::Open) continue;
    const Reaction& r = all[i];
    const auto [first, count] = rows_of(r.law);
    const WrenchMap<3>& W = r.W;
    Reaction::Slope by_nu;
    Matrix3 by_p;
    law_slopes(r, modes[i], by_nu, by_p);
    A_.block(W.va, place, W.na, count) -= W.A.block(0, first, W.na, count);
    A_.block(W.vb, place, W.nb, count) -= W.B.block(0, first, W.nb, count);
    A_.block(place, W.va, count, W.na) += by_nu.block(first, 0, count, W.na);
    A_.block(place, W.vb, count, W.nb) += by_nu.block(first, 6, count, W.nb);
    A_.block(place, place, count, count) += by_p.block(first, first, count, count);
    columns_.segment(place, count).setConstant(1 / r.w);
    place += count;
  }
  A_ = A_ * columns_.asDiagonal();
  rows_ = A_.rowwise().lpNorm<Eigen::Infinity>().cwiseMax(1e-300).cwiseInverse();
  A_ = rows_.asDiagonal() * A_;
  constexpr double dependent = 1e-10;  // rows of length 1
  lu_.compute(A_);
  // pivots tell most; the condition's estimate costs as much again, and is no use where a pivot is zero
  constexpr double suspect = 1e-4;
  const double pivot = n > 0 ? lu_.matrixLU().diagonal().cwiseAbs().minCoeff() : 1;
  redundant_ = !(pivot > dependent) || (pivot < suspect && !(lu_.rcond() > dependent));
  if (!redundant_) return "";
  cod_.setThreshold(dependent);
  cod_.compute(A_);
  const Eigen::Index left = n - cod_.rank();
  if (left == 0) return "";
  const Matrix open = cod_.colsPermutation() * Matrix(cod_.matrixZ().transpose().rightCols(left));
  if (open.topRows(nv).norm() > 1e-6)
    return "has modes in which how redundant reactions share decides on the motion";
  return "";
}

Vector HeldSystem::solve(const Vector& rhs) const {
  const Vector scaled = rows_.cwiseProduct(rhs);
  return columns_.cwiseProduct(redundant_ ? Vector(cod_.solve(scaled)) : Vector(lu_.solve(scaled)));
}

double HeldSystem::miss(const Vector& z, const Vector& rhs) const {
  if (!redundant_) return 0;
  const Vector scaled = rows_.cwiseProduct(rhs), y = columns_.cwiseInverse().cwiseProduct(z);
  const double size = scaled.norm() + y.norm();  // rows of A are of length 1
  return size > 0 ? (A_ * y - scaled).norm() / size : 0;
}

}  // namespace perp
