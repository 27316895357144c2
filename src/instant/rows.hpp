// Rows of the equations of motion, in groups of one pair of bodies, and the graph that bodies make of them.
#pragma once

#include <array>
#include <vector>

#include "perp/instant/instant.hpp"

namespace perp {

/// At most six rows between the same two bodies; columns past them are zero.
struct RowGroup {
  using Block = Eigen::Matrix<double, 6, 6>;  ///< (velocities of the body, rows)
  int body[2] = {-1, -1};
  int v[2] = {0, 0}, n[2] = {0, 0};  ///< first velocity and number of velocities
  int first = 0, count = 0;          ///< rows
  Block R[2], L[2];
};

/// Rows R with u = Rᵀ nu + explicit part, and the columns L of the forces that keep them: L = R but for what tie() adds, the friction
/// of what slides.
class Rows {
 public:
  /// Velocities that impulses along L (or R) give: M^-1 L, group by group.
  using Response = std::vector<std::array<RowGroup::Block, 2>>;

  void start();
  /// Column `column` of W becomes the next row; its number.
  template <int C>
  int add(const WrenchMap<C>& W, int column);
  /// L of the last row added gains factor * (column of W), W of the same pair.
  template <int C>
  void tie(const WrenchMap<C>& W, int column, double factor);
  /// No more rows. Whether any group stands between other bodies, or has other rows, than before start().
  bool finish();

  int size() const { return size_; }
  const std::vector<RowGroup>& groups() const { return groups_; }

  void velocity(const Vector& nu, Vector& u) const;        ///< u = Rᵀ nu
  void add(bool forces, const Vector& c, Vector& f) const;  ///< f += L c, or R c
  void respond(const Model& model, const Instant& s, bool forces, Response& Y) const;  ///< Y = M^-1 L, or M^-1 R
  void add_response(const Response& Y, const Vector& c, Vector& nu) const;             ///< nu += Y c
  Matrix dense(bool forces, Eigen::Index nv) const;                                    ///< (nv, size) L, or R

 private:
  RowGroup& next(int a, int va, int na, int b, int vb, int nb);

  std::vector<RowGroup> groups_;
  std::size_t used_ = 0;
  int size_ = 0;
  bool changed_ = true;
};

template <int C>
int Rows::add(const WrenchMap<C>& W, int column) {
  RowGroup& g = next(W.a, W.va, W.na, W.b, W.vb, W.nb);
  g.R[0].col(g.count) = g.L[0].col(g.count) = W.A.col(column);
  g.R[1].col(g.count) = g.L[1].col(g.count) = W.B.col(column);
  ++g.count;
  return size_++;
}

template <int C>
void Rows::tie(const WrenchMap<C>& W, int column, double factor) {
  RowGroup& g = groups_[used_ - 1];
  g.L[0].col(g.count - 1) += factor * W.A.col(column);
  g.L[1].col(g.count - 1) += factor * W.B.col(column);
}

}  // namespace perp
