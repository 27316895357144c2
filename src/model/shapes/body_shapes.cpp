#include "perp/model/body_shapes.hpp"

#include <algorithm>
#include <cmath>

#include "core/index.hpp"
#include "perp/core/errors.hpp"

namespace perp {
namespace {

bool moves(BodyKind kind) { return kind != BodyKind::Ground && kind != BodyKind::Prescribed; }

template <class T>
std::pair<T, T> ascending(const T& a, const T& b) {
  return b < a ? std::pair(b, a) : std::pair(a, b);
}

bool joined(const Model& model, BodyId a, BodyId b) {
  return std::any_of(model.joints().begin(), model.joints().end(), [&](const JointGeometry& j) {
    return ascending(j.a.index, j.b.index) == ascending(a.index, b.index);
  });
}

void need_fit(const Body& body, const Shape& shape, const ShapeOptions& options) {
  if (body.kind == BodyKind::Generalized)
    refuse("shape", "body", body.name, "a generalized body has no pose to carry a shape");
  if (body.kind == BodyKind::Particle && shape.kind() != Shape::Kind::Sphere)
    refuse("shape", "body", body.name, "a particle has no orientation: only a sphere fits");
  if (body.kind == BodyKind::Particle && !options.pose.p.isZero(0))
    refuse("shape", "position", "away from the origin", "a particle's sphere is about it");
  if (moves(body.kind) && (body.kind == BodyKind::Planar) != shape.planar())
    refuse("shape", "kind", shape.name(),
           shape.planar() ? "a spatial body needs a spatial shape" : "a planar body needs a planar shape");
  const double norm = options.pose.q.norm();
  if (!options.pose.p.allFinite() || !(norm > 0) || !std::isfinite(norm))
    refuse("shape", "position", "not finite", "needs finite entries");
}

}  // namespace

void BodyShapes::add(const Model& model, BodyId id, const Shape& shape, ShapeOptions options) {
  if (id.index < 0 || at(id.index) >= model.bodies().size())
    refuse("shape", "body", id.index, "is not of this model");
  need_fit(model.body(id), shape, options);
  const auto taken = [&](const std::string& name) {
    return std::any_of(shapes_.begin(), shapes_.end(),
                       [&](const Placed& s) { return s.body == id && s.name == name; });
  };
  if (options.name.empty()) {
    options.name = shape.name();
    for (int k = 2; taken(options.name); ++k)
      options.name = std::string(shape.name()) + "-" + std::to_string(k);
  }
  if (taken(options.name))
    refuse("shape", "name", options.name, "is taken already on '" + model.body(id).name + "'");
  options.pose.q = unit(options.pose.q);
  shapes_.push_back({id, shape, options.pose, std::move(options.material), std::move(options.name)});
}

void BodyShapes::set_friction(const std::string& a, const std::string& b, const MaterialPair& pair) {
  if (!(pair.mu >= 0) || !std::isfinite(pair.mu))
    refuse("set_friction", "mu", pair.mu, "needs to be >= 0 and finite");
  if (!(pair.e >= 0 && pair.e <= 1)) refuse("set_friction", "e", pair.e, "needs to be in [0, 1]");
  if (!(pair.torsion >= 0) || !std::isfinite(pair.torsion))
    refuse("set_friction", "torsion", pair.torsion, "needs to be >= 0 and finite [m]");
  if (!(pair.rolling >= 0) || !std::isfinite(pair.rolling))
    refuse("set_friction", "rolling", pair.rolling, "needs to be >= 0 and finite [m]");
  materials_[ascending(a, b)] = pair;
}

void BodyShapes::no_contact(BodyId a, BodyId b) { apart_.insert(ascending(a.index, b.index)); }

std::vector<BodyShapes::Pair> BodyShapes::pairs(const Model& model) const {
  std::vector<Pair> all;
  for (int j = 0; j < static_cast<int>(shapes_.size()); ++j)
    for (int i = 0; i < j; ++i) {
      const bool in_order = shapes_[at(i)].body.index <= shapes_[at(j)].body.index;
      const Pair pair = in_order ? Pair(i, j) : Pair(j, i);
      const Placed &a = shapes_[at(pair.first)], &b = shapes_[at(pair.second)];
      const bool one_moves = moves(model.body(a.body).kind) || moves(model.body(b.body).kind);
      if (a.body == b.body || !one_moves || a.shape.planar() != b.shape.planar()) continue;
      if (apart_.contains({a.body.index, b.body.index}) || joined(model, a.body, b.body)) continue;
      if (!left_out_.contains(pair)) all.push_back(pair);
    }
  return all;
}

std::string BodyShapes::name(const Model& model, const Pair& pair) const {
  const Placed &a = shapes_[at(pair.first)], &b = shapes_[at(pair.second)];
  return model.body(a.body).name + "." + a.name + "|" + model.body(b.body).name + "." + b.name;
}

Gap BodyShapes::gap(const Pair& pair) const {
  const Placed &a = shapes_[at(pair.first)], &b = shapes_[at(pair.second)];
  return gap_between(a.shape, b.shape, a.pose, b.pose);
}

std::vector<std::string> BodyShapes::leave_out_overlapping(const Model& model, const State& x) {
  model.check("leave_out_overlapping", x);
  constexpr double rounding = 1e-9;  // of the smaller shape: poses that were typed with ten digits or more
  std::vector<std::string> names;
  for (const Pair& pair : pairs(model)) {
    const Placed &a = shapes_[at(pair.first)], &b = shapes_[at(pair.second)];
    const Gap between = gap(pair);
    std::vector<ContactPoint> points(at(between.points()));
    between(model.pose(x, a.body), model.pose(x, b.body), x.t, points);
    const double allowed = rounding * std::min(a.shape.reach(), b.shape.reach());
    if (std::none_of(points.begin(), points.end(), [&](const ContactPoint& p) { return p.gap < -allowed; }))
      continue;
    left_out_.insert(pair);
    names.push_back(name(model, pair));
  }
  return names;
}

void BodyShapes::add_contacts(Model& model) const {
  for (const Pair& pair : pairs(model)) {
    const Placed &a = shapes_[at(pair.first)], &b = shapes_[at(pair.second)];
    const auto known = materials_.find(ascending(a.material, b.material));
    const MaterialPair how = known == materials_.end() ? MaterialPair{} : known->second;
    model.add_contact(a.body, b.body, gap(pair),
                      {.mu = how.mu,
                       .torsion = how.torsion,
                       .rolling = how.rolling,
                       .e = how.e,
                       .name = name(model, pair)});
  }
}

}  // namespace perp
