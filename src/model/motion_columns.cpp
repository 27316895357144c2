#include "model/motion_columns.hpp"

namespace perp {

std::vector<std::string> motion_columns(const Model& model) {
  std::vector<std::string> names;
  const auto add = [&](const Body& body, std::initializer_list<const char*> parts) {
    for (const char* part : parts) names.push_back(body.name + "." + part);
  };
  for (const Body& body : model.bodies()) {
    switch (body.kind) {
      case BodyKind::Spatial:
      case BodyKind::Prescribed:
        add(body, {"x", "y", "z", "qw", "qx", "qy", "qz", "vx", "vy", "vz", "wx", "wy", "wz"});
        break;
      case BodyKind::Planar:
        add(body, {"x", "y", "angle", "vx", "vy", "omega"});
        break;
      case BodyKind::Particle:
        add(body, {"x", "y", "z", "vx", "vy", "vz"});
        break;
      case BodyKind::Generalized:
        for (int i = 1; i <= body.nq; ++i) names.push_back(body.name + ".q" + std::to_string(i));
        for (int i = 1; i <= body.nv; ++i) names.push_back(body.name + ".v" + std::to_string(i));
        break;
      case BodyKind::Ground:
        break;
    }
  }
  return names;
}

void motion_row(const Model& model, const State& x, std::vector<double>& row) {
  row.clear();
  for (int b = 0; b < static_cast<int>(model.bodies().size()); ++b) {
    const Body& body = model.body({b});
    if (body.kind == BodyKind::Prescribed) {
      const Pose X = model.pose(x, {b});
      const Twist V = model.twist(x, {b});
      row.insert(row.end(), X.p.begin(), X.p.end());
      row.insert(row.end(), {X.q.w(), X.q.x(), X.q.y(), X.q.z()});
      row.insert(row.end(), V.v.begin(), V.v.end());
      row.insert(row.end(), V.w.begin(), V.w.end());
      continue;
    }
    const bool spatial = body.kind == BodyKind::Spatial;
    for (int i = 0; i < body.nq; ++i) row.push_back(x.q[body.q0 + i]);
    for (int i = 0; i < (spatial ? 3 : body.nv); ++i) row.push_back(x.nu[body.v0 + i]);
    if (!spatial) continue;
    const Vector3 w = model.angular_velocity(x, {b});
    row.insert(row.end(), w.begin(), w.end());
  }
}

}  // namespace perp
