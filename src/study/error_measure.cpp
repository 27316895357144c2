#include "perp/study/error_measure.hpp"

#include <algorithm>
#include <cmath>

#include "perp/core/errors.hpp"

namespace perp {
namespace {

bool same_shape(const Model& model, const State& x) {
  return x.q.size() == model.nq() && x.nu.size() == model.nv();
}

void need_states(const char* where, const Model& model, const State& a, const State& b) {
  for (const State* x : {&a, &b})
    if (!same_shape(model, *x))
      refuse(where, "state", static_cast<double>(x->q.size()), "needs the coordinates of the model");
}

}  // namespace

double configuration_error(const Model& model, const State& a, const State& b) {
  need_states("configuration_error", model, a, b);
  if (!a.q.allFinite() || !b.q.allFinite()) return not_set;
  double largest = 0;
  for (const Body& body : model.bodies()) {
    if (body.nv == 0) continue;
    const int places = body.kind == BodyKind::Generalized ? body.nq : 3;
    largest = std::max(largest, (a.q - b.q).segment(body.q0, places).lpNorm<Eigen::Infinity>());
    if (body.kind != BodyKind::Spatial) continue;
    const auto orientation = [&](const State& x) {
      const auto q = x.q.segment<4>(body.q0 + 3);
      return Quaternion(q[0], q[1], q[2], q[3]);
    };
    largest = std::max(largest, rotation_vector(orientation(a).conjugate() * orientation(b)).norm());
  }
  return largest;
}

double velocity_error(const Model& model, const State& a, const State& b) {
  need_states("velocity_error", model, a, b);
  const Vector difference = world_velocity(model, a) - world_velocity(model, b);
  if (!difference.allFinite()) return not_set;
  return difference.size() == 0 ? 0 : difference.lpNorm<Eigen::Infinity>();
}

Vector world_velocity(const Model& model, const State& x) {
  Vector v = x.nu;
  for (const Body& body : model.bodies()) {
    if (body.kind != BodyKind::Spatial) continue;
    const auto q = x.q.segment<4>(body.q0 + 3);
    v.segment<3>(body.v0 + 3) = Quaternion(q[0], q[1], q[2], q[3]) * Vector3(x.nu.segment<3>(body.v0 + 3));
  }
  return v;
}

}  // namespace perp
