#include "step/parts/stable_step.hpp"

#include <cmath>
#include <cstdio>

#include "core/index.hpp"
#include "instant/pair_side.hpp"
#include "perp/core/errors.hpp"
#include "perp/instant/reduced_system.hpp"
#include "step/certificate/closeness.hpp"

namespace perp {
namespace {

/// A spring along a row: its elongation's rate is Wᵀ nu + (explicit part).
struct Elastic {
  WrenchMap<1> W = {};
  double stiffness = 0, damping = 0, rate = 0;
  std::string name = {};
};

Elastic along(const Model& model, const Instant& s, const Spring& spring, int number, const Vector& nu) {
  const std::size_t a = at(spring.a.index), b = at(spring.b.index);
  const Vector3 x_a = s.X[a] * spring.point_a, x_b = s.X[b] * spring.point_b, d = x_b - x_a;
  Elastic e{.stiffness = spring.stiffness, .damping = spring.damping};
  e.name = "spring " + std::to_string(number + 1) + " between '" + model.body(spring.a).name + "' and '" +
           model.body(spring.b).name + "'";
  e.W.connect(model, spring.a, spring.b);
  const Vector3 n = d.norm() > 0 ? Vector3(d.normalized()) : Vector3::UnitX();
  double prescribed = 0;
  const auto side = [&](int body, double sign, const Vector3& x, WrenchMap<1>::Block& block) {
    const Side here = side_of(model, s, body, sign, x);
    Eigen::Matrix<double, 6, 1> wrench;
    wrench << sign * n, sign * here.r.cross(n);
    if (here.body.nv > 0)
      block = here.T.transpose() * wrench;
    else
      prescribed += sign * n.dot(here.V.at(here.r));
  };
  side(spring.a.index, -1, x_a, e.W.A);
  side(spring.b.index, +1, x_b, e.W.B);
  e.rate = e.W.velocity(nu)[0] + prescribed;
  return e;
}

Elastic along(const Model& model, const Instant& s, const JointSpring& spring, const Vector& nu) {
  const JointRowInstant& c = s.coordinate(spring.joint, spring.coordinate);
  return {.W = c.W,
          .stiffness = spring.stiffness,
          .damping = spring.damping,
          .rate = c.velocity(nu),
          .name = "the spring of joint '" + model.joint(spring.joint).name + "'"};
}

/// Wᵀ y, y = M^-1 W less what the joints take of it.
double inverse_mass_past_joints(const Model& model, const Instant& s, const WrenchMap<1>& W) {
  Vector impulse = Vector::Zero(model.nv()), y;
  W.add_impulse(WrenchMap<1>::Columns(1.0), impulse);
  solve_mass(model, s, impulse, y);
  if (!s.joint_rows.empty()) {
    Islands islands;
    islands.find(model, s, {});
    Vector reactions = Vector::Zero(static_cast<Eigen::Index>(s.joint_rows.size())), taken = 0 * impulse;
    const Vector still = reactions;
    for (Island island : islands.get()) {
      island.joint_frictions.clear();
      ReducedSystem reduced;
      reduced.assemble(model, s, island, y, still);
      reduced.add_impulses(s, island, Vector(), taken, reactions);
    }
    Vector held;
    solve_mass(model, s, taken, held);
    y += held;
  }
  return W.velocity(y)[0];
}

}  // namespace

std::string unstable_spring(const Model& model, const Instant& s, const Vector& nu, double h, Damping damping,
                            double speed) {
  double worst = 4;
  std::string message;
  const auto look = [&](const Elastic& e) {
    const double c = damping == Damping::Explicit ? e.damping : 0, k = e.stiffness;
    const auto growth = [&](double w) { return h * h * k * w + 2 * h * c * w; };
    Vector impulse = Vector::Zero(model.nv()), y;
    e.W.add_impulse(WrenchMap<1>::Columns(1.0), impulse);
    solve_mass(model, s, impulse, y);
    if (!(growth(e.W.velocity(y)[0]) > worst)) return;
    if (closeness::sticks(std::abs(e.rate), speed)) return;
    const double w = inverse_mass_past_joints(model, s, e.W);
    if (!(growth(w) > worst)) return;
    worst = growth(w);
    const double stable = 4 / (c * w + std::sqrt(c * c * w * w + 4 * k * w));
    constexpr double followed = 0.1;  // of that: an oscillation of 30 steps, whose energy the step keeps
    char would_do[32];
    std::snprintf(would_do, sizeof would_do, "%.1e", followed * stable);
    message = e.name + " is too stiff for a step of " + shortest(h) + " s: past " + shortest(stable) +
              " s its oscillation grows; " + would_do + " s would do (ncp takes any step)";
  };
  for (std::size_t i = 0; i < model.springs().size(); ++i)
    look(along(model, s, model.springs()[i], static_cast<int>(i), nu));
  for (const JointSpring& spring : model.joint_springs()) look(along(model, s, spring, nu));
  return message;
}

}  // namespace perp
