#include "model/pairs/polytope_pair.hpp"

#include <algorithm>
#include <cmath>

#include "core/index.hpp"

namespace perp {
namespace {

/// How far a normal may leave the cone of the directions that a corner or an edge meets others in, as a sine: what rests flat is at its
/// rim, and stays known as it tilts.
constexpr double flat = 0.5;      // corners of a face over a face: all that tilt by less than 30 degrees
constexpr double crossing = 0.5;  // edges that cross: 30 degrees
constexpr double edgewise =
    0.1;  // corners nearest to an edge or a corner, where another feature is nearer: 6 degrees
constexpr double parallel = 1e-6;  // sine between edges below which their crossing says nothing: corners do
constexpr double same_side =
    0.5;  // cosine to the axis of least translation of edges that overlap: 60 degrees
constexpr double rounding =
    1e-9;  // of lengths, of the larger solid's size: a corner on a face's rim is on the face

/// Where a point is nearest to a solid.
struct Nearest {
  enum class To { Inside, Face, Edge, Corner } to;
  int index = -1;
  Vector3 foot = Vector3::Zero();
  double distance = 0;
};

Nearest nearest(const Polytope& p, const Vector3& x, double slack) {
  double height = 0;
  const int face = p.highest_face(x, height);
  if (face >= 0 && height <= slack)
    return {Nearest::To::Inside, face, x - height * p.faces[at(face)].normal, height};
  if (face >= 0 && p.over(p.faces[at(face)], x, slack))
    return {Nearest::To::Face, face, x - height * p.faces[at(face)].normal, height};
  Nearest best{Nearest::To::Corner, -1, Vector3::Zero(), infinity};
  for (std::size_t i = 0; i < p.edges.size(); ++i) {
    const Polytope::Edge& e = p.edges[i];
    const Vector3& from = p.corners[at(e.from)];
    const double t = e.along.dot(x - from);
    if (!(t > 0 && t < e.length)) continue;
    const Vector3 foot = from + t * e.along;
    if (const double d = (x - foot).norm(); d < best.distance)
      best = {Nearest::To::Edge, static_cast<int>(i), foot, d};
  }
  for (std::size_t i = 0; i < p.corners.size(); ++i)
    if (const double d = (x - p.corners[i]).norm(); d < best.distance)
      best = {Nearest::To::Corner, static_cast<int>(i), p.corners[i], d};
  return best;
}

/// Whether `normal`, pointing away from the solid, leaves all of a corner's edges behind it by more than -sine.
bool leaves(const std::vector<Vector3>& spokes, const Vector3& normal, double sine) {
  return std::all_of(spokes.begin(), spokes.end(), [&](const Vector3& d) { return normal.dot(d) <= sine; });
}

Vector3 across(const Vector3& u) {
  return (std::abs(u.x()) < 0.6 ? u.cross(Vector3::UnitX()) : u.cross(Vector3::UnitY())).normalized();
}

/// Of a point x inside p: of the faces that it is no further below than the highest by `depth`, the one that looks most along n.
int face_along(const Polytope& p, const Vector3& x, double depth, const Vector3& n) {
  double height = 0;
  int best = p.highest_face(x, height);
  for (int i = 0; i < static_cast<int>(p.faces.size()); ++i) {
    const Polytope::Face& f = p.faces[at(i)];
    if (f.normal.dot(x) - f.offset >= height - depth && f.normal.dot(n) > p.faces[at(best)].normal.dot(n))
      best = i;
  }
  return best;
}

}  // namespace

/// B as it lies in A's axes.
struct PolytopePair::Placed {
  const Polytope& b;
  Pose X_AB;
  Matrix3 R;

  Vector3 point(const Vector3& x) const { return X_AB.p + R * x; }
  Vector3 back(const Vector3& x) const { return R.transpose() * (x - X_AB.p); }
};

PolytopePair::PolytopePair(const Polytope* a, const Polytope* b)
    : a_(*a),
      b_(*b),
      corners_a_(static_cast<int>(a_.corners.size())),
      corners_b_(static_cast<int>(b_.corners.size())),
      edges_a_(static_cast<int>(a_.edges.size())),
      edges_b_(static_cast<int>(b_.edges.size())),
      slack_(rounding * std::max(a_.size, b_.size)) {}

PolytopePair::PolytopePair(std::shared_ptr<const Polytope> a, std::shared_ptr<const Polytope> b)
    : PolytopePair(a.get(), b.get()) {
  own_a_ = std::move(a);
  own_b_ = std::move(b);
}

PolytopePair::PolytopePair(Polytope a, Polytope b)
    : PolytopePair(std::make_shared<const Polytope>(std::move(a)),
                   std::make_shared<const Polytope>(std::move(b))) {}

/// Whether the lines of two edges are nearest to each other within both, the normal there close to both edges' cones (`strict`: in them).
bool PolytopePair::edges_meet(const Polytope::Edge& a, const Polytope::Edge& b, const Placed& B, Witness& w,
                              bool& strict) const {
  const Vector3 e_a = a.along, e_b = B.R * b.along;
  Vector3 n = e_a.cross(e_b);
  const double sine = n.norm();
  if (sine < parallel) return false;
  n /= sine;
  const Vector3 a0 = a_.corners[at(a.from)], d = B.point(b_.corners[at(b.from)]) - a0;
  const double c = e_a.dot(e_b), along_a = e_a.dot(d), along_b = e_b.dot(d), s2 = sine * sine;
  const double t = (along_a - c * along_b) / s2, u = (c * along_a - along_b) / s2;
  if (!(t > slack_ && t < a.length - slack_ && u > slack_ && u < b.length - slack_)) return false;
  w.distance = n.dot(d);
  const auto worst = [&](const Vector3& m) {  // the sine by which m leaves the cones of both
    double sine_out = -1;
    for (const Vector3& side : a.sides) sine_out = std::max(sine_out, m.dot(side));
    for (const Vector3& side : b.sides) sine_out = std::max(sine_out, -m.dot(B.R * side));
    return sine_out;
  };
  if (a.sides.empty() && b.sides.empty()) {
    if (w.distance < 0) n = -n;
  } else if (worst(-n) < worst(n)) {
    n = -n;
  }
  const double out = worst(n);
  if (out > crossing) return false;
  strict = out <= 0;
  w.distance = n.dot(d);
  w.normal = n;
  w.a = a0 + t * e_a;
  w.b = w.a + w.distance * n;
  return true;
}

/// All edges that cross, and the axis among their normals.
void PolytopePair::edge_pairs(const Placed& B, Axis& axis, std::vector<Feature>& crossings) const {
  crossings.clear();
  for (int j = 0; j < edges_b_; ++j)
    for (int i = 0; i < edges_a_; ++i) {
      Witness w;
      bool strict = false;
      if (!edges_meet(a_.edges[at(i)], b_.edges[at(j)], B, w, strict)) continue;
      if (strict && w.distance > axis.distance) axis = {w.distance, w.normal, -1, -1};
      crossings.push_back({Kind::EdgeEdge, corners_b_ + corners_a_ + i * edges_b_ + j, i, j, w});
    }
}

/// The axis among the faces' normals, where one parts the solids more than what is known.
void PolytopePair::face_axes(const Placed& B, Axis& axis) const {
  const auto least_over = [](const Polytope& p, const Vector3& n) {
    double least = infinity;
    for (const Vector3& x : p.corners) least = std::min(least, n.dot(x));
    return least;
  };
  for (int i = 0; i < static_cast<int>(a_.faces.size()); ++i) {
    const Polytope::Face& f = a_.faces[at(i)];
    const double d = least_over(b_, B.R.transpose() * f.normal) + f.normal.dot(B.X_AB.p) - f.offset;
    if (d > axis.distance) axis = {d, f.normal, i, -1};
  }
  if (a_.corners.empty()) return;
  const Vector3 origin_a = B.back(Vector3::Zero());
  for (int i = 0; i < static_cast<int>(b_.faces.size()); ++i) {
    const Polytope::Face& f = b_.faces[at(i)];
    const double d = least_over(a_, B.R * f.normal) + f.normal.dot(origin_a) - f.offset;
    if (d > axis.distance) axis = {d, -(B.R * f.normal), -1, i};
  }
}

template <class Take>
void PolytopePair::corners_of_b(const Placed& B, const Axis& axis, Take take) const {
  const double deep = 2 * (slack_ + std::max(-axis.distance, 0.0));
  for (int i = 0; i < corners_b_; ++i) {
    const Vector3 x = B.point(b_.corners[at(i)]);
    const auto clear = [&](const Vector3& n, double sine) {
      return leaves(b_.spokes[at(i)], -(B.R.transpose() * n), sine);
    };
    if (axis.face_a >= 0 &&
        axis.distance < 0) {  // the corner that has to leave is over the face, whatever else it has passed
      const Polytope::Face& f = a_.faces[at(axis.face_a)];
      if (const double d = f.normal.dot(x) - f.offset; d <= axis.distance + slack_) {
        take(Feature{Kind::CornerFace, i, axis.face_a, i, {f.normal, x - d * f.normal, x, d}});
        continue;
      }
    }
    Nearest to = nearest(a_, x, slack_);
    if (to.to == Nearest::To::Inside || to.to == Nearest::To::Face) {
      if (to.to == Nearest::To::Inside)  // by rounding it may be as near to the face beside it
        to.index = face_along(a_, x, deep, axis.normal);
      const Polytope::Face& f = a_.faces[at(to.index)];
      if (!clear(f.normal, flat)) continue;
      const double d = f.normal.dot(x) - f.offset;
      take(Feature{Kind::CornerFace, i, to.index, i, {f.normal, x - d * f.normal, x, d}});
      continue;
    }
    if (to.index < 0) continue;
    Vector3 n = x - to.foot;
    const bool edge = to.to == Nearest::To::Edge;
    if (to.distance > slack_)
      n /= to.distance;
    else if (a_.solid() || b_.solid())
      continue;
    else
      n = edge ? across(a_.edges[at(to.index)].along) : Vector3::UnitZ();
    if (clear(n, edgewise))
      take(Feature{
          edge ? Kind::CornerEdge : Kind::CornerCorner, i, to.index, i, {n, to.foot, x, to.distance}});
  }
}

template <class Take>
void PolytopePair::corners_of_a(const Placed& B, const Axis& axis, const std::vector<int>& on_face,
                                Take take) const {
  const double deep = 2 * (slack_ + std::max(-axis.distance, 0.0));
  for (int i = 0; i < corners_a_; ++i) {
    const Vector3 &x = a_.corners[at(i)], y = B.back(x);
    Nearest to = nearest(b_, y, slack_);
    if (axis.face_b >= 0 && axis.distance < 0) {
      const Polytope::Face& f = b_.faces[at(axis.face_b)];
      if (f.normal.dot(y) - f.offset <= axis.distance + slack_) to = {Nearest::To::Face, axis.face_b, y, 0};
    }
    if (to.to == Nearest::To::Corner) continue;  // B's corner has it
    if (to.to == Nearest::To::Edge) {
      if (!(to.distance > slack_)) continue;
      const Vector3 n = B.R * (to.foot - y) / to.distance;
      if (leaves(a_.spokes[at(i)], n, edgewise))
        take(Feature{Kind::EdgeCorner, corners_b_ + i, i, to.index, {n, x, B.point(to.foot), to.distance}});
      continue;
    }
    if (to.to == Nearest::To::Inside) to.index = face_along(b_, y, deep, -(B.R.transpose() * axis.normal));
    const Polytope::Face& f = b_.faces[at(to.index)];
    const Vector3 n = -(B.R * f.normal);
    if (!leaves(a_.spokes[at(i)], n, flat)) continue;
    const double d = f.normal.dot(y) - f.offset;
    const auto same = [&](int j) {  // flush: one of two corners that lie on each other is enough
      const Vector3 apart = b_.corners[at(j)] - y;
      return (apart - f.normal.dot(apart) * f.normal).norm() <= slack_;
    };
    if (std::any_of(on_face.begin(), on_face.end(), same)) continue;
    take(Feature{Kind::FaceCorner, corners_b_ + i, i, to.index, {n, x, x + d * n, d}});
  }
}

template <class Take>
void PolytopePair::features(const Pose& X_AB, Take take) const {
  const Placed B{b_, X_AB, X_AB.R()};
  Axis axis;
  static thread_local std::vector<Feature> crossings;
  edge_pairs(B, axis, crossings);
  face_axes(B, axis);
  for (const Feature& f : crossings)  // what overlaps on the far side of a solid does not
    if (f.witness.distance >= 0 || f.witness.normal.dot(axis.normal) > same_side) take(f);
  static thread_local std::vector<int> on_face;  // corners of B on faces of A
  on_face.clear();
  corners_of_b(B, axis, [&](const Feature& f) {
    if (f.kind == Kind::CornerFace) on_face.push_back(f.of_b);
    take(f);
  });
  corners_of_a(B, axis, on_face, take);
}

void PolytopePair::evaluate(const Pose& X_WA, const Pose& X_WB, std::span<ContactPoint> out) const {
  for (ContactPoint& c : out) c.gap = infinity;
  const Matrix3 R = X_WA.R();
  features(X_WA.inverse() * X_WB,
           [&](const Feature& f) { out[at(f.slot)] = f.witness.in(X_WA, R).contact(a_.radius, b_.radius); });
}

/// The derivative of a feature's witness, by what is fixed in each body.
MovingWitness PolytopePair::moving(const Feature& f, const Pose& X_WA, const Pose& X_WB) const {
  const FixedIn A{0, X_WA}, B{6, X_WB};
  const auto corner_a = [&](int i) { return A.point(X_WA * a_.corners[at(i)]); };
  const auto corner_b = [&](int i) { return B.point(X_WB * b_.corners[at(i)]); };
  const auto onto = [](const Moving& x, const Moving& from, const Moving& along) {
    return from + dot(along, x - from) * along;
  };
  switch (f.kind) {
    case Kind::CornerFace: {
      const Polytope::Face& face = a_.faces[at(f.of_a)];
      const Moving n = A.direction(X_WA.q * face.normal), b = corner_b(f.of_b);
      return {n, b - dot(n, b - A.point(X_WA * face.point)) * n, b};
    }
    case Kind::FaceCorner: {
      const Polytope::Face& face = b_.faces[at(f.of_b)];
      const Moving n = B.direction(-(X_WB.q * face.normal)), a = corner_a(f.of_a);
      return {n, a, a + dot(n, B.point(X_WB * face.point) - a) * n};
    }
    case Kind::CornerEdge: {
      const Polytope::Edge& edge = a_.edges[at(f.of_a)];
      const Moving b = corner_b(f.of_b), a = onto(b, corner_a(edge.from), A.direction(X_WA.q * edge.along));
      if (!(f.witness.distance > slack_)) return {A.direction(X_WA.q * f.witness.normal), a, b};
      return {unit(b - a), a, b};
    }
    case Kind::EdgeCorner: {
      const Polytope::Edge& edge = b_.edges[at(f.of_b)];
      const Moving a = corner_a(f.of_a), b = onto(a, corner_b(edge.from), B.direction(X_WB.q * edge.along));
      return {unit(b - a), a, b};
    }
    case Kind::CornerCorner: {
      const Moving a = corner_a(f.of_a), b = corner_b(f.of_b);
      if (!(f.witness.distance > slack_)) return {A.direction(X_WA.q * f.witness.normal), a, b};
      return {unit(b - a), a, b};
    }
    case Kind::EdgeEdge:
      break;
  }
  const Polytope::Edge &edge_a = a_.edges[at(f.of_a)], &edge_b = b_.edges[at(f.of_b)];
  const Moving e_a = A.direction(X_WA.q * edge_a.along), e_b = B.direction(X_WB.q * edge_b.along);
  Moving n = unit(cross(e_a, e_b));
  if (n.x.dot(X_WA.q * f.witness.normal) < 0) n = -1.0 * n;
  // a = a0 + t e_a, b = b0 + u e_b with b - a along n: t = (b0 - a0) . e_b x n / (e_a . e_b x n), u likewise
  const Moving a0 = corner_a(edge_a.from), b0 = corner_b(edge_b.from), d = b0 - a0;
  const Moving by_b = cross(e_b, n), by_a = cross(e_a, n);
  const auto quotient = [](const MovingNumber& p, const MovingNumber& q) {
    return MovingNumber{p.x / q.x, (p.d - p.x / q.x * q.d) / q.x};
  };
  const MovingNumber t = quotient(dot(d, by_b), dot(e_a, by_b)),
                     u = quotient(dot(-1.0 * d, by_a), dot(e_b, by_a));
  return {n, a0 + t * e_a, b0 + u * e_b};
}

void PolytopePair::differentiate(const Pose& X_WA, const Pose& X_WB, std::span<ContactDerivative> out) const {
  features(X_WA.inverse() * X_WB,
           [&](const Feature& f) { moving(f, X_WA, X_WB).contact(a_.radius, b_.radius, out[at(f.slot)]); });
}

}  // namespace perp
