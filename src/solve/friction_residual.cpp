#include "perp/solve/friction_residual.hpp"

#include <algorithm>
#include <cmath>

#include "cone.hpp"
#include "friction_stages.hpp"
#include "global_form.hpp"
#include "perp/core/errors.hpp"

namespace perp {
namespace {

Vector3 padded(BlockKind kind, const Vector& x, Eigen::Index first) {
  Vector3 z = Vector3::Zero();
  z.segment(first_row(kind), block_rows(kind)) = x.segment(first, block_rows(kind));
  return z;
}

}  // namespace

FrictionResidual friction_residual(const FrictionProblem& problem, const ContactSystem& system,
                                   const Vector& r, const Vector& u) {
  FrictionResidual result;
  const std::vector<Eigen::Index> offsets = problem.offsets();
  const double largest = r.size() > 0 ? r.cwiseAbs().maxCoeff() : 0;
  double scaled_map = 0, map = 0, scaled_size = 0;
  for (int i = 0; i < system.n; ++i) {
    const BlockKind kind = system.kind[i];
    const double mu = problem.mu(i), s = system.s[i], sigma = system.sigma;
    const Vector3 r_i = padded(kind, r, offsets[i]), u_i = padded(kind, u, offsets[i]);
    const Vector3 r_scaled = r_i / (s * sigma), u_scaled = u_i * (s / sigma);
    const auto natural = [&](double bound, const Vector3& x, const Vector3& velocity) {
      return (x - project_block(kind, bound, x - augmented_velocity(kind, bound, velocity))).squaredNorm();
    };
    scaled_map += natural(system.mu[i], r_scaled, u_scaled);
    map += natural(mu, r_i, u_i);
    scaled_size += r_scaled.squaredNorm();
    if (kind == BlockKind::Interval) {
      result.cone = std::max(result.cone, std::abs(r_i(1)) - mu);
      continue;
    }
    const double tangential = r_i.tail<2>().norm(), slip = u_i.tail<2>().norm();
    result.penetration = std::max(result.penetration, -u_i(0));
    result.cone =
        std::max({result.cone, -r_i(0), kind == BlockKind::HalfLine ? 0 : tangential - mu * r_i(0)});
    if (r_i(0) <= 1e-9 * largest) continue;
    result.lift = std::max(result.lift, u_i(0));
    if (kind != BlockKind::HalfLine && mu > 0)
      result.sliding = std::max(result.sliding, slip + r_i.tail<2>().dot(u_i.tail<2>()) / (mu * r_i(0)));
  }
  result.absolute = std::sqrt(scaled_map);
  result.round_off = round_off(std::sqrt(scaled_size));
  result.relative = result.absolute / std::max(1.0, std::sqrt(scaled_size));
  result.file = std::sqrt(map);
  return result;
}

FrictionResidual friction_residual(const FrictionProblem& problem, const Vector& r) {
  check(problem);
  if (r.size() != problem.rows())
    refuse("friction_residual", "r size", static_cast<double>(r.size()),
           "as many entries as rows are needed");
  if (!problem.is_global())
    return friction_residual(problem, contact_system(problem), r, problem.W.times(r) + problem.q);
  const MassResponse response(problem);
  Vector v, lambda;
  response.velocity(problem.H.times(r) + problem.f, v, lambda);
  return friction_residual(problem, contact_system(problem, response), r,
                           problem.H.to_sparse().transpose() * v + problem.w);
}

Vector project_reaction(BlockKind kind, double mu, const Vector& z) {
  if (z.size() != block_rows(kind))
    refuse("project_reaction", "z size", static_cast<double>(z.size()),
           "as many entries as the block's rows");
  return project_block(kind, mu, padded(kind, z, 0)).segment(first_row(kind), block_rows(kind));
}

}  // namespace perp
