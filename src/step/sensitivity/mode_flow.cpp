#include "step/sensitivity/mode_flow.hpp"

#include <array>
#include <cmath>

#include "core/index.hpp"
#include "step/events/runge_kutta_87.hpp"

namespace perp {
namespace {

/// One step of order 8 in State's coordinates.
bool runge_kutta_step(ModeDynamics& dynamics, double t_end, State& x) {
  static const RungeKutta87 method = runge_kutta_87();
  constexpr int stages = RungeKutta87::stages;
  const double h = t_end - x.t;
  std::array<Vector, stages> q_dot, nu_dot;
  State at_stage = x;
  for (int i = 0; i < stages; ++i) {
    at_stage.t = x.t + method.c[at(i)] * h;
    at_stage.q = x.q;
    at_stage.nu = x.nu;
    for (int j = 0; j < i; ++j) {
      const double a = method.A[at(i * stages + j)];
      if (a == 0) continue;
      at_stage.q += h * a * q_dot[at(j)];
      at_stage.nu += h * a * nu_dot[at(j)];
    }
    if (!dynamics.evaluate(at_stage)) return false;
    dynamics.kinematic_map(at_stage, q_dot[at(i)]);
    nu_dot[at(i)] = dynamics.nu_dot;
  }
  for (int i = 0; i < stages; ++i) {
    if (method.b[at(i)] == 0) continue;
    x.q += h * method.b[at(i)] * q_dot[at(i)];
    x.nu += h * method.b[at(i)] * nu_dot[at(i)];
  }
  x.t = t_end;
  for (const Body& b : dynamics.model().bodies())
    if (b.kind == BodyKind::Spatial) x.q.segment<4>(b.q0 + 3).normalize();
  dynamics.model().follow_turns(x);
  return true;
}

}  // namespace

std::string FlowPair::begin(const Modes& modes, double small_speed, double speed_error) {
  for (Side* side : {&plus, &minus}) {
    side->dynamics = std::make_unique<ModeDynamics>(*side->model);
    side->dynamics->speed_error = speed_error;
    if (const std::string fault = side->dynamics->begin(side->x, modes, small_speed); !fault.empty())
      return fault;
    if (!std::isfinite(side->dynamics->project(side->x))) return "the state is not finite";
    side->dynamics->begin_step(side->x);
  }
  return "";
}

bool FlowPair::step(double t) {
  for (Side* side : {&plus, &minus}) {
    if (!runge_kutta_step(*side->dynamics, t, side->x)) return false;
    if (!side->dynamics->rows(side->x)) return false;
    side->dynamics->begin_step(side->x);
  }
  return true;
}

bool FlowPair::project() {
  return std::isfinite(plus.dynamics->project(plus.x)) && std::isfinite(minus.dynamics->project(minus.x));
}

void read(const Model& model, const State& x, const FlowPair& pair, Eigen::Index column, StateTangent& out) {
  difference(model, x, pair.plus.x, pair.minus.x, pair.eps, column, out);
}

}  // namespace perp
