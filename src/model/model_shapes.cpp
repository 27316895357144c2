// Bodies that have shapes, and the contacts that this makes.
#include <algorithm>
#include <cmath>

#include "core/index.hpp"
#include "model/pairs/shape_geometry.hpp"
#include "perp/core/errors.hpp"
#include "perp/model/model.hpp"
#include "perp/model/shapes_in_reach.hpp"

namespace perp {
namespace {

bool can_move(BodyKind kind) { return kind != BodyKind::Ground && kind != BodyKind::Prescribed; }

template <class T>
std::pair<T, T> ascending(const T& a, const T& b) {
  return b < a ? std::pair(b, a) : std::pair(a, b);
}

void need_fit(const Body& body, const Shape& shape, const ShapeOptions& options) {
  if (body.kind == BodyKind::Generalized)
    refuse("add_shape", "body", body.name, "a generalized body has no pose to carry a shape");
  if (body.kind == BodyKind::Particle && shape.kind() != Shape::Kind::Sphere)
    refuse("add_shape", "body", body.name, "a particle has no orientation: only a sphere fits");
  if (body.kind == BodyKind::Particle && !options.pose.p.isZero(0))
    refuse("add_shape", "position", "away from the origin", "a particle's sphere is about it");
  if (can_move(body.kind) && (body.kind == BodyKind::Planar) != shape.planar())
    refuse("add_shape", "kind", shape.name(),
           shape.planar() ? "a spatial body needs a spatial shape" : "a planar body needs a planar shape");
  const double norm = options.pose.q.norm();
  if (!options.pose.p.allFinite() || !(norm > 0) || !std::isfinite(norm))
    refuse("add_shape", "position", "not finite", "needs finite entries");
}

/// Whether pairs have the same features with the two, whatever their sizes.
bool alike(const ShapeGeometry& a, const ShapeGeometry& b) {
  const auto features = [](const ShapeGeometry& g) {
    return g.polytope ? std::pair(g.polytope->corners.size(), g.polytope->edges.size()) : std::pair(0UL, 0UL);
  };
  return a.kind == b.kind && features(a) == features(b);
}

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

ShapeId Model::add_shape(BodyId id, const Shape& shape, ShapeOptions options) {
  if (id.index < 0 || at(id.index) >= bodies_.size())
    refuse("add_shape", "body", id.index, "is not of this model");
  need_fit(body(id), shape, options);
  const auto taken = [&](const std::string& name) {
    return std::any_of(shapes_.begin(), shapes_.end(),
                       [&](const BodyShape& s) { return s.body == id && s.name == name; });
  };
  if (options.name.empty()) {
    options.name = shape.name();
    for (int k = 2; taken(options.name); ++k)
      options.name = std::string(shape.name()) + "-" + std::to_string(k);
  }
  if (taken(options.name))
    refuse("add_shape", "name", options.name, "is taken already on '" + body(id).name + "'");
  options.pose.q = unit(options.pose.q);
  const auto material = std::find(material_names_.begin(), material_names_.end(), options.material);
  BodyShape added{id,
                  shape,
                  options.pose,
                  std::move(options.material),
                  std::move(options.name),
                  static_cast<int>(material - material_names_.begin()),
                  std::make_shared<const ShapeGeometry>(shape, options.pose)};
  const bool new_material = material == material_names_.end();
  pairs_.add(most_points(added));
  if (new_material) material_names_.push_back(added.material);
  if (point_names_.use_count() > 1) point_names_ = std::make_shared<PointNames>(*point_names_);
  point_names_->shapes_.push_back({body(id).name + "." + added.name, id.index, added.geometry});
  point_names_->pairs_ = pairs_;
  const ShapeId last{static_cast<int>(shapes_.size())};
  const auto same_kind = [&](int i) { return alike(*shapes_[at(i)].geometry, *added.geometry); };
  if (std::none_of(kinds_of_shape_.begin(), kinds_of_shape_.end(), same_kind))
    kinds_of_shape_.push_back(last.index);
  shapes_.push_back(std::move(added));
  if (new_material) make_laws();
  for (int i = 0; few_pairs() && i < last.index; ++i)
    if (may_touch({i}, last)) touching_pairs_.push_back(PairNumbers::pair(i, last.index));
  changed();
  return last;
}

/// Of the pairs of a new shape with those that are there; refuses one without a gap that may touch it.
int Model::most_points(const BodyShape& added) const {
  int most = 0;
  for (const int kind : kinds_of_shape_) {
    const ShapeGeometry& other = *shapes_[at(kind)].geometry;
    if (shapes_[at(kind)].shape.planar() != added.shape.planar()) continue;
    const ShapePair pair(other, *added.geometry);
    if (pair.known()) {
      most = std::max(most, pair.points());
      continue;
    }
    for (const BodyShape& s : shapes_) {
      const bool one_moves = can_move(body(s.body).kind) || can_move(body(added.body).kind);
      const std::pair bodies = ascending(s.body.index, added.body.index);
      if (!alike(*s.geometry, other) || s.body == added.body || !one_moves || joined_.contains(bodies) ||
          bodies_apart_.contains(bodies))
        continue;
      refuse("add_shape", "kind", std::string(added.shape.name()) + " on '" + body(added.body).name + "'",
             "has no gap to the " + std::string(s.shape.name()) + " on '" + body(s.body).name +
                 "': perp knows none for such a pair; no_contact of the two bodies allows it");
    }
  }
  return most;
}

bool Model::may_touch(ShapeId a, ShapeId b) const {
  const BodyShape &first = shapes_[at(a.index)], &second = shapes_[at(b.index)];
  if (first.body == second.body || first.shape.planar() != second.shape.planar()) return false;
  if (!can_move(body(first.body).kind) && !can_move(body(second.body).kind)) return false;
  const std::pair bodies = ascending(first.body.index, second.body.index);
  return !joined_.contains(bodies) && !bodies_apart_.contains(bodies) &&
         !shapes_apart_.contains(ascending(a.index, b.index));
}

ContactView Model::contact(int number) const {
  const int listed = static_cast<int>(contacts_.size());
  if (number < listed) {
    const Contact& c = contacts_[at(number)];
    return {c, c.a, c.b, GapRef(c.gap), c.first_point};
  }
  const PairNumbers::Pair pair = PairNumbers::pair(number - listed);
  const BodyShape *a = &shapes_[at(pair.i)], *b = &shapes_[at(pair.j)];
  if (b->body.index < a->body.index) std::swap(a, b);
  const std::size_t law = 2 * (at(a->material_number) * material_names_.size() + at(b->material_number));
  return {laws_[law + (a->shape.planar() ? 0 : 1)], a->body, b->body, GapRef(*a->geometry, *b->geometry),
          points_ + pairs_.first_point(pair)};
}

int Model::contact_of_point(int point) const {
  if (point >= points_) {
    const PairNumbers::Pair pair = pairs_.pair_of_point(point - points_);
    return contact_of({pair.i}, {pair.j});
  }
  const auto after = std::upper_bound(contacts_.begin(), contacts_.end(), point,
                                      [](int p, const Contact& c) { return p < c.first_point; });
  return static_cast<int>(after - contacts_.begin()) - 1;
}

std::string Model::contact_name(int number) const {
  const int listed = static_cast<int>(contacts_.size());
  return number < listed ? contacts_[at(number)].name
                         : point_names_->pair_name(PairNumbers::pair(number - listed));
}

/// What each two materials do to each other.
void Model::make_laws() {
  laws_.clear();
  law_with_moments_ = -1;
  for (const std::string& a : material_names_)
    for (const std::string& b : material_names_) {
      const auto known = materials_.find(ascending(a, b));
      const MaterialPair law = known == materials_.end() ? MaterialPair{} : known->second;
      for (const int tangents : {1, 2}) {  // in the plane nothing turns about the normal
        const double torsion = tangents == 1 ? 0 : law.torsion;
        const bool rubs = law.mu > 0 || torsion > 0 || law.rolling > 0;
        laws_.push_back({.name = a + "|" + b,
                         .a = {},
                         .b = {},
                         .gap = Gap([](const Pose&, const Pose&, double) { return ContactPoint{}; }),
                         .mu = law.mu,
                         .torsion = torsion,
                         .rolling = law.rolling,
                         .e = law.e,
                         .tangent = Vector3::Zero(),
                         .tangents = rubs ? tangents : 0});
        if (laws_.back().has_ellipse() && law_with_moments_ < 0)
          law_with_moments_ = static_cast<int>(laws_.size()) - 1;
      }
    }
}

void Model::set_friction(const std::string& a, const std::string& b, const MaterialPair& pair) {
  if (!(pair.mu >= 0) || !std::isfinite(pair.mu))
    refuse("set_friction", "mu", pair.mu, "needs to be >= 0 and finite");
  if (!(pair.e >= 0 && pair.e <= 1)) refuse("set_friction", "e", pair.e, "needs to be in [0, 1]");
  if (!(pair.torsion >= 0) || !std::isfinite(pair.torsion))
    refuse("set_friction", "torsion", pair.torsion, "needs to be >= 0 and finite [m]");
  if (!(pair.rolling >= 0) || !std::isfinite(pair.rolling))
    refuse("set_friction", "rolling", pair.rolling, "needs to be >= 0 and finite [m]");
  materials_[ascending(a, b)] = pair;
  make_laws();
  changed();
}

void Model::no_contact(BodyId a, BodyId b) {
  for (const auto& [argument, id] : {std::pair("a", a), std::pair("b", b)})
    if (id.index < 0 || at(id.index) >= bodies_.size())
      refuse("no_contact", argument, id.index, "is not of this model");
  bodies_apart_.insert(ascending(a.index, b.index));
  apart_changed();
}

void Model::no_contact(ShapeId a, ShapeId b) {
  for (const auto& [argument, id] : {std::pair("a", a), std::pair("b", b)})
    if (id.index < 0 || at(id.index) >= shapes_.size())
      refuse("no_contact", argument, id.index, "is not of this model");
  shapes_apart_.insert(ascending(a.index, b.index));
  apart_changed();
}

/// After fewer may touch than before.
void Model::apart_changed() {
  std::erase_if(touching_pairs_, [&](int number) {
    const PairNumbers::Pair pair = PairNumbers::pair(number);
    return !may_touch({pair.i}, {pair.j});
  });
  changed();
}

std::vector<std::string> Model::leave_out_overlapping(const State& x) {
  check("leave_out_overlapping", x);
  constexpr double rounding = 1e-9;  // of the smaller shape: poses that were typed with ten digits or more
  std::vector<Pose> X;
  for (int i = 0; i < static_cast<int>(bodies_.size()); ++i) X.push_back(pose(x, {i}));
  std::vector<std::string> names;
  std::vector<ContactPoint> points;
  ShapesInReach near;
  for (const int number : near.find(*this, X, 0)) {
    const PairNumbers::Pair pair = PairNumbers::pair(number - static_cast<int>(contacts_.size()));
    const ContactView contact = this->contact(number);
    points.resize(at(contact.gap.points()));
    contact.gap(X[at(contact.a.index)], X[at(contact.b.index)], x.t, points);
    const double allowed =
        rounding * std::min(shapes_[at(pair.i)].shape.reach(), shapes_[at(pair.j)].shape.reach());
    if (std::none_of(points.begin(), points.end(), [&](const ContactPoint& p) { return p.gap < -allowed; }))
      continue;
    shapes_apart_.emplace(pair.i, pair.j);
    names.push_back(contact_name(number));
  }
  apart_changed();
  return names;
}

ShapeId Model::find_shape(BodyId body, std::string_view name) const {
  std::string known;
  for (int i = 0; i < static_cast<int>(shapes_.size()); ++i) {
    if (shapes_[at(i)].body != body) continue;
    if (shapes_[at(i)].name == name) return {i};
    known += (known.empty() ? "" : ", ") + shapes_[at(i)].name;
  }
  refuse("find_shape", "name", std::string(name),
         known.empty() ? "the body has no shapes" : "needs to be one of: " + known);
}

}  // namespace perp
