#include "step/linearized/mixed_form.hpp"

#include <algorithm>
#include <cmath>

#include "core/index.hpp"
#include "perp/solve/mixed_lcp.hpp"

namespace perp {
namespace {

/// Column c of a wrench map as a vector of the system's velocity space.
template <int C>
Vector dense(const WrenchMap<C>& W, int c, int nv) {
  Vector column = Vector::Zero(nv);
  W.add_impulse(WrenchMap<C>::Columns::Unit(c), column);
  return column;
}

/// The columns of D, each with the velocity that its body of reference brings along, and sigma's row that bounds it.
struct FrictionDirections {
  std::vector<Vector> D;
  std::vector<double> bias;
  std::vector<int> group;
};

}  // namespace

bool solve_mixed(const Model& model, const Instant& s, const std::vector<Vector2>& polygon,
                 std::span<const int> active, const Vector& nu_free, const Vector& gap_term,
                 const Vector& joint_bias, double h, Answer& answer, std::string& message) {
  const int nv = model.nv(), nb = static_cast<int>(s.joint_rows.size()), nc = static_cast<int>(active.size());

  // directions of friction: unilateral ones, then joints'
  FrictionDirections directions;
  std::vector<double> mu, bound;  // of each sigma
  std::vector<int> normal;        // its contact in `active`, or -1
  for (int i = 0; i < nc; ++i) {
    const ContactInstant& c = s.contacts[at(active[at(i)])];
    if (c.tangents == 0) continue;
    const auto add = [&](double d_t, double d_o) {
      directions.D.push_back(d_t * dense(c.W, 1, nv) + d_o * dense(c.W, 2, nv));
      directions.bias.push_back(d_t * c.bias.y() + d_o * c.bias.z());
      directions.group.push_back(static_cast<int>(mu.size()));
    };
    if (c.tangents == 1) {
      add(1, 0);
      add(-1, 0);
    } else {
      for (const Vector2& d : polygon) add(d.x(), d.y());
    }
    mu.push_back(c.mu);
    bound.push_back(0);
    normal.push_back(i);
  }
  for (const JointRowInstant& joint : s.joint_frictions) {
    for (const double sign : {1.0, -1.0}) {
      directions.D.push_back(sign * dense(joint.W, 0, nv));
      directions.bias.push_back(sign * joint.psi_b_t);
      directions.group.push_back(static_cast<int>(mu.size()));
    }
    mu.push_back(0);
    bound.push_back(h * joint.friction);
    normal.push_back(-1);
  }
  const int nd = static_cast<int>(directions.D.size()), ns = static_cast<int>(mu.size());

  Matrix W_n(nv, nc), D(nv, nd), W_b(nv, nb), M(nv, nv);
  for (int i = 0; i < nc; ++i) W_n.col(i) = dense(s.contacts[at(active[at(i)])].W, 0, nv);
  for (int j = 0; j < nd; ++j) D.col(j) = directions.D[at(j)];
  for (int i = 0; i < nb; ++i) W_b.col(i) = dense(s.joint_rows[at(i)].W, 0, nv);
  Vector column;
  for (int i = 0; i < nv; ++i) {
    multiply_mass(model, s, Vector::Unit(nv, i), column);
    M.col(i) = column;
  }

  MixedLcp mixed;
  mixed.A = Matrix::Zero(nv + nb, nv + nb);
  mixed.A.topLeftCorner(nv, nv) = M;
  mixed.A.topRightCorner(nv, nb) = -W_b;
  mixed.A.bottomLeftCorner(nb, nv) = W_b.transpose();
  mixed.a = Vector::Zero(nv + nb);
  mixed.a.head(nv) = -(M * nu_free);
  mixed.a.tail(nb) = joint_bias;
  mixed.C = Matrix::Zero(nv + nb, nc + nd + ns);
  mixed.C.topLeftCorner(nv, nc) = -W_n;
  mixed.C.block(0, nc, nv, nd) = -D;
  mixed.D = Matrix::Zero(nc + nd + ns, nv + nb);
  mixed.D.topLeftCorner(nc, nv) = W_n.transpose();
  mixed.D.block(nc, 0, nd, nv) = D.transpose();
  mixed.B = Matrix::Zero(nc + nd + ns, nc + nd + ns);
  mixed.b = Vector::Zero(nc + nd + ns);
  for (int i = 0; i < nc; ++i) mixed.b[i] = gap_term[active[at(i)]] + s.contacts[at(active[at(i)])].bias.x();
  for (int j = 0; j < nd; ++j) {
    const int sigma = nc + nd + directions.group[at(j)];
    mixed.b[nc + j] = directions.bias[at(j)];
    mixed.B(nc + j, sigma) = 1;   // E
    mixed.B(sigma, nc + j) = -1;  // -E^T
  }
  for (int g = 0; g < ns; ++g) {
    if (normal[at(g)] >= 0) mixed.B(nc + nd + g, normal[at(g)]) = mu[at(g)];  // U
    mixed.b[nc + nd + g] = bound[at(g)];
  }

  const MixedLcpSolution solution = solve_mixed_lcp(mixed);
  answer.solver = "mixed";
  answer.iterations = solution.pivots;
  if (!solution.solved()) {
    message = "the mixed LCP was not solved: " + std::string(name_of(solution.status));
    return false;
  }

  // the answer, and what the complementarity conditions leave at nu+: impulses count as the velocities that they cause
  const auto mobility = [&](const Vector& direction) {
    solve_mass(model, s, direction, column);
    return direction.dot(column);
  };
  answer.nu = solution.u.head(nv);
  answer.reactions = solution.u.tail(nb);
  const Vector p_n = solution.v.head(nc), beta = solution.v.segment(nc, nd), sigma = solution.v.tail(ns);
  answer.impulse = W_n * p_n + D * beta + W_b * answer.reactions;
  const Vector w = mixed.D * solution.u + mixed.B * solution.v + mixed.b;
  for (int i = 0; i < nc; ++i) {
    answer.p(0, active[at(i)]) = p_n[i];
    const double caused = mobility(W_n.col(i)) * p_n[i];
    answer.speed_scale =
        std::max({answer.speed_scale, std::abs(mixed.b[i]), std::abs(W_n.col(i).dot(nu_free)), caused});
    answer.normal_residual = std::max(answer.normal_residual, std::abs(std::min(w[i], caused)));
  }
  int j = 0;
  for (int i = 0; i < nc; ++i) {
    const ContactInstant& c = s.contacts[at(active[at(i)])];
    const int count = c.tangents == 0 ? 0 : c.tangents == 1 ? 2 : static_cast<int>(polygon.size());
    answer.slips[at(active[at(i)])] =
        static_cast<char>(count == 0 || sigma[directions.group[at(j)]] > 1e-10 * answer.speed_scale);
    for (int k = 0; k < count; ++k, ++j) {
      const Vector2 d = c.tangents == 1 ? Vector2(k == 0 ? 1 : -1, 0) : polygon[at(k)];
      answer.p.col(active[at(i)]).tail<2>() += beta[j] * d;
    }
  }
  for (std::size_t i = 0; i < s.joint_frictions.size(); ++i, j += 2) {
    answer.joint_friction[static_cast<int>(i)] = beta[j] - beta[j + 1];
    answer.speed_scale = std::max(answer.speed_scale, std::abs(s.joint_frictions[i].velocity(nu_free)));
  }
  for (int i = 0; i < nb; ++i)
    answer.speed_scale =
        std::max({answer.speed_scale, std::abs(joint_bias[i]), std::abs(W_b.col(i).dot(nu_free))});
  for (int k = 0; k < nd; ++k) {
    const double m = mobility(D.col(k));
    const int g = directions.group[at(k)];
    answer.friction_residual = std::max({answer.friction_residual, std::abs(std::min(w[nc + k], m * beta[k])),
                                         std::abs(std::min(m * w[nc + nd + g], sigma[g]))});
  }
  return true;
}

}  // namespace perp
