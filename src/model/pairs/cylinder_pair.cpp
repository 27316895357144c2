#include "model/pairs/cylinder_pair.hpp"

#include <algorithm>
#include <cmath>

namespace perp {
namespace {

std::size_t at(int i) { return static_cast<std::size_t>(i); }

constexpr double pi = 3.14159265358979323846;
constexpr double flat = 0.5;       // sine by which a patch's normal may leave a cone: 30 degrees
constexpr double edgewise = 0.1;   // of other features: 6 degrees
constexpr double upright = 1e-8;   // tilt below which a rim has no lowest point of its own [rad]
constexpr double parallel = 1e-6;  // sine between an edge and the axis, or a rim, below which corners say all
constexpr double rounding = 1e-9;  // of lengths, of the larger solid's size
constexpr double same_side = 0.5;  // cosine to the axis of least translation of what overlaps

bool leaves(const std::vector<Vector3>& spokes, const Vector3& normal, double sine) {
  return std::all_of(spokes.begin(), spokes.end(), [&](const Vector3& d) { return normal.dot(d) <= sine; });
}

/// The sine by which n, away from the edge's solid, leaves the cone of its faces; -1 of an edge without.
double leaves(const Polytope::Edge& edge, const Vector3& n) {
  double out = -1;
  for (const Vector3& side : edge.sides) out = std::max(out, n.dot(side));
  return out;
}

}  // namespace

/// B as it lies in A's axes.
struct CylinderPair::Placed {
  Vector3 centre, u, x, y;
  double r, h;

  Placed(const RoundBar& b, const Pose& X_AB)
      : centre(X_AB * b.centre),
        u(X_AB.q * b.axis),
        x(X_AB.q * b.across),
        y(u.cross(x)),
        r(b.radius),
        h(b.half) {}
  Vector3 end(double side) const { return centre + side * h * u; }
  Vector3 radial(double angle) const { return std::cos(angle) * x + std::sin(angle) * y; }
  Vector3 tangent(double angle) const { return -std::sin(angle) * x + std::cos(angle) * y; }
  double angle_of(const Vector3& d) const { return std::atan2(d.dot(y), d.dot(x)); }
  /// Of a normal that points to B: how far it leaves the cone of the rim's point at `angle`.
  double leaves_rim(const Vector3& n, double side, double angle) const {
    return std::max(n.dot(radial(angle)), h > 0 ? side * n.dot(u) : -1.0);
  }
};

CylinderPair::CylinderPair(const Polytope& a, const RoundBar& b)
    : a_(a),
      b_(b),
      corners_(static_cast<int>(a.corners.size())),
      edges_(static_cast<int>(a.edges.size())),
      faces_(static_cast<int>(a.faces.size())),
      ends_(b.half > 0 ? 2 : 1),
      slack_(rounding * std::max(a.size, b.radius + b.half)) {}

int CylinderPair::points() const {
  return corners_ + edges_ * (1 + 4 * ends_) + faces_ * ends_ + fixed * ends_;
}

/// Corners against the cap, the side or the rim, whichever is nearest to them; inside, whichever they are least behind.
template <class Take>
void CylinderPair::corners(const Placed& B, Take take) const {
  for (int i = 0; i < corners_; ++i) {
    const Vector3 &p = a_.corners[at(i)], d = p - B.centre;
    const double z = B.u.dot(d), side = z < 0 ? -1.0 : 1.0;
    const Vector3 rho = d - z * B.u;
    const double distance = rho.norm(), over = std::abs(z) - B.h, beyond = distance - B.r;
    const Vector3 radial = distance > 0 ? Vector3(rho / distance) : B.x;
    const auto give = [&](Kind kind, const Vector3& n, const Vector3& foot, double gap, double allowed) {
      if (!leaves(a_.spokes[at(i)], n, allowed)) return;
      take(Feature{kind, i, i, side, B.angle_of(rho), leaves(a_.spokes[at(i)], n, 0), {n, p, foot, gap}});
    };
    if (beyond > slack_ && (over > slack_ || !(B.h > 0))) {
      const Vector3 foot = B.end(side) + B.r * radial;
      const double gap = (foot - p).norm();
      give(Kind::CornerRim, (foot - p) / gap, foot, gap, edgewise);
    } else if (over >= beyond) {
      const Vector3 n = -side * B.u;
      give(Kind::CornerCap, n, p + over * n, over, flat);
    } else if (B.h > 0) {
      give(Kind::CornerSide, -radial, p - beyond * radial, beyond, a_.solid() ? edgewise : 1.0);
    }
  }
}

template <class Take>
void CylinderPair::edges(const Placed& B, Take take) const {
  for (int j = 0; j < edges_; ++j) {
    const Polytope::Edge& e = a_.edges[at(j)];
    edge_and_rims(B, j, take);
    edge_over_caps(B, j, take);
    if (!(B.h > 0)) continue;
    Vector3 n = e.along.cross(B.u);
    const double sine = n.norm();
    if (sine < parallel) continue;
    n /= sine;
    const Vector3 a0 = a_.corners[at(e.from)], d = B.centre - a0;
    const double c = e.along.dot(B.u), by_e = e.along.dot(d), by_u = B.u.dot(d), s2 = sine * sine;
    const double t = (by_e - c * by_u) / s2, s = (c * by_e - by_u) / s2;
    if (!(t > slack_ && t < e.length - slack_ && std::abs(s) < B.h - slack_)) continue;
    if (e.sides.empty() ? n.dot(d) < 0 : leaves(e, -n) < leaves(e, n)) n = -n;
    const double out = leaves(e, n), distance = n.dot(d) - B.r;
    if (out > edgewise) continue;
    const Vector3 foot = a0 + t * e.along;
    take(Feature{Kind::EdgeSide, corners_ + j, j, 0, 0, out <= 0, {n, foot, foot + distance * n, distance}});
  }
}

/// Points of the rim at which its tangent τ and the edge's direction e are both across b - a: zeros over the angle of
///   g = τ . (D - e (e . D)),  D = b - a_0.
template <class Take>
void CylinderPair::edge_and_rims(const Placed& B, int j, Take take) const {
  constexpr int samples = 16;
  const Polytope::Edge& e = a_.edges[at(j)];
  const Vector3 a0 = a_.corners[at(e.from)];
  for (int k = 0; k < ends_; ++k) {
    const double side = ends_ == 1 ? 0 : k == 0 ? -1 : 1;
    const Vector3 middle = B.end(side) - a0;
    const auto g = [&](double angle) {
      const Vector3 D = middle + B.r * B.radial(angle), tau = B.tangent(angle);
      return tau.dot(D) - tau.dot(e.along) * e.along.dot(D);
    };
    int found = 0;
    double before = g(0);
    for (int i = 1; i <= samples && found < 2; ++i) {
      double low = 2 * pi * (i - 1) / samples, high = 2 * pi * i / samples;
      const double after = g(high), first = before;
      before = after;
      if ((first < 0) == (after < 0)) continue;
      double g_low = first;
      for (int n = 0; n < 60 && high - low > 1e-16; ++n) {  // halves, or where a line through both ends says
        const double g_high = g(high), line = low - g_low * (high - low) / (g_high - g_low);
        const double middle_angle = n % 3 != 2 && line > low && line < high ? line : 0.5 * (low + high);
        if (middle_angle <= low || middle_angle >= high) break;
        const double g_middle = g(middle_angle);
        if ((g_middle < 0) == (g_low < 0))
          low = middle_angle, g_low = g_middle;
        else
          high = middle_angle;
      }
      const double angle = 0.5 * (low + high);
      const Vector3 tau = B.tangent(angle), D = middle + B.r * B.radial(angle);
      const double t = e.along.dot(D);
      Vector3 n = e.along.cross(tau);
      if (n.norm() < parallel || !(t > slack_ && t < e.length - slack_)) continue;
      n.normalize();
      const auto out_of = [&](const Vector3& m) {
        return std::max(leaves(e, m), B.leaves_rim(m, side, angle));
      };
      if (out_of(-n) < out_of(n)) n = -n;
      if (e.sides.empty() && n.dot(D - t * e.along) < 0) n = -n;
      const double out = out_of(n), distance = n.dot(D - t * e.along);
      if (out > edgewise) continue;
      const Vector3 foot = a0 + t * e.along;
      take(Feature{Kind::EdgeRim,
                   corners_ + edges_ + 2 * (ends_ * j + k) + found++,
                   j,
                   side,
                   angle,
                   out <= 0,
                   {n, foot, foot + distance * n, distance}});
    }
  }
}

template <class Take>
void CylinderPair::edge_over_caps(const Placed& B, int j, Take take) const {
  const Polytope::Edge& e = a_.edges[at(j)];
  const Vector3 a0 = a_.corners[at(e.from)], d = a0 - B.centre;
  const Vector3 d_r = d - B.u.dot(d) * B.u, e_r = e.along - B.u.dot(e.along) * B.u;
  const double A = e_r.squaredNorm(), half_b = d_r.dot(e_r), c = d_r.squaredNorm() - B.r * B.r;
  const double under = half_b * half_b - A * c;
  if (!(under > 0) || A < parallel * parallel) return;
  for (int i = 0; i < 2; ++i) {
    const double t = (-half_b + (i == 0 ? -1.0 : 1.0) * std::sqrt(under)) / A;
    if (!(t > slack_ && t < e.length - slack_)) continue;
    const Vector3 p = a0 + t * e.along;
    for (int k = 0; k < ends_; ++k) {
      const double z = B.u.dot(p - B.centre);
      const double side = ends_ == 1 ? (z < 0 ? -1.0 : 1.0) : k == 0 ? -1 : 1;
      const Vector3 n = -side * B.u;
      const double out = leaves(e, n), gap = side * z - B.h;
      if (out > flat || gap < -B.h - slack_) continue;
      const int slot = corners_ + edges_ * (1 + 2 * ends_) + 2 * (ends_ * j + k) + i;
      take(Feature{Kind::EdgeCap, slot, j, side, t, out <= 0, {n, p, p + gap * n, gap}});
    }
  }
}

/// Rims over faces: the lowest point of each, and the points fixed on those that are almost flat.
template <class Take>
void CylinderPair::faces(const Placed& B, Take take) const {
  const int first = corners_ + edges_ * (1 + 4 * ends_);
  for (int f = 0; f < faces_; ++f) {
    const Polytope::Face& face = a_.faces[at(f)];
    const Vector3 &n = face.normal, down = n.dot(B.u) * B.u - n;
    const double sine = down.norm();
    for (int k = 0; k < ends_; ++k) {
      const double side = ends_ == 1 ? 0 : k == 0 ? -1 : 1;
      const auto give = [&](Kind kind, int slot, double angle, const Vector3& x) {
        const double gap = n.dot(x) - face.offset;
        take(Feature{kind, slot, f, side, angle, true, {n, x - gap * n, x, gap}});
      };
      const double lowest = sine > upright ? B.angle_of(down) : pi;
      give(Kind::FaceRim, first + ends_ * f + k, lowest, B.end(side) + B.r * B.radial(lowest));
      const bool towards = ends_ == 1 || side * B.u.dot(n) < 0;
      if (sine > flat || !towards) continue;
      for (int i = 0; i < fixed; ++i) {
        const double angle = (2 * i + 1) * pi / fixed;
        give(Kind::FacePoint, first + ends_ * faces_ + fixed * k + i, angle,
             B.end(side) + B.r * B.radial(angle));
      }
    }
  }
}

/// Of the faces' normals and the caps', that along which the two are parted most.
CylinderPair::Axis CylinderPair::flat_axes(const Placed& B) const {
  Axis axis;
  for (const Polytope::Face& f : a_.faces) {
    const double along = f.normal.dot(B.u);
    const double low =
        f.normal.dot(B.centre) - B.h * std::abs(along) - B.r * std::sqrt(std::max(0.0, 1 - along * along));
    if (low - f.offset > axis.distance) axis = {low - f.offset, f.normal};
  }
  for (const double side : {-1.0, 1.0}) {
    double least = infinity;
    for (const Vector3& p : a_.corners) least = std::min(least, side * B.u.dot(p - B.centre) - B.h);
    if (least < infinity && least > axis.distance) axis = {least, -side * B.u};
  }
  return axis;
}

template <class Take>
void CylinderPair::features(const Pose& X_AB, Take take) const {
  const Placed B(b_, X_AB);
  static thread_local std::vector<Feature> all;
  all.clear();
  Axis axis = flat_axes(B);
  const auto keep = [&](const Feature& f) {
    all.push_back(f);
    const bool meets_round = f.kind == Kind::CornerSide || f.kind == Kind::EdgeSide ||
                             f.kind == Kind::EdgeRim || f.kind == Kind::CornerRim;
    if (meets_round && f.strict && f.witness.distance > axis.distance)
      axis = {f.witness.distance, f.witness.normal};
  };
  corners(B, keep);
  edges(B, keep);
  faces(B, keep);
  const bool apart = axis.distance >= -slack_;
  for (const Feature& f : all) {
    const Witness& w = f.witness;
    const bool on_face = f.kind == Kind::FaceRim || f.kind == Kind::FacePoint;
    const bool over = !on_face || a_.over(a_.faces[at(f.of_a)], w.b, slack_);
    if (w.distance >= -slack_) {
      if (over) take(f);
    } else if (
        !apart) {  // along the least translation: what the axis' own face has, and what is as deep at most
      const double along = w.normal.dot(axis.normal);
      const bool of_axis = along > 1 - 1e-12;
      const bool shallow = w.distance >= 2 * axis.distance - slack_;
      if (of_axis || (over && shallow && along > same_side)) take(f);
    }
  }
}

void CylinderPair::evaluate(const Pose& X_WA, const Pose& X_WB, std::span<ContactPoint> out) const {
  for (ContactPoint& c : out) c.gap = infinity;
  const Matrix3 R = X_WA.R();
  features(X_WA.inverse() * X_WB, [&](const Feature& f) {
    const ContactPoint c = f.witness.in(X_WA, R).contact(a_.radius, 0);
    if (c.gap < out[at(f.slot)].gap) out[at(f.slot)] = c;  // a fixed point counts over one face
  });
}

/// The point of a rim at `angle`, where that is what the rim's and the edge's tangents make it.
MovingWitness CylinderPair::moving_rim(const Feature& f, const Pose& X_WA, const Pose& X_WB) const {
  const FixedIn A{0, X_WA}, B{6, X_WB};
  const Polytope::Edge& edge = a_.edges[at(f.of_a)];
  const Placed world(b_, X_WB);
  const Vector3 radial = world.radial(f.angle), tau_now = world.tangent(f.angle);
  const double r = b_.radius;
  const Moving e = A.direction(X_WA.q * edge.along), a0 = A.point(X_WA * a_.corners[at(edge.from)]);
  const Moving b_fixed = B.point(world.end(f.end) + r * radial), tau_fixed = B.direction(tau_now);
  const Moving D = b_fixed - a0;
  const MovingNumber tau_D = dot(tau_fixed, D), tau_e = dot(tau_fixed, e), e_D = dot(e, D);
  const double g_angle = -radial.dot(D.x) + r + radial.dot(e.x) * e_D.x - r * tau_e.x * tau_e.x;
  const Eigen::Matrix<double, 1, 12> g_pose = tau_D.d - tau_e.d * e_D.x - tau_e.x * e_D.d,
                                     angle = -g_pose / g_angle;
  Moving b = b_fixed, tau = tau_fixed;
  b.d += r * tau_now * angle;
  tau.d -= radial * angle;
  Moving n = unit(cross(e, tau));
  if (n.x.dot(X_WA.q * f.witness.normal) < 0) n = -1.0 * n;
  return {n, a0 + dot(e, b - a0) * e, b};
}

/// The derivative of a feature's witness, by what is fixed in each body.
MovingWitness CylinderPair::moving(const Feature& f, const Pose& X_WA, const Pose& X_WB) const {
  const FixedIn A{0, X_WA}, B{6, X_WB};
  const Placed world(b_, X_WB);
  const Moving u = B.direction(world.u), centre = B.point(world.centre);
  const auto rim_end = [&](double side) { return B.point(world.end(side)); };
  switch (f.kind) {
    case Kind::CornerCap: {
      const Moving p = A.point(X_WA * a_.corners[at(f.of_a)]), n = -f.end * u;
      return {n, p, p + dot(n, rim_end(f.end) - p) * n};
    }
    case Kind::CornerSide: {
      const Moving p = A.point(X_WA * a_.corners[at(f.of_a)]), d = p - centre;
      const Moving rho = d - dot(u, d) * u;
      const Moving radial = rho.x.norm() > 0 ? unit(rho) : B.direction(world.x);
      return {-1.0 * radial, p, centre + dot(u, d) * u + b_.radius * radial};
    }
    case Kind::CornerRim: {
      const Moving p = A.point(X_WA * a_.corners[at(f.of_a)]), d = p - centre;
      const Moving b = rim_end(f.end) + b_.radius * unit(d - dot(u, d) * u);
      return {unit(b - p), p, b};
    }
    case Kind::EdgeRim:
      return moving_rim(f, X_WA, X_WB);
    case Kind::FaceRim: {
      const Polytope::Face& face = a_.faces[at(f.of_a)];
      const Moving n = A.direction(X_WA.q * face.normal), down = dot(n, u) * u - n;
      const Moving out = down.x.norm() > upright ? unit(down) : B.direction(world.radial(f.angle));
      const Moving b = rim_end(f.end) + b_.radius * out;
      return {n, b - dot(n, b - A.point(X_WA * face.point)) * n, b};
    }
    case Kind::FacePoint: {
      const Polytope::Face& face = a_.faces[at(f.of_a)];
      const Moving n = A.direction(X_WA.q * face.normal);
      const Moving b = B.point(world.end(f.end) + b_.radius * world.radial(f.angle));
      return {n, b - dot(n, b - A.point(X_WA * face.point)) * n, b};
    }
    default:
      break;
  }
  const Polytope::Edge& edge = a_.edges[at(f.of_a)];
  const Moving e = A.direction(X_WA.q * edge.along), a0 = A.point(X_WA * a_.corners[at(edge.from)]);
  const auto quotient = [](const MovingNumber& p, const MovingNumber& q) {
    return MovingNumber{p.x / q.x, (p.d - p.x / q.x * q.d) / q.x};
  };
  if (f.kind == Kind::EdgeCap) {  // a0 + t e at the distance r from the axis
    const Moving p = a0 + MovingNumber{f.angle, Eigen::Matrix<double, 1, 12>::Zero()} * e, d = p - centre;
    const Moving rho = d - dot(u, d) * u;
    const double by_t = rho.x.dot(e.x - u.x.dot(e.x) * u.x);
    const Eigen::Matrix<double, 1, 12> t = -(rho.x.transpose() * rho.d) / by_t;
    Moving crossing = p;
    crossing.d += e.x * t;
    const Moving n = -f.end * u;
    return {n, crossing, crossing + dot(n, rim_end(f.end) - crossing) * n};
  }
  Moving n = unit(cross(e, u));  // EdgeSide: t = d . (u x n)/(e . (u x n)), d from edge to axis
  if (n.x.dot(X_WA.q * f.witness.normal) < 0) n = -1.0 * n;
  const Moving d = centre - a0, by_u = cross(u, n);
  const Moving a = a0 + quotient(dot(d, by_u), dot(e, by_u)) * e;
  const MovingNumber apart = dot(n, centre - a0);
  return {n, a, a + MovingNumber{apart.x - b_.radius, apart.d} * n};
}

void CylinderPair::differentiate(const Pose& X_WA, const Pose& X_WB, std::span<ContactDerivative> out) const {
  static thread_local std::vector<double> least;
  least.assign(out.size(), infinity);
  features(X_WA.inverse() * X_WB, [&](const Feature& f) {
    if (!(f.witness.distance < least[at(f.slot)])) return;
    least[at(f.slot)] = f.witness.distance;
    moving(f, X_WA, X_WB).contact(a_.radius, 0, out[at(f.slot)]);
  });
}

}  // namespace perp
