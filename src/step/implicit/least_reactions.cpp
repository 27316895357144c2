#include "step/implicit/least_reactions.hpp"

#include "perp/core/errors.hpp"
#include "solve/friction/minimum_norm.hpp"
#include "step/implicit/implicit_step.hpp"

namespace perp {

void need_any_reactions(std::string_view method, const Model& model, Reactions reactions) {
  if (reactions == Reactions::Any) return;
  const Contact* contact = model.contact_with_moments();
  if (contact == nullptr) return;
  refuse(method, "reactions", "minimum-norm",
         "is not known of torsion and rolling, which contact '" + contact->name + "' has");
}

void take_least(const Model& model, const Instant& instant, double speed, std::vector<Reaction>& reactions) {
  constexpr double rounding = 1e-9;  // of the speeds that enter the step
  FrictionProblem problem;
  std::vector<double> mu, p, u;
  std::vector<Vector> columns;
  for (const Reaction& r : reactions) {
    const bool joint = r.law == Law::Equality, slides = !joint && r.law != Law::HalfLine && slips(r, speed);
    problem.kinds.push_back(joint ? BlockKind::Interval : kind_of(r.law));
    mu.push_back(joint ? infinity : r.mu);
    const auto [first, rows] = rows_of(r.law);
    for (int k = first; k < first + rows; ++k) {
      const bool opens = k == 0 && !joint && !(r.p.x() > 0) && r.u.x() > rounding * speed;
      const bool moves = k > 0 ? slides : opens;
      p.push_back(r.p[k]);
      u.push_back(moves ? r.u[k] : 0);
      columns.push_back(Vector::Zero(model.nv()));
      r.W.add_impulse(Vector3::Unit(k), columns.back());
    }
  }
  const auto m = static_cast<Eigen::Index>(p.size());
  if (m == 0) return;
  Matrix H(model.nv(), m), Y(model.nv(), m);
  Vector y;
  for (Eigen::Index k = 0; k < m; ++k) {
    H.col(k) = columns[static_cast<std::size_t>(k)];
    solve_mass(model, instant, H.col(k), y);
    Y.col(k) = y;
  }
  const Matrix W = H.transpose() * Y;
  problem.W = W;
  problem.mu = Eigen::Map<Vector>(mu.data(), static_cast<Eigen::Index>(mu.size()));
  const Vector before = Eigen::Map<Vector>(p.data(), m);
  const auto least = minimum_norm_reactions(problem, W, before, Eigen::Map<Vector>(u.data(), m));
  if (!least || !(least->norm() <= before.norm())) return;
  Eigen::Index row = 0;
  for (Reaction& r : reactions) {
    const auto [first, rows] = rows_of(r.law);
    r.p.segment(first, rows) = least->segment(row, rows);
    row += rows;
  }
}

}  // namespace perp
