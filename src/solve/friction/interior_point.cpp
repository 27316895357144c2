#include <algorithm>
#include <cmath>

#include "solve/friction/friction_stages.hpp"
#include "solve/friction/second_order_cone.hpp"

namespace perp {
namespace {

/// Each group of a block's rows makes a second-order cone of its own with the normal row: x = P S r, S picking the rows, P of cone_scaling() for the
/// group alone. In the block's equation u = W r + q the cones' y add up,
///   u = sum S^T P (y - |y_T| e_0),                                                          (1)
/// so that û_N is shared out among their y_0. A half line is a cone whose other rows are not there; a bound of constant size one whose x_0 is known.
enum class Role : char { Off, Line, Cone, Known };

/// The homotopy of one system: x and y of every cone, c-th of block i at i * cones + c.
template <int R>
class Homotopy {
 public:
  static constexpr int cones = static_cast<int>(RowGroups<R>::all.size());
  static constexpr int D = RowGroups<R>::all[0].size + 1;

  Homotopy(const ContactSystem<R>& system, const InteriorPointOptions& options);

  Columns<R> reaction() const;  ///< in the rows of a bound of constant size: with its x_0
  double kappa() const;
  void linearise(const Columns<R>& Wr);  ///< residuals, scalings, and A, B of the step's (A + B W) dr = rhs
  bool factor() { return system_.W->factor(A_, B_); }
  bool step(double kappa);  ///< predictor, corrector, and as far as the cones let it
  void without_known(Columns<R>& r) const;

 private:
  static Column<D> pick(const Column<R>& r, int c);
  template <class Function>
  void for_each(const Function& function) const {  // (block, cone of the block, place)
    for (int i = 0; i < system_.n; ++i)
      for (int c = 0; c < cones; ++c)
        if (role_[i * cones + c] != Role::Off) function(i, c, i * cones + c);
  }
  bool pushes(int i, int k) const {  // a row that is not there does no harm beside the planar one
    const Block<R>& block = system_.block[i];
    return block.axes(k) > 0 || (block.planar() && block.radius > 0);
  }
  void take_roles();
  void linearise(int i, int c, const Column<R>& u);
  bool direction();
  double longest_step() const;

  const ContactSystem<R>& system_;
  const InteriorPointOptions& options_;
  std::vector<Role> role_;
  std::vector<char> first_;  // the block's cone that sees u_N
  int count_ = 0;            // of cones
  Columns<D> P_, x_, y_, residual_, c_, dx_, dy_;
  std::vector<Scaling<D>> scaling_;
  Squares<D> IG_;
  Squares<R> A_, B_;
  Columns<R> rhs_, dr_, W_dr_;
};

template <int R>
Column<Homotopy<R>::D> Homotopy<R>::pick(const Column<R>& r, int c) {
  const RowGroup& group = RowGroups<R>::all[c];
  Column<D> x = Column<D>::Zero();
  x(0) = r(0);
  for (int k = 0; k < group.size; ++k) x(1 + k) = r(group.first + k);
  return x;
}

/// P of the tangential rows, a/axes over √a of contacts, a the longest; 1 in a/axes where there is no axis.
Vector3 tangential_scaling(const Vector3& axes, bool contact) {
  const double longest = axes.maxCoeff();
  Vector3 ratio = Vector3::Ones();
  for (int k = 0; k < 3; ++k)
    if (axes(k) > 0) ratio(k) = longest / axes(k);
  return contact ? Vector3(ratio / std::sqrt(longest)) : ratio;
}

template <int R>
void Homotopy<R>::take_roles() {
  for (int i = 0; i < system_.n; ++i) {
    const Block<R>& block = system_.block[i];
    bool any = false;
    for (int c = 0; c < cones; ++c) {
      const int at = i * cones + c;
      const RowGroup& group = RowGroups<R>::all[c];
      P_.col(at).setOnes();
      if (!block.has(group)) continue;
      role_[at] = block.contact ? Role::Cone : Role::Known;
      first_[at] = !any;
      any = true;
      const Vector3 axes = Block<R>::rows(block.axes, group);
      P_.col(at).segment(1, group.size) = tangential_scaling(axes, block.contact).head(group.size);
      if (block.contact) P_(0, at) = std::sqrt(axes.maxCoeff());
    }
    if (!any && block.contact) role_[i * cones] = Role::Line, first_[i * cones] = true;
    for (int c = 0; c < cones; ++c) count_ += role_[i * cones + c] != Role::Off;
  }
}

template <int R>
Homotopy<R>::Homotopy(const ContactSystem<R>& system, const InteriorPointOptions& options)
    : system_(system),
      options_(options),
      role_(system.n * cones, Role::Off),
      first_(system.n * cones, false),
      P_(D, system.n * cones),
      x_(Columns<D>::Zero(D, system.n * cones)),
      y_(x_),
      residual_(x_),
      c_(x_),
      dx_(x_),
      dy_(x_),
      scaling_(system.n * cones),
      IG_(system.n * cones),
      A_(system.n),
      B_(system.n),
      rhs_(R, system.n) {
  take_roles();
  double largest = 0;
  for_each([&](int i, int c, int at) {
    largest = std::max(largest, pick(system_.q.col(i), c).cwiseQuotient(P_.col(at)).cwiseAbs().maxCoeff());
  });
  const double start = options.start * std::max(0.1, largest);
  for (int i = 0; i < system.n; ++i) {
    double normal = not_set;  // reaction; the cones share it
    for (int c = 0; c < cones; ++c) {
      const int at = i * cones + c;
      if (role_[at] == Role::Off) continue;
      if (first_[at]) normal = start / P_(0, at);
      x_(0, at) = first_[at] ? start : P_(0, at) * normal;
      y_(0, at) = first_[at] ? start : start * start / x_(0, at);
    }
  }
}

template <int R>
Columns<R> Homotopy<R>::reaction() const {
  Columns<R> r = Columns<R>::Zero(R, system_.n);
  for_each([&](int i, int c, int at) {
    const Column<D> part = x_.col(at).cwiseQuotient(P_.col(at));
    const RowGroup& group = RowGroups<R>::all[c];
    if (first_[at]) r(0, i) = part(0);
    r.col(i).segment(group.first, group.size) = part.segment(1, group.size);
  });
  return r;
}

template <int R>
void Homotopy<R>::without_known(Columns<R>& r) const {
  for (int i = 0; i < system_.n; ++i)
    if (!system_.block[i].contact) r(0, i) = 0;
}

template <int R>
double Homotopy<R>::kappa() const {
  double sum = 0;
  for_each([&](int, int, int at) { sum += x_.col(at).dot(y_.col(at)); });
  return sum / count_;
}

template <int R>
void Homotopy<R>::linearise(int i, int c, const Column<R>& u) {
  const int at = i * cones + c;
  const RowGroup& group = RowGroups<R>::all[c];
  Column<D> u_c = pick(u, c);
  if (!first_[at]) u_c(0) = 0;
  residual_.col(at) = u_c.cwiseQuotient(P_.col(at)) - y_.col(at);
  IG_[at].setIdentity();
  if (role_[at] == Role::Line) {
    residual_.col(at).template tail<D - 1>().setZero();
    scaling_[at] = half_line_scaling<D>(x_(0, at), y_(0, at));
  } else {
    const double slip = system_.associated ? 0 : y_.col(at).template tail<D - 1>().norm();
    const bool known = role_[at] == Role::Known;
    if (known)
      residual_(0, at) = 0;
    else
      residual_(0, at) += slip;
    for (int k = 0; k < group.size; ++k)
      if (!pushes(i, group.first + k)) residual_(1 + k, at) = 0;
    if (slip > 0 && !known)
      IG_[at].template block<1, D - 1>(0, 1) =
          -options_.damping * y_.col(at).template tail<D - 1>().transpose() / slip;
    scaling_[at] = nesterov_todd<D>(x_.col(at), y_.col(at));
  }
  // in r: (sum S^T P (I-G) N P S + W) dr = sum S^T P ((I-G) V (λ\c) - residual)
  const Square<D> part = P_.col(at).asDiagonal() * (IG_[at] * scaling_[at].N) * P_.col(at).asDiagonal();
  A_[i](0, 0) += part(0, 0);
  A_[i].block(0, group.first, 1, group.size) += part.block(0, 1, 1, group.size);
  A_[i].block(group.first, 0, group.size, 1) += part.block(1, 0, group.size, 1);
  A_[i].block(group.first, group.first, group.size, group.size) += part.block(1, 1, group.size, group.size);
}

template <int R>
void Homotopy<R>::linearise(const Columns<R>& Wr) {
  for (int i = 0; i < system_.n; ++i) {
    A_[i].setZero();
    B_[i].setIdentity();
    const Column<R> u = Wr.col(i) + system_.q.col(i);
    for (int c = 0; c < cones; ++c)
      if (role_[i * cones + c] != Role::Off) linearise(i, c, u);
    for (int k = 0; k < R; ++k) {
      if (k == 0 ? system_.block[i].contact : pushes(i, k)) continue;  // else: r_k is known
      A_[i].row(k).setZero();
      A_[i](k, k) = 1;
      B_[i].row(k).setZero();
    }
  }
}

template <int R>
bool Homotopy<R>::direction() {
  rhs_.setZero();
  for_each([&](int i, int c, int at) {
    Column<D> target = Column<D>::Zero();
    if (role_[at] == Role::Line)
      target(0) = c_(0, at) / scaling_[at].lambda(0);
    else
      target = divide<D>(scaling_[at].lambda, c_.col(at));
    dy_.col(at) = scaling_[at].V * target;
    const Column<D> part = P_.col(at).cwiseProduct(IG_[at] * dy_.col(at) - residual_.col(at));
    const RowGroup& group = RowGroups<R>::all[c];
    rhs_(0, i) += part(0);
    rhs_.col(i).segment(group.first, group.size) += part.segment(1, group.size);
    if (role_[at] == Role::Known) rhs_(0, i) = system_.block[i].axes.maxCoeff() - x_(0, at);
  });
  if (!system_.W->solve(rhs_, dr_, W_dr_)) return false;
  for_each([&](int i, int c, int at) {
    dx_.col(at) = P_.col(at).cwiseProduct(pick(dr_.col(i), c));
    dy_.col(at) -= scaling_[at].N * dx_.col(at);
  });
  return true;
}

template <int R>
double Homotopy<R>::longest_step() const {
  double t = infinity;
  for_each([&](int, int, int at) {
    if (role_[at] != Role::Line) {
      t = std::min({t, distance_to_boundary<D>(x_.col(at), dx_.col(at)),
                    distance_to_boundary<D>(y_.col(at), dy_.col(at))});
    } else {
      if (dx_(0, at) < 0) t = std::min(t, -x_(0, at) / dx_(0, at));
      if (dy_(0, at) < 0) t = std::min(t, -y_(0, at) / dy_(0, at));
    }
  });
  return t;
}

template <int R>
bool Homotopy<R>::step(double kappa) {
  for_each([&](int, int, int at) {
    const Column<D>& lambda = scaling_[at].lambda;
    if (role_[at] == Role::Line)
      c_(0, at) = -lambda(0) * lambda(0);
    else
      c_.col(at) = -product(lambda, lambda);
  });
  if (!direction()) return false;
  const double affine = std::min(1.0, longest_step());
  const double sigma = std::pow(1 - affine, 3);
  for_each([&](int, int, int at) {
    const Column<D> a = scaling_[at].V * dx_.col(at), b = scaling_[at].V_inverse * dy_.col(at);
    if (role_[at] == Role::Line) {
      c_(0, at) += sigma * kappa - a(0) * b(0);
    } else {
      c_.col(at) += sigma * kappa * Column<D>::Unit(0) - product(a, b);
    }
  });
  if (!direction()) return false;
  const double t = std::min(1.0, 0.99 * longest_step());
  x_ += t * dx_;
  y_ += t * dy_;
  return true;
}

}  // namespace

template <int R>
void interior_point(const ContactSystem<R>& system, const InteriorPointOptions& options, double tolerance,
                    Budget& budget, Iterate<R>& best) {
  Homotopy<R> path(system, options);
  Columns<R> r, Wr;
  Iterate<R> point;
  for (int k = 0; k < options.most && !budget.spent(); ++k) {
    ++budget.iterations;
    r = path.reaction();
    system.W->apply(r, Wr);
    const double kappa = path.kappa();
    point.r = r;
    path.without_known(point.r);
    evaluate(system, point);
    if (!std::isfinite(point.error)) return;
    if (point.error < best.error) best = point;
    if (kappa < 1e-11 || best.error < tolerance) return;
    path.linearise(Wr);
    if (!path.factor() || !path.step(kappa)) return;
  }
}

template void interior_point(const ContactSystem<3>&, const InteriorPointOptions&, double, Budget&,
                             Iterate<3>&);
template void interior_point(const ContactSystem<6>&, const InteriorPointOptions&, double, Budget&,
                             Iterate<6>&);

}  // namespace perp
