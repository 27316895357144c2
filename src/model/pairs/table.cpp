// Which pair of shapes meets how.
#include <algorithm>

#include "model/gap_maker.hpp"
#include "model/pairs/in_hollow.hpp"
#include "model/pairs/point_on_surface.hpp"
#include "model/pairs/polytope_pair.hpp"
#include "model/pairs/shape_geometry.hpp"

namespace perp {
namespace {

using Of = Shape::Kind;

constexpr double pi = 3.14159265358979323846;

/// Shapes of flat faces, corners and edges, blown up by a radius.
std::optional<Polytope> polytope_of(const Shape& shape) {
  const std::vector<double>& s = shape.sizes();
  switch (shape.kind()) {
    case Of::Sphere:
    case Of::PlanarDisc:
      return Polytope::point(s[0]);
    case Of::HalfSpace:
      return Polytope::half_space();
    case Of::Line:
      return Polytope::half_space().moved({Vector3::Zero(), rotation({-0.5 * pi, 0, 0})});
    case Of::Box:
      return Polytope::box({s[0], s[1], s[2]});
    case Of::Capsule:
      return Polytope::segment(s[1], s[0]);
    case Of::Polyhedron:
      return Polytope::polyhedron(shape.vertices(), shape.faces());
    case Of::PlanarBox:
      return Polytope::polygon(
          {{-s[0] / 2, -s[1] / 2}, {s[0] / 2, -s[1] / 2}, {s[0] / 2, s[1] / 2}, {-s[0] / 2, s[1] / 2}});
    case Of::Polygon: {
      std::vector<Vector2> corners;
      for (const Vector3& x : shape.vertices()) corners.push_back(x.head<2>());
      return Polytope::polygon(corners);
    }
    default:
      return std::nullopt;
  }
}

bool is_flat(Of kind) { return kind == Of::HalfSpace || kind == Of::Line; }
bool is_oval(Of kind) { return kind == Of::Ellipsoid || kind == Of::Superquadric || kind == Of::Ellipse; }
bool is_hollow(Of kind) { return kind == Of::HollowSphere || kind == Of::HollowCylinder; }

/// Of points between bodies that have changed places.
void exchange(ContactPoint& c) { c.normal = -c.normal; }

void exchange(ContactDerivative& d) {
  d.normal = -d.normal;
  for (Columns* c : {&d.normal, &d.point}) {
    const Eigen::Matrix<double, 3, 6> first = c->leftCols<6>();
    c->leftCols<6>() = c->rightCols<6>().eval();
    c->rightCols<6>() = first;
  }
}

}  // namespace

ShapeGeometry::ShapeGeometry(const Shape& shape, const Pose& X_BS)
    : kind(shape.kind()),
      name(shape.name()),
      place{X_BS.p, unit(X_BS.q)},
      reach(shape.reach()),
      lever(place.p.norm() + reach) {
  const std::vector<double>& s = shape.sizes();
  polytope = polytope_of(shape);
  if (polytope) {
    polytope = polytope->moved(place);
    lever = polytope->reach();
  }
  if (is_hollow(kind)) radius = s[0];
  if (kind == Of::HollowSphere) lever = place.p.norm();
  if (is_flat(kind))
    plane = Plane{place.q * (kind == Of::Line ? Vector3::UnitY() : Vector3::UnitZ()), place.p};
  if (kind == Of::Sphere || kind == Of::PlanarDisc) smooth = SmoothSolid::sphere(s[0], place);
  if (kind == Of::Ellipsoid) smooth = SmoothSolid::ellipsoid({s[0], s[1], s[2]}, place);
  if (kind == Of::Ellipse)  // thick enough across its plane for the shortest way out to be within it
    smooth = SmoothSolid::ellipsoid({s[0], s[1], s[0] + s[1]}, place);
  if (kind == Of::Superquadric)
    smooth = SmoothSolid::make_superquadric({s[0], s[1], s[2]}, {s[3], s[4]}, place);
  if (kind == Of::Formula) surface = std::make_shared<const ImplicitSurface>(shape.surface());
  if (kind == Of::Disc) rims.emplace(std::vector<Vector3>{Vector3::Zero()}, s[0], place);
  if (kind == Of::Cylinder) {
    const Vector3 half(0, 0, s[1] / 2);
    rims.emplace(std::vector<Vector3>{-half, half}, s[0], place);
  }
}

ShapePair::Kind ShapePair::kind_of(const ShapeGeometry& a, const ShapeGeometry& b) {
  const bool corners = b.polytope && !b.polytope->corners.empty();
  if (is_hollow(a.kind)) return corners ? Kind::InHollow : Kind::None;
  if (a.plane && b.rims) return Kind::RimsOnPlane;
  if (a.surface) return b.kind == Of::Sphere ? Kind::PointOnSurface : Kind::None;
  if (a.plane && is_oval(b.kind)) return Kind::SmoothOnPlane;
  if (is_oval(a.kind)) return b.smooth ? Kind::Smooth : Kind::None;
  return a.polytope && corners ? Kind::Polytopes : Kind::None;
}

ShapePair::ShapePair(const ShapeGeometry& a, const ShapeGeometry& b) : a_(a), b_(b), kind_(kind_of(a, b)) {
  if (known()) return;
  kind_ = kind_of(b, a);
  exchanged_ = true;
}

template <class Use>
auto ShapePair::with(Use use) const {
  const ShapeGeometry &a = exchanged_ ? b_ : a_, &b = exchanged_ ? a_ : b_;
  switch (kind_) {
    case Kind::InHollow:
      return use(InHollow(a.radius, a.kind == Of::HollowCylinder, a.place, *b.polytope));
    case Kind::RimsOnPlane:
      return use(RimsOnPlane(*b.rims, *a.plane));
    case Kind::SmoothOnPlane:
      return use(SmoothOnPlane(*a.plane, *b.smooth));
    case Kind::PointOnSurface:
      return use(PointOnSurface(*a.surface, a.place, b.smooth->centre, b.smooth->radius));
    case Kind::Smooth:
      return use(SmoothPair(*a.smooth, *b.smooth));
    default:
      return use(PolytopePair(&*a.polytope, &*b.polytope));
  }
}

int ShapePair::points() const {
  return with([](const auto& pair) { return pair.points(); });
}

void ShapePair::evaluate(const Pose& X_WA, const Pose& X_WB, std::span<ContactPoint> out) const {
  const Pose &first = exchanged_ ? X_WB : X_WA, &second = exchanged_ ? X_WA : X_WB;
  with([&](const auto& pair) { pair.evaluate(first, second, out); });
  if (exchanged_)
    for (ContactPoint& c : out) exchange(c);
}

void ShapePair::differentiate(const Pose& X_WA, const Pose& X_WB, std::span<ContactDerivative> out) const {
  const Pose &first = exchanged_ ? X_WB : X_WA, &second = exchanged_ ? X_WA : X_WB;
  with([&](const auto& pair) { pair.differentiate(first, second, out); });
  if (exchanged_)
    for (ContactDerivative& d : out) exchange(d);
}

double ShapePair::at_least(const Pose& X_WA, const Pose& X_WB) const {
  const ShapeGeometry &a = exchanged_ ? b_ : a_, &b = exchanged_ ? a_ : b_;
  const Pose &X_A = exchanged_ ? X_WB : X_WA, &X_B = exchanged_ ? X_WA : X_WB;
  const Vector3 d = X_B * b.place.p - X_A * a.place.p;
  if (a.plane) return (X_A.q * a.plane->normal).dot(d) - b.reach;
  if (is_hollow(a.kind)) return a.radius - d.norm() - b.reach;  // of a cylinder less than it may be
  if (a.surface) return -infinity;
  return d.norm() - a.reach - b.reach;
}

Gap gap_between(const Shape& a, const Shape& b, const Pose& X_AS, const Pose& X_BS) {
  if (a.planar() != b.planar())
    refuse("gap_between", "shapes", std::string(a.name()) + " and " + std::string(b.name()),
           "need to be both planar or both spatial");
  const auto first = std::make_shared<const ShapeGeometry>(a, X_AS),
             second = std::make_shared<const ShapeGeometry>(b, X_BS);
  const ShapePair pair(*first, *second);
  if (!pair.known())
    refuse("gap_between", "shapes", std::string(a.name()) + " and " + std::string(b.name()),
           "are a pair that perp has no gap for");
  Gap gap = Gap::patch(pair.points(), [first, second](const Pose& X_WA, const Pose& X_WB, double,
                                                      std::span<ContactPoint> out) {
    ShapePair(*first, *second).evaluate(X_WA, X_WB, out);
  });
  gap.differentiated_by(
      [first, second](const Pose& X_WA, const Pose& X_WB, double, std::span<ContactDerivative> out) {
        ShapePair(*first, *second).differentiate(X_WA, X_WB, out);
      });
  return gap.levers(pair.lever_a(), pair.lever_b());
}

}  // namespace perp
