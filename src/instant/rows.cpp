#include "instant/rows.hpp"

namespace perp {
namespace {

std::size_t at(int i) { return static_cast<std::size_t>(i); }

}  // namespace

void Rows::start() {
  used_ = 0;
  size_ = 0;
  changed_ = false;
}

/// The group that the next row belongs to: the last one, if it is of the same pair and has room.
RowGroup& Rows::next(int a, int va, int na, int b, int vb, int nb) {
  if (used_ > 0) {
    RowGroup& last = groups_[used_ - 1];
    if (last.body[0] == a && last.body[1] == b && last.count < 6) return last;
  }
  if (used_ == groups_.size()) {
    groups_.emplace_back();
    changed_ = true;
  }
  RowGroup& g = groups_[used_++];
  changed_ = changed_ || g.body[0] != a || g.body[1] != b || g.first != size_;
  g.body[0] = a, g.v[0] = va, g.n[0] = na;
  g.body[1] = b, g.v[1] = vb, g.n[1] = nb;
  g.first = size_;
  g.count = 0;
  for (int side = 0; side < 2; ++side) {
    g.R[side].setZero();
    g.L[side].setZero();
  }
  return g;
}

bool Rows::finish() {
  changed_ = changed_ || used_ != groups_.size();
  groups_.resize(used_);
  return changed_;
}

void Rows::velocity(const Vector& nu, Vector& u) const {
  u.setZero(size_);
  for (const RowGroup& g : groups_)
    for (int side = 0; side < 2; ++side)
      if (g.n[side] > 0)
        u.segment(g.first, g.count).noalias() +=
            g.R[side].topLeftCorner(g.n[side], g.count).transpose() * nu.segment(g.v[side], g.n[side]);
}

void Rows::add(bool forces, const Vector& c, Vector& f) const {
  for (const RowGroup& g : groups_)
    for (int side = 0; side < 2; ++side)
      if (g.n[side] > 0)
        f.segment(g.v[side], g.n[side]).noalias() +=
            (forces ? g.L : g.R)[side].topLeftCorner(g.n[side], g.count) * c.segment(g.first, g.count);
}

void Rows::respond(const Model& model, const Instant& s, bool forces, Response& Y) const {
  Y.resize(groups_.size());
  for (std::size_t k = 0; k < groups_.size(); ++k) {
    const RowGroup& g = groups_[k];
    for (int side = 0; side < 2; ++side) {
      RowGroup::Block& out = Y[k][at(side)];
      out.setZero();
      if (g.n[side] == 0) continue;
      const RowGroup::Block& in = forces ? g.L[side] : g.R[side];
      for (int i = 0; i < g.count; ++i)
        solve_mass(model, s, g.body[side], in.col(i).data(), out.col(i).data());
    }
  }
}

void Rows::add_response(const Response& Y, const Vector& c, Vector& nu) const {
  for (std::size_t k = 0; k < groups_.size(); ++k) {
    const RowGroup& g = groups_[k];
    for (int side = 0; side < 2; ++side)
      if (g.n[side] > 0)
        nu.segment(g.v[side], g.n[side]).noalias() +=
            Y[k][at(side)].topLeftCorner(g.n[side], g.count) * c.segment(g.first, g.count);
  }
}

Matrix Rows::dense(bool forces, Eigen::Index nv) const {
  Matrix out = Matrix::Zero(nv, size_);
  for (const RowGroup& g : groups_)
    for (int side = 0; side < 2; ++side)
      if (g.n[side] > 0)
        out.block(g.v[side], g.first, g.n[side], g.count) +=
            (forces ? g.L[side] : g.R[side]).topLeftCorner(g.n[side], g.count);
  return out;
}

}  // namespace perp
