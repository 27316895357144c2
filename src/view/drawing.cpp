#include "view/drawing.hpp"

#include <algorithm>
#include <cmath>
#include <map>

#include "core/index.hpp"
#include "perp/instant/instant.hpp"
#include "study/scene_picture.hpp"

namespace perp {
namespace {

std::string_view name_of(BodyMotion::Kind kind) {
  switch (kind) {
    case BodyMotion::Kind::Planar:
      return "planar";
    case BodyMotion::Kind::Particle:
      return "particle";
    default:
      return "spatial";
  }
}

/// Bodies of the file that have a pose, in its order.
void add_moving(const RecordedRun& run, Drawing& drawing) {
  for (const BodyMotion& motion : run.bodies) {
    if (motion.kind == BodyMotion::Kind::Generalized) continue;
    DrawnBody& body = drawing.bodies.emplace_back();
    body.name = motion.name;
    body.kind = name_of(motion.kind);
    body.colour = static_cast<int>(drawing.bodies.size()) - 1;
    body.t = run.t;
    body.moments = motion.moments;
  }
}

/// The convex hull of points in the xy plane, counter-clockwise (Andrew's monotone chain).
std::vector<Vector3> hull(std::vector<Vector3> points) {
  std::sort(points.begin(), points.end(), [](const Vector3& a, const Vector3& b) {
    return a.x() < b.x() || (a.x() == b.x() && a.y() < b.y());
  });
  std::vector<Vector3> chain;
  const auto half = [&](auto first, auto last) {
    const std::size_t start = chain.size();
    for (; first != last; ++first) {
      const auto turns_left = [&] {
        const Vector3 a = chain.back() - chain[chain.size() - 2], b = *first - chain.back();
        return a.x() * b.y() - a.y() * b.x() > 0;
      };
      while (chain.size() >= start + 2 && !turns_left()) chain.pop_back();
      chain.push_back(*first);
    }
    chain.pop_back();
  };
  half(points.begin(), points.end());
  half(points.rbegin(), points.rend());
  return chain;
}

/// In the plane the corners that a body touches others with, and the points through which its faces go, are a polygon's.
void join_corners(std::vector<Solid>& solids) {
  std::vector<Vector3> corners;
  for (const Solid& s : solids) {
    if (s.kind == Solid::Kind::Stick) corners.push_back(s.place * s.size);
    if (s.kind == Solid::Kind::Plane) corners.push_back(s.place.p);
  }
  if (corners.size() < 3) return;
  Solid polygon{.kind = Solid::Kind::Polygon, .vertices = hull(corners)};
  if (polygon.vertices.size() < 3) return;
  std::erase_if(solids, [](const Solid& s) { return s.kind == Solid::Kind::Stick; });
  solids.push_back(std::move(polygon));
}

/// What the scene itself says that a body looks like, in place of what was concluded.
void add_parts(const Scene& scene, BodyId body, std::vector<Solid>& solids) {
  bool first = true;
  for (const ScenePart& part : picture_of(scene)) {
    if (part.body != body || part.pose) continue;
    if (first && body != ground)
      std::erase_if(solids, [](const Solid& s) {
        return s.kind == Solid::Kind::Stick || s.kind == Solid::Kind::Plane;
      });
    first = false;
    for (std::size_t i = 0; i < part.shapes.size(); ++i)
      solids.push_back(solid_of(part.shapes[i], part.poses[i]));
  }
}

/// How a part of a generalized body moves: its velocity by central differences along the coordinates' rates.
Moment moment_of(const ScenePart& part, const Vector& q, const Vector& v) {
  constexpr double step = 1e-5;  // s: a part turns little within it, and positions lose half of their digits
  const Pose X = part.pose(q), before = part.pose(q - step * v), after = part.pose(q + step * v);
  return {X,
          {(after.p - before.p) / (2 * step), rotation_vector(after.q * before.q.conjugate()) / (2 * step)}};
}

/// The parts of generalized bodies as bodies of their own; bodies that have none are left to plots.
void add_generalized(const RecordedRun& run, Drawing& drawing) {
  const std::vector<ScenePart> parts = run.scene ? picture_of(*run.scene) : std::vector<ScenePart>();
  for (const BodyMotion& motion : run.bodies) {
    if (motion.kind != BodyMotion::Kind::Generalized) continue;
    bool seen = false;
    const auto n = static_cast<Eigen::Index>(motion.freedoms);
    for (const ScenePart& part : parts) {
      if (!part.pose || run.scene->model.body(part.body).name != motion.name) continue;
      seen = true;
      DrawnBody& body = drawing.bodies.emplace_back();
      body.name = motion.name + "." + part.name;
      body.colour = static_cast<int>(drawing.bodies.size()) - 1;
      body.t = run.t;
      for (std::size_t i = 0; i < part.shapes.size(); ++i)
        body.solids.push_back(solid_of(part.shapes[i], part.poses[i]));
      body.kind =
          std::all_of(part.shapes.begin(), part.shapes.end(), [](const Shape& s) { return s.planar(); })
              ? "planar"
              : "spatial";
      for (Eigen::Index i = 0; i < static_cast<Eigen::Index>(run.t.size()); ++i)
        body.moments.push_back(moment_of(part, Eigen::Map<const Vector>(motion.q.data() + i * n, n),
                                         Eigen::Map<const Vector>(motion.v.data() + i * n, n)));
    }
    if (!seen) drawing.unseen.push_back(motion.name);
  }
}

/// Solids, joints, the ground and prescribed bodies, which only the scene knows.
void add_scene(const RecordedRun& run, const Scene& scene, Drawing& drawing) {
  const Model& model = scene.model;
  std::vector<std::vector<Solid>> solids = solids_of(model);
  std::vector<int> index(model.bodies().size(), -1);
  for (int b = 0; b < static_cast<int>(model.bodies().size()); ++b) {
    const Body& body = model.body({b});
    const auto drawn = std::find_if(drawing.bodies.begin(), drawing.bodies.end(),
                                    [&](const DrawnBody& d) { return d.name == body.name && b > 0; });
    if (drawn != drawing.bodies.end()) {
      index[at(b)] = static_cast<int>(drawn - drawing.bodies.begin());
      drawn->solids = std::move(solids[at(b)]);
      add_parts(scene, {b}, drawn->solids);
      if (body.kind == BodyKind::Prescribed) drawn->kind = "prescribed";
      if (body.kind == BodyKind::Planar) join_corners(drawn->solids);
      continue;
    }
    if (body.kind != BodyKind::Ground && body.kind != BodyKind::Prescribed) continue;
    index[at(b)] = static_cast<int>(drawing.bodies.size());
    DrawnBody& fixed = drawing.bodies.emplace_back();
    fixed.name = body.kind == BodyKind::Ground ? "ground" : body.name;
    fixed.kind = body.kind == BodyKind::Ground ? "ground" : "prescribed";
    fixed.solids = std::move(solids[at(b)]);
    add_parts(scene, {b}, fixed.solids);
    State x = scene.start;
    if (body.kind == BodyKind::Prescribed)
      fixed.t = run.t;
    else
      fixed.t = {run.t.front()};
    for (const double t : fixed.t) {
      x.t = t;
      fixed.moments.push_back({model.pose(x, {b}), model.twist(x, {b})});
    }
  }
  for (const JointGeometry& joint : model.joints()) {
    // on the body that is drawn, moving ones first
    const bool on_a = index[at(joint.a.index)] >= 0 && (joint.a.index > 0 || index[at(joint.b.index)] < 0);
    const BodyId id = on_a ? joint.a : joint.b;
    if (index[at(id.index)] < 0) continue;
    DrawnJoint& drawn = drawing.joints.emplace_back();
    drawn.name = joint.name;
    drawn.body = index[at(id.index)];
    drawn.anchor = on_a ? joint.anchor_a : joint.anchor_b;
    if (joint.kind != JointKind::Fixed && joint.kind != JointKind::Ball && joint.kind != JointKind::Rod)
      drawn.axis = model.body(id).rest.q.conjugate() * joint.asked.axis;
  }
  const Vector3& g = model.gravity();
  if (g.norm() > 0) drawing.up = -g.normalized();
}

/// The state at row `i`, as far as files hold it.
void put_row(const RecordedRun& run, const Model& model, std::size_t i, State& x) {
  x.t = run.t[i];
  for (const BodyMotion& motion : run.bodies) {
    const auto& all = model.bodies();
    const auto body =
        std::find_if(all.begin(), all.end(), [&](const Body& b) { return b.name == motion.name; });
    if (body == all.end() || body->nq == 0) continue;
    const BodyId id{static_cast<int>(body - all.begin())};
    if (motion.kind == BodyMotion::Kind::Generalized) {
      const auto n = static_cast<std::size_t>(motion.freedoms);
      if (body->nq != motion.freedoms) continue;
      for (std::size_t k = 0; k < n; ++k) x.q[body->q0 + static_cast<int>(k)] = motion.q[i * n + k];
      continue;
    }
    const Moment& m = motion.moments[i];
    if (body->kind == BodyKind::Planar) {
      x.q.segment<2>(body->q0) = m.X.p.head<2>();
      x.q[body->q0 + 2] = rotation_vector(m.X.q).z();
    } else {
      model.set_position(x, id, m.X.p);
      if (body->kind == BodyKind::Spatial) model.set_orientation(x, id, m.X.q);
    }
  }
}

/// Where the contact points of the rows are: from the scene's gaps at the rows' configurations.
void add_contact_points(const RecordedRun& run, const Scene& scene, Drawing& drawing) {
  const Model& model = scene.model;
  std::vector<int> point_of;  // of each name
  for (const std::string& name : run.contact_names) point_of.push_back(model.point_names()->find(name));
  State x = scene.start;
  Instant instant;
  drawing.contact_points.resize(run.contacts.size());
  for (std::size_t k = 0; k < run.contacts.size(); ++k) {
    const auto after = std::upper_bound(run.t.begin(), run.t.end(), run.contact_t[k]);
    put_row(run, model, after == run.t.begin() ? 0 : static_cast<std::size_t>(after - run.t.begin()) - 1, x);
    evaluate(model, x, instant);
    for (const ContactMoment& m : run.contacts[k]) {
      const int point = point_of[at(m.name)], i = point < 0 ? -1 : instant.contact_of_point[at(point)];
      // only its coordinates know where a generalized body's contact is
      const bool somewhere = i >= 0 && !model.contact(instant.contacts[at(i)].contact).law.own;
      drawing.contact_points[k].push_back(somewhere ? instant.contacts[at(i)].position
                                                    : Vector3::Constant(not_set));
    }
  }
}

/// A box that grows.
struct Extent {
  Vector3 low = Vector3::Constant(infinity), high = -low;
  void add(const Vector3& p, double margin = 0) {
    low = low.cwiseMin(p - Vector3::Constant(margin));
    high = high.cwiseMax(p + Vector3::Constant(margin));
  }
  void add(const Extent& other) { low = low.cwiseMin(other.low), high = high.cwiseMax(other.high); }
  double diagonal() const { return low.allFinite() ? (high - low).norm() : 0; }
};

bool stands(const DrawnBody& body) { return body.kind == "ground" || body.kind == "prescribed"; }

/// What the solids of the body, or its origin, pass over.
Extent passed_over(const DrawnBody& body) {
  std::vector<Outline> outlines;
  for (const Solid& s : body.solids) outlines.push_back(outline_of(s));
  Extent extent;
  const std::size_t stride = std::max<std::size_t>(1, body.moments.size() / 500);
  for (std::size_t i = 0; i < body.moments.size(); i += stride) {
    const Pose& X = body.moments[i].X;
    if (!stands(body)) extent.add(X.p);
    for (const Outline& outline : outlines)
      for (const Vector3& p : outline.points) extent.add(X * p, outline.margin);
  }
  return extent;
}

/// The box of what moves, over the whole run; of what stands where that is not far larger: the bowl of a marble, but not a floor's slab.
void measure(Drawing& drawing) {
  Extent all;
  for (const DrawnBody& body : drawing.bodies)
    if (!stands(body)) all.add(passed_over(body));
  constexpr double larger = 3;
  const double moving = all.diagonal();
  for (const DrawnBody& body : drawing.bodies) {
    if (!stands(body)) continue;
    for (const Solid& solid : body.solids) {
      DrawnBody one = body;
      one.solids = {solid};
      const Extent fixed = passed_over(one);
      if (moving == 0 || fixed.diagonal() <= larger * moving) all.add(fixed);
    }
  }
  for (const DrawnJoint& joint : drawing.joints) {
    const DrawnBody& body = drawing.bodies[at(joint.body)];
    for (const std::size_t i : {std::size_t{0}, body.moments.size() - 1})
      all.add(body.moments[i].X * joint.anchor);
  }
  if (!all.low.allFinite()) return;
  if (drawing.flat) all.low.z() = all.high.z() = 0;
  if (!(all.diagonal() > 0)) all.add(all.low, 1);
  drawing.low = all.low, drawing.high = all.high;
  drawing.centre = 0.5 * (all.low + all.high);
  drawing.radius = 0.5 * all.diagonal();
}

/// Whether all that moves does so in the xy plane: planar bodies, and particles that nothing takes out of it.
bool is_flat(const RecordedRun& run, const Drawing& drawing) {
  const bool level = run.scene && run.scene->model.gravity().z() == 0;
  const auto stays = [&](const DrawnBody& b) {
    return b.kind == "planar" || stands(b) ||
           (b.kind == "particle" && level &&
            std::all_of(b.moments.begin(), b.moments.end(),
                        [&](const Moment& m) { return m.X.p.z() == b.moments.front().X.p.z(); }));
  };
  return std::all_of(drawing.bodies.begin(), drawing.bodies.end(), stays) &&
         !std::all_of(drawing.bodies.begin(), drawing.bodies.end(), stands);
}

}  // namespace

Drawing drawing_of(const RecordedRun& run) {
  Drawing drawing;
  add_moving(run, drawing);
  add_generalized(run, drawing);
  if (run.scene) {
    add_scene(run, *run.scene, drawing);
    add_contact_points(run, *run.scene, drawing);
  }
  drawing.flat = is_flat(run, drawing);
  if (drawing.flat) drawing.up = Vector3::UnitY();
  measure(drawing);
  return drawing;
}

}  // namespace perp
