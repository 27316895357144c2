#include "io/observables.hpp"

namespace perp {
namespace {

void add_generalized(const Body& body, std::vector<Observable>& all) {
  for (int i = 0; i < body.nv; ++i) {
    all.push_back({body.name + ".q" + std::to_string(i + 1),
                   [k = body.q0 + i](const Model&, const State& x) { return x.q[k]; }});
    all.push_back({body.name + ".v" + std::to_string(i + 1),
                   [k = body.v0 + i](const Model&, const State& x) { return x.nu[k]; }});
  }
}

void add_orientation(BodyId b, const std::string& name, std::vector<Observable>& all) {
  for (int k = 0; k < 3; ++k)
    all.push_back({name + ".w" + "xyz"[k],
                   [b, k](const Model& m, const State& x) { return m.angular_velocity(x, b)[k]; }});
  for (int k = 0; k < 4; ++k)
    all.push_back({name + ".q" + "wxyz"[k], [b, k](const Model& m, const State& x) {
                     const Quaternion q = m.pose(x, b).q;
                     return k == 0 ? q.w() : q.vec()[k - 1];
                   }});
}

void add_body(BodyId b, const Body& body, std::vector<Observable>& all) {
  const bool planar = body.kind == BodyKind::Planar;
  for (int k = 0; k < (planar ? 2 : 3); ++k) {
    all.push_back(
        {body.name + "." + "xyz"[k], [b, k](const Model& m, const State& x) { return m.position(x, b)[k]; }});
    all.push_back({body.name + ".v" + "xyz"[k],
                   [b, k](const Model& m, const State& x) { return m.velocity(x, b)[k]; }});
  }
  if (planar) {
    all.push_back({body.name + ".angle", [b](const Model& m, const State& x) { return m.angle(x, b); }});
    all.push_back(
        {body.name + ".omega", [b](const Model& m, const State& x) { return m.angular_velocity(x, b).z(); }});
  } else if (body.kind != BodyKind::Particle) {
    add_orientation(b, body.name, all);
  }
}

void add_joint(JointId joint, const JointGeometry& geometry, std::vector<Observable>& all) {
  const int n = static_cast<int>(geometry.coordinates.size());
  for (int i = 0; i < n; ++i) {
    const std::string own(geometry.coordinates[static_cast<std::size_t>(i)].name);
    const std::string name = n == 1 ? geometry.name : geometry.name + "." + own;
    all.push_back({name + ".coordinate",
                   [joint, i](const Model& m, const State& x) { return m.coordinate(x, joint, i); }});
    all.push_back({name + ".rate",
                   [joint, i](const Model& m, const State& x) { return m.coordinate_rate(x, joint, i); }});
  }
}

}  // namespace

std::vector<Observable> observables_of(const Model& model) {
  std::vector<Observable> all{{"t", [](const Model&, const State& x) { return x.t; }}};
  for (int i = 1; i < static_cast<int>(model.bodies().size()); ++i) {
    const Body& body = model.body({i});
    if (body.kind == BodyKind::Generalized)
      add_generalized(body, all);
    else
      add_body({i}, body, all);
  }
  for (int i = 0; i < static_cast<int>(model.joints().size()); ++i) add_joint({i}, model.joint({i}), all);
  return all;
}

std::function<double(const Model&, const State&)> observed(const Expression& written,
                                                           const std::vector<Observable>& all) {
  std::vector<Observable> used;
  for (std::size_t i = 0; i < all.size(); ++i)
    if (written.uses(i)) used.push_back(all[i]);
  std::vector<std::string> names;
  for (const Observable& q : used) names.push_back(q.name);
  const Expression g(written.text(), {}, names);
  return [g, used](const Model& m, const State& x) {
    std::vector<double> now;
    now.reserve(used.size());
    for (const Observable& q : used) now.push_back(q.value(m, x));
    return g(now);
  };
}

}  // namespace perp
