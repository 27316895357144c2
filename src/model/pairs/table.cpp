// Which pair of shapes meets how.
#include "model/gap_maker.hpp"
#include "model/pairs/in_hollow.hpp"
#include "model/pairs/polytope_pair.hpp"
#include "model/pairs/round_on_plane.hpp"
#include "perp/model/shape.hpp"

namespace perp {
namespace {

using Kind = Shape::Kind;

/// Shapes of flat faces, corners and edges, blown up by a radius.
std::optional<Polytope> polytope_of(const Shape& shape, const Pose& X) {
  const std::vector<double>& s = shape.sizes();
  const auto made = [&]() -> std::optional<Polytope> {
    switch (shape.kind()) {
      case Kind::Sphere:
      case Kind::PlanarDisc:
        return Polytope::point(s[0]);
      case Kind::HalfSpace:
        return Polytope::half_space();
      case Kind::Line:
        return Polytope::half_space().moved({Vector3::Zero(), rotation({-0.5 * 3.14159265358979323846, 0, 0})});
      case Kind::Box:
        return Polytope::box({s[0], s[1], s[2]});
      case Kind::Capsule:
        return Polytope::segment(s[1], s[0]);
      case Kind::Polyhedron:
        return Polytope::polyhedron(shape.vertices(), shape.faces());
      case Kind::PlanarBox:
        return Polytope::polygon({{-s[0] / 2, -s[1] / 2}, {s[0] / 2, -s[1] / 2}, {s[0] / 2, s[1] / 2}, {-s[0] / 2, s[1] / 2}});
      case Kind::Polygon: {
        std::vector<Vector2> corners;
        for (const Vector3& x : shape.vertices()) corners.push_back(x.head<2>());
        return Polytope::polygon(corners);
      }
      default:
        return std::nullopt;
    }
  }();
  if (!made) return made;
  return made->moved(X);
}

template <class Pair>
Gap named_gap(Pair made) {
  const auto pair = std::make_shared<const Pair>(made);
  Gap gap = gap_of_pair({}, std::move(made), {});
  return gap.named_by([pair](int point) { return pair->feature(point); });
}

std::optional<Gap> gap_in_order(const Shape& a, const Shape& b, const Pose& X_AS, const Pose& X_BS) {
  const std::vector<double>&s = a.sizes(), &t = b.sizes();
  const bool flat = a.kind() == Kind::HalfSpace || a.kind() == Kind::Line;
  const std::optional<Polytope> second = polytope_of(b, X_BS);
  if (a.kind() == Kind::HollowSphere || a.kind() == Kind::HollowCylinder) {
    if (!second || second->corners.empty()) return {};
    return named_gap(InHollow(s[0], a.kind() == Kind::HollowCylinder, X_AS, *second));
  }
  if (flat) {
    const Plane plane{X_AS.q * (a.kind() == Kind::Line ? Vector3::UnitY() : Vector3::UnitZ()), X_AS.p};
    const Vector3 half(0, 0, b.kind() == Kind::Cylinder ? t[1] / 2 : 0);
    if (b.kind() == Kind::Disc) return named_gap(RimsOnPlane({half}, t[0], plane, X_BS));
    if (b.kind() == Kind::Cylinder) return named_gap(RimsOnPlane({-half, half}, t[0], plane, X_BS));
    if (b.kind() == Kind::Ellipsoid) return named_gap(EllipsoidOnPlane({t[0], t[1], t[2]}, plane, X_BS));
  }
  const std::optional<Polytope> first = polytope_of(a, X_AS);
  if (!first || !second || second->corners.empty()) return {};
  return named_gap(PolytopePair(*first, *second));
}

/// The same gap with its bodies' roles exchanged.
Gap exchanged(const Gap& gap) {
  const auto swap_columns = [](Columns& c) {
    const Eigen::Matrix<double, 3, 6> first = c.leftCols<6>();
    c.leftCols<6>() = c.rightCols<6>().eval();
    c.rightCols<6>() = first;
  };
  Gap other = Gap::patch(gap.points(), [gap](const Pose& X_WA, const Pose& X_WB, double t,
                                             std::span<ContactPoint> out) {
    gap(X_WB, X_WA, t, out);
    for (ContactPoint& c : out) c.normal = -c.normal;
  });
  other.differentiated_by([gap, swap_columns](const Pose& X_WA, const Pose& X_WB, double t,
                                              std::span<ContactDerivative> out) {
    gap.differentiate(X_WB, X_WA, t, out);
    for (ContactDerivative& d : out) {
      d.normal = -d.normal;
      swap_columns(d.normal);
      swap_columns(d.point);
    }
  });
  other.levers(gap.lever_b(), gap.lever_a());
  return other.named_by([gap](int point) { return gap.point_name(point); });
}

}  // namespace

Gap gap_between(const Shape& a, const Shape& b, const Pose& X_AS, const Pose& X_BS) {
  if (a.planar() != b.planar())
    refuse("gap_between", "shapes", std::string(a.name()) + " and " + std::string(b.name()), "need to be both planar or both spatial");
  const Pose in_a{X_AS.p, unit(X_AS.q)}, in_b{X_BS.p, unit(X_BS.q)};
  if (std::optional<Gap> gap = gap_in_order(a, b, in_a, in_b)) return *std::move(gap);
  if (std::optional<Gap> gap = gap_in_order(b, a, in_b, in_a)) return exchanged(*gap);
  refuse("gap_between", "shapes", std::string(a.name()) + " and " + std::string(b.name()), "are a pair that perp has no gap for");
}

}  // namespace perp
