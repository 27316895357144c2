// What expressions over a run may name: the time, coordinates and velocities of bodies and joints.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "perp/io/expression.hpp"
#include "perp/model/model.hpp"

namespace perp {

/// What an expression may name.
struct Observable {
  std::string name;
  std::function<double(const Model&, const State&)> value;
};

/// t; BODY.x .y .z .qw .qx .qy .qz .vx .vy .vz .wx .wy .wz, planar BODY.x .y .angle .vx .vy .omega, generalized BODY.q1 .. .v1 ..;
/// JOINT.coordinate, JOINT.rate, or JOINT.COORDINATE.coordinate where it has several.
[[nodiscard]] std::vector<Observable> observables_of(const Model& model);

/// The function of state that an expression in all of these is; it evaluates what it uses alone.
[[nodiscard]] std::function<double(const Model&, const State&)> observed(const Expression& written,
                                                                         const std::vector<Observable>& all);

}  // namespace perp
