// Momentum of ncp2, whose step has two halves with impulses of their own at either end. The files have their sum: whether there are
// halves that make it, and that hold both equations of momentum, is a linear problem.
#include <cmath>
#include <Eigen/QR>

#include "judge.hpp"

namespace checker {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

/// Rows: for each body of the island six of each half's momentum [m/s], then for each joint six of how halves add up.
/// Columns: the first half's part of each contact's impulse, both halves' parts of each joint's.
class Halves {
 public:
  Halves(const Step& s, int island, unsigned struck) : s_(s), struck_(struck) {
    for (int i = 0; i < static_cast<int>(s.scene.bodies.size()); ++i)
      if (s.island[at(i)] == island) bodies_.push_back(i);
    for (std::size_t j = 0; j < s.scene.joints.size(); ++j)
      if (of(s.scene.joints[j].a) >= 0 || of(s.scene.joints[j].b) >= 0) joints_.push_back(j);
    half_ = s.x;
    half_end_ = s.y;
    for (std::size_t i = 0; i < s.scene.bodies.size(); ++i)
      for (State* into : {&half_, &half_end_}) {
        if (!s.scene.bodies[i].moves()) continue;
        into->bodies[i].v = s.u.bodies[i].v;
        into->bodies[i].w = s.u.bodies[i].w;
      }
    const auto n = static_cast<Eigen::Index>(bodies_.size());
    sums_ = 12 * n;
    b_.setZero(sums_ + 6 * static_cast<Eigen::Index>(joints_.size()));
    size_.setZero(2 * n);
    momenta();
    contacts();
    for (std::size_t k = 0; k < joints_.size(); ++k) joint(static_cast<Eigen::Index>(k));
    solve();
  }

  /// What is left of the momentum of body k of the island, linear (0) or angular (1), in half 0 or 1, as a speed.
  double left(std::size_t k, int half, int part) const {
    const auto row = 6 * (static_cast<Eigen::Index>(k) + half * static_cast<Eigen::Index>(bodies_.size()));
    if (half == 0 && struck(k)) return 0;
    return left_.segment<3>(row + 3 * part).norm();
  }
  double size(std::size_t k, int half) const {
    return size_[static_cast<Eigen::Index>(k) + half * static_cast<Eigen::Index>(bodies_.size())];
  }
  double sum_left() const {
    return joints_.empty() ? 0 : left_.tail(left_.size() - sums_).cwiseAbs().maxCoeff();
  }
  const std::vector<int>& bodies() const { return bodies_; }

 private:
  /// Of the island's body k: it was struck, and the second half has the impulses of its whole step.
  bool struck(std::size_t k) const { return (struck_ >> k & 1U) != 0; }
  bool struck(int a, int b) const {
    return (of(a) >= 0 && struck(at(of(a)))) || (of(b) >= 0 && struck(at(of(b))));
  }

  int of(int body) const {
    for (std::size_t k = 0; k < bodies_.size(); ++k)
      if (bodies_[k] == body) return static_cast<int>(k);
    return -1;
  }

  /// Impulse and moment about the body's centre (world axes) into rows of a half, as speeds.
  void put(VectorXd& column, int body, int half, const Vector3d& force, const Vector3d& point,
           const Vector3d& moment) {
    const int k = of(body);
    if (k < 0) return;
    const State& where = half == 0 ? s_.x : s_.y;
    const Body& b = s_.scene.bodies[at(body)];
    const BodyState& at_body = where.bodies[at(body)];
    const auto row = 6 * (k + half * static_cast<Eigen::Index>(bodies_.size()));
    column.segment<3>(row) += force / b.mass;
    const Vector3d angular = at_body.at.q.conjugate() * ((point - at_body.at.p).cross(force) + moment);
    column.segment<3>(row + 3) += scaled(b, angular);
    if (b.kind == Kind::Planar) column[row + 2] = 0;
  }

  /// sqrt(J^-1/m) times a moment in body axes: a speed.
  static Vector3d scaled(const Body& b, const Vector3d& moment) {
    if (b.kind == Kind::Planar) return moment.z() / std::sqrt(b.size[0] * b.mass) * Vector3d::UnitZ();
    if (b.kind != Kind::Spatial) return Vector3d::Zero();
    return moment.cwiseQuotient((b.inertia().diagonal() * b.mass).cwiseSqrt());
  }

  /// What the impulses of each half have to make: b = M nu_1/2 - T(M nu + h/2 f), and the second half's.
  void momenta() {
    const std::vector<Wrench> first = loads(s_.scene, half_, s_.values),
                              second = loads(s_.scene, half_end_, s_.values_y);
    for (std::size_t k = 0; k < bodies_.size(); ++k) {
      const int i = bodies_[k];
      const Body& b = s_.scene.bodies[at(i)];
      const BodyState &x = s_.x.bodies[at(i)], &y = s_.y.bodies[at(i)], &u = s_.u.bodies[at(i)];
      const Matrix3d J = b.inertia();
      const Quaterniond quarter(Eigen::AngleAxisd(0.5 * s_.h * u.w.norm(), u.w.normalized()));
      const Quaterniond middle = u.w.norm() > 0 ? quarter * x.at.q : x.at.q;
      const Vector3d L_x = x.at.q * (J * (x.at.q.conjugate() * x.w)),
                     L_half = middle * (J * (middle.conjugate() * u.w)),
                     L_y = y.at.q * (J * (y.at.q.conjugate() * y.w));
      const double h2 = 0.5 * s_.h;
      VectorXd& to = b_;
      const auto row = [&](int half) {
        return 6 * (static_cast<Eigen::Index>(k) + half * static_cast<Eigen::Index>(bodies_.size()));
      };
      const Vector3d before = struck(k) ? x.v : u.v, L_before = struck(k) ? L_x : L_half;
      Vector3d f1 = h2 * first[at(i)].force, f2 = h2 * second[at(i)].force;
      Vector3d m1 = h2 * first[at(i)].moment, m2 = h2 * second[at(i)].moment;
      if (struck(k)) {
        f2 += f1;
        m2 += m1;
      } else {
        to.segment<3>(row(0)) = u.v - x.v - f1 / b.mass;
        to.segment<3>(row(0) + 3) = scaled(b, x.at.q.conjugate() * (L_half - L_x - m1));
      }
      to.segment<3>(row(1)) = y.v - before - f2 / b.mass;
      to.segment<3>(row(1) + 3) = scaled(b, y.at.q.conjugate() * (L_y - L_before - m2));
      if (b.kind == Kind::Planar) to[row(0) + 2] = to[row(1) + 2] = 0;
      const double size = x.v.norm() + u.v.norm() + y.v.norm() + f1.norm() / b.mass + f2.norm() / b.mass +
                          scaled(b, x.at.q.conjugate() * L_x).norm() +
                          scaled(b, y.at.q.conjugate() * L_y).norm() + m1.norm();
      size_[static_cast<Eigen::Index>(k)] += size;
      size_[static_cast<Eigen::Index>(k + bodies_.size())] += size;
    }
  }

  void push_pair(VectorXd& column, const Touch& c, int half, const Vector3d& p) {
    const Vector3d zero = Vector3d::Zero();
    put(column, c.b, half, c.turns ? zero : p, c.point, c.turns ? p : zero);
    put(column, c.a, half, c.turns ? zero : Vector3d(-p), c.point, c.turns ? Vector3d(-p) : zero);
  }

  /// p_2 = p - p_1: what is known moves to the right, p_1 is a column in both halves. With halves in the file all is known.
  void contacts() {
    for (const ContactRow& c : s_.contacts) {
      const Touch *x = s_.touch(s_.at_x, c.contact), *y = s_.touch(s_.at_y, c.contact);
      if (x == nullptr || y == nullptr || (of(x->a) < 0 && of(x->b) < 0) || c.p.isZero(0)) continue;
      VectorXd known = VectorXd::Zero(b_.size());
      if (c.half != 0) {
        const bool first = c.half == 1 && !struck(x->a, x->b);
        push_pair(known, first ? *x : *y, first ? 0 : 1, c.p);
        subtract(known);
        continue;
      }
      if (has_halves(c.contact)) continue;
      push_pair(known, *y, 1, c.p);
      subtract(known);
      if (struck(x->a, x->b)) continue;
      for (int k = 0; k < (x->stop ? 1 : 3); ++k) {
        const Vector3d d = x->stop ? x->normal : Vector3d(Vector3d::Unit(k));
        VectorXd column = VectorXd::Zero(b_.size());
        push_pair(column, *x, 0, d);
        push_pair(column, *y, 1, -d);
        columns_.push_back(column);
      }
    }
  }

  bool has_halves(const std::string& name) const {
    for (const ContactRow& c : s_.contacts)
      if (c.half != 0 && c.contact == name) return true;
    return false;
  }

  void subtract(const VectorXd& known) {
    b_ -= known;
    const auto n = static_cast<Eigen::Index>(bodies_.size());
    for (Eigen::Index k = 0; k < 2 * n; ++k) size_[k] += known.segment<6>(6 * k).norm();
  }

  /// Each row of a joint, at q and at q+, with its part in both sums; friction along the freedom.
  void joint(Eigen::Index k) {
    const std::size_t j = joints_[static_cast<std::size_t>(k)];
    const Joint& joint = s_.scene.joints[j];
    const JointReport* r = s_.joint(j);
    double lightest = std::numeric_limits<double>::infinity();
    for (const int i : {joint.a, joint.b})
      if (s_.scene.bodies[at(i)].moves()) lightest = std::min(lightest, s_.scene.bodies[at(i)].mass);
    const Eigen::Index sum = sums_ + 6 * k;
    const double length = lever(joint, j);
    b_.segment<3>(sum) = s_.h * r->force / lightest;
    b_.segment<3>(sum + 3) = s_.h * r->moment / (lightest * length);
    sum_size_ = std::max(sum_size_, b_.segment<6>(sum).norm());
    for (const int half : {0, 1}) {
      if (half == 0 && struck(joint.a, joint.b)) continue;
      const JointState& now = half == 0 ? s_.joints_x[j] : s_.joints_y[j];
      for (const JointRow& row : now.rows) {
        VectorXd column = VectorXd::Zero(b_.size());
        push_joint(column, joint, now, row, half);
        column.segment<3>(sum) = row.force / lightest;
        column.segment<3>(sum + 3) = row.moment_b / (lightest * length);
        columns_.push_back(column);
      }
    }
    if (!(joint.friction > 0)) return;
    VectorXd known = VectorXd::Zero(b_.size());
    push_joint(known, joint, s_.joints_y[j], s_.joints_y[j].coordinates[0], 1);
    subtract(known * s_.h * r->friction);
    if (struck(joint.a, joint.b)) return;
    VectorXd column = VectorXd::Zero(b_.size());
    push_joint(column, joint, s_.joints_x[j], s_.joints_x[j].coordinates[0], 0);
    columns_.push_back(column - known);
  }

  double lever(const Joint& joint, std::size_t j) const {
    double length = 0;
    for (const int i : {joint.a, joint.b}) {
      const Body& b = s_.scene.bodies[at(i)];
      if (!b.moves()) continue;
      length = std::max(length, (s_.joints_x[j].anchor - s_.x.bodies[at(i)].at.p).norm());
      if (b.turns()) length = std::max(length, std::sqrt(b.inertia().trace() / b.mass));
    }
    return length > 0 ? length : 1;
  }

  void push_joint(VectorXd& column, const Joint& joint, const JointState& now, const JointRow& row,
                  int half) {
    put(column, joint.b, half, row.force, now.anchor, row.moment_b);
    put(column, joint.a, half, -row.force, now.anchor, -row.moment_a);
  }

  void solve() {
    left_ = b_;
    if (columns_.empty()) return;
    MatrixXd A(b_.size(), static_cast<Eigen::Index>(columns_.size()));
    for (std::size_t k = 0; k < columns_.size(); ++k) A.col(static_cast<Eigen::Index>(k)) = columns_[k];
    VectorXd scale = A.colwise().norm();
    for (Eigen::Index k = 0; k < scale.size(); ++k) A.col(k) /= scale[k] > 0 ? scale[k] : 1;
    Eigen::CompleteOrthogonalDecomposition<MatrixXd> qr(A);
    qr.setThreshold(1e-13);
    VectorXd p = qr.solve(b_);
    p += qr.solve(b_ - A * p);
    left_ = b_ - A * p;
    const auto n = static_cast<Eigen::Index>(bodies_.size());
    for (Eigen::Index k = 0; k < 2 * n; ++k)
      size_[k] += (A.middleRows(6 * k, 6).cwiseAbs() * p.cwiseAbs()).norm();
  }

  const Step& s_;
  const unsigned struck_;  // a bit a body of the island
  std::vector<int> bodies_;
  std::vector<std::size_t> joints_;
  State half_, half_end_;
  Eigen::Index sums_ = 0;
  VectorXd b_, left_, size_;
  double sum_size_ = 0;
  std::vector<VectorXd> columns_;
};

/// The worst of the island over what is allowed, and where.
double worst(const Step& s, const Halves& halves, int& body, double& value, double& limit) {
  double most = 0;
  body = halves.bodies()[0];
  for (std::size_t k = 0; k < halves.bodies().size(); ++k)
    for (const int half : {0, 1})
      for (const int part : {0, 1}) {
        const int i = halves.bodies()[k];
        const Body& b = s.scene.bodies[at(i)];
        const double rounding =
            4 * s.place_rounding() +
            (b.turns() ? s.marks.rounding * std::sqrt(b.inertia().trace() / b.mass) / s.h : 0);
        const double allowed = 2 * s.allowed(s.speed_of(i), halves.size(k, half)) + rounding;
        const double left = halves.left(k, half, part);
        if (left / allowed <= most) continue;
        most = left / allowed;
        body = i;
        value = left;
        limit = allowed;
      }
  return most;
}

}  // namespace

void judge_halves(Step& s) {
  for (int island = 0; island < static_cast<int>(s.speed.size()); ++island) {
    int body = 0;
    double value = 0, limit = 0;
    const Halves whole(s, island, 0);
    if (worst(s, whole, body, value, limit) <= 1) continue;
    bool found = false;
    if (s.struck[at(island)] != 0) {  // which of its bodies an impact reached, the file does not say
      const unsigned all = 1U << whole.bodies().size();
      for (unsigned struck = all - 1; struck > 0 && !found; --struck) {
        int other = 0;
        double other_value = 0, other_limit = 0;
        found = worst(s, Halves(s, island, struck), other, other_value, other_limit) <= 1;
      }
    }
    if (found)
      s.follows[at(island)] = 0;
    else
      s.fault("momentum", s.scene.bodies[at(body)].name, value, limit);
  }
}

}  // namespace checker
