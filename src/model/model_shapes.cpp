// Bodies that have shapes: where they may touch.
#include <algorithm>
#include <cmath>

#include "perp/core/errors.hpp"
#include "perp/model/model.hpp"

namespace perp {
namespace {

std::size_t at(int i) { return static_cast<std::size_t>(i); }

bool moves(BodyKind kind) { return kind != BodyKind::Ground && kind != BodyKind::Prescribed; }

std::pair<int, int> ascending(BodyId a, BodyId b) { return std::minmax(a.index, b.index); }

}  // namespace

BodyId Model::add_body(const Shape& shape, ShapeBodyOptions options) {
  MassProperties mass;
  mass.add(shape, {}, options.density);
  BodyOptions body{.pose = options.pose, .name = std::move(options.name)};
  const BodyId id = shape.planar() ? add_planar_body(mass.mass, mass.J(2, 2), std::move(body))
                                   : add_body(Inertia(mass.mass, mass.J), std::move(body));
  add_shape(id, shape, {.pose = {}, .material = std::move(options.material), .name = {}});
  return id;
}

void Model::add_shape(BodyId id, const Shape& shape, ShapeOptions options) {
  if (id.index < 0 || at(id.index) >= bodies_.size())
    refuse("add_shape", "body", id.index, "is not of this model");
  const BodyKind kind = body(id).kind;
  if (kind == BodyKind::Generalized)
    refuse("add_shape", "body", body(id).name, "a generalized body has no pose to carry a shape");
  if (kind == BodyKind::Particle && shape.kind() != Shape::Kind::Sphere)
    refuse("add_shape", "body", body(id).name, "a particle has no orientation: only a sphere fits");
  if ((kind == BodyKind::Planar) != shape.planar() && moves(kind))
    refuse("add_shape", "shape", shape.name(), kind == BodyKind::Planar ? "a planar body needs a planar shape" : "a spatial body needs a spatial shape");
  const double norm = options.pose.q.norm();
  if (!options.pose.p.allFinite() || !(norm > 0) || !std::isfinite(norm))
    refuse("add_shape", "pose", "not finite", "needs finite entries");
  if (kind == BodyKind::Particle && !options.pose.p.isZero(0))
    refuse("add_shape", "pose", "away from the origin", "a particle's sphere is about it");
  options.pose.q = unit(options.pose.q);
  const auto taken = [&](const std::string& name) {
    return std::any_of(shapes_.begin(), shapes_.end(),
                       [&](const BodyShape& s) { return s.body == id && s.name == name; });
  };
  if (options.name.empty()) {
    options.name = shape.name();
    for (int k = 2; taken(options.name); ++k) options.name = std::string(shape.name()) + "-" + std::to_string(k);
  }
  if (taken(options.name)) refuse("add_shape", "name", options.name, "is taken already on '" + body(id).name + "'");
  BodyShape added{id, shape, options.pose, std::move(options.material), std::move(options.name)};
  for (const BodyShape& other : shapes_)  // a pair without a gap is refused before anything is added
    if (other.body != id && (moves(kind) || moves(body(other.body).kind)) && other.shape.planar() == shape.planar() &&
        !apart_.contains(ascending(other.body, id)))
      (void)gap_between(other.shape, shape, other.pose, added.pose);
  shapes_.push_back(std::move(added));
  const int last = static_cast<int>(shapes_.size()) - 1;
  for (int i = 0; i < last; ++i) add_found(i, last);
  changed();
}

/// The contact of two shapes, on the body of lower number first; none where it could never be.
void Model::add_found(int first, int second) {
  if (shapes_[at(second)].body.index < shapes_[at(first)].body.index) std::swap(first, second);
  const BodyShape &a = shapes_[at(first)], &b = shapes_[at(second)];
  const BodyKind kind_a = body(a.body).kind, kind_b = body(b.body).kind;
  if (a.body == b.body || (!moves(kind_a) && !moves(kind_b)) || a.shape.planar() != b.shape.planar()) return;
  if (apart_.contains(ascending(a.body, b.body))) return;
  const MaterialPair how = pair_of(a.material, b.material);
  Contact contact{.name = body(a.body).name + "." + a.name + "|" + body(b.body).name + "." + b.name,
                  .a = a.body,
                  .b = b.body,
                  .gap = gap_between(a.shape, b.shape, a.pose, b.pose),
                  .mu = how.mu,
                  .e = how.e,
                  .tangent = Vector3::Zero(),
                  .first_point = points_};
  contact.tangents = how.mu == 0 ? 0 : a.shape.planar() ? 1 : 2;
  contact.shape_a = first;
  contact.shape_b = second;
  if (!contact_names_.insert(contact.name).second) refuse("add_shape", "name", contact.name, "is taken already");
  add(std::move(contact));
}

MaterialPair Model::pair_of(const std::string& a, const std::string& b) const {
  const auto known = materials_.find(std::minmax(a, b));
  return known == materials_.end() ? MaterialPair{} : known->second;
}

void Model::set_friction(const std::string& a, const std::string& b, const MaterialPair& pair) {
  if (!(pair.mu >= 0) || !std::isfinite(pair.mu))
    refuse("set_friction", "mu", pair.mu, "needs to be >= 0 and finite");
  if (!(pair.e >= 0 && pair.e <= 1)) refuse("set_friction", "e", pair.e, "needs to be in [0, 1]");
  if (pair.torsion != 0) refuse("set_friction", "torsion", pair.torsion, "is not known yet: needs to be 0");
  if (pair.rolling != 0) refuse("set_friction", "rolling", pair.rolling, "is not known yet: needs to be 0");
  materials_[std::minmax(a, b)] = pair;
  for (Contact& c : contacts_) {
    if (c.shape_a < 0) continue;
    const std::string &first = shapes_[at(c.shape_a)].material, &second = shapes_[at(c.shape_b)].material;
    if (std::minmax(first, second) != std::minmax(a, b)) continue;
    c.mu = pair.mu;
    c.e = pair.e;
    c.tangents = c.mu == 0 ? 0 : shapes_[at(c.shape_a)].shape.planar() ? 1 : 2;
  }
  changed();
}

void Model::no_contact(BodyId a, BodyId b) {
  for (const BodyId id : {a, b})
    if (id.index < 0 || at(id.index) >= bodies_.size())
      refuse("no_contact", "body", id.index, "is not of this model");
  apart_.insert(ascending(a, b));
  for (Contact& c : contacts_)
    if (c.shape_a >= 0 && ascending(c.a, c.b) == ascending(a, b)) c.off = true;
  changed();
}

std::vector<std::string> Model::leave_out_overlapping(const State& x) {
  check("leave_out_overlapping", x);
  std::vector<std::string> names;
  std::vector<ContactPoint> points;
  for (Contact& c : contacts_) {
    if (c.shape_a < 0 || c.off) continue;
    points.resize(at(c.gap.points()));
    c.gap(pose(x, c.a), pose(x, c.b), x.t, points);
    const double rounding = 1e-9 * std::min(shapes_[at(c.shape_a)].shape.reach(), shapes_[at(c.shape_b)].shape.reach());
    if (std::none_of(points.begin(), points.end(), [&](const ContactPoint& p) { return p.gap < -rounding; })) continue;
    c.off = true;
    names.push_back(c.name);
  }
  changed();
  return names;
}

}  // namespace perp
