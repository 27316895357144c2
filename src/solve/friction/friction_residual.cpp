#include "perp/solve/friction_residual.hpp"

#include <algorithm>
#include <cmath>

#include "perp/core/errors.hpp"
#include "solve/friction/friction_stages.hpp"
#include "solve/friction/global_form.hpp"

namespace perp {
namespace {

template <int R>
Column<R> padded(const BlockLayout& layout, const Vector& x, Eigen::Index first) {
  Column<R> z = Column<R>::Zero();
  for (int k = 0; k < layout.rows; ++k) z(layout.place[k]) = x(first + k);
  return z;
}

template <int R>
double natural(const Block<R>& block, const Column<R>& r, const Column<R>& u) {
  return (r - project_block<R>(block, r - augmented_velocity(block, u))).squaredNorm();
}

/// A group's parts: how far r sticks out of size E, as a force, and how much less than the most it takes from u. Moments count by the normal
/// force that they need.
struct GroupMiss {
  double cone, sliding;
};

GroupMiss miss_of(const Vector3& axes, double longest, double size, const Vector3& r, const Vector3& u) {
  Vector3 bounded = Vector3::Zero();
  double free = 0;  // where nothing may push
  for (int k = 0; k < 3; ++k)
    if (axes(k) > 0)
      bounded(k) = r(k);
    else
      free = std::max(free, std::abs(r(k)));
  if (!(longest > 0)) return {free, 0};
  const double out = longest * (ellipsoid_gauge(axes, bounded) - size);
  return {std::max(free, out), (ellipsoid_support(axes, u) + r.dot(u) / size) / longest};
}

/// The parts with a unit that one block adds, r and u in the problem's own.
template <int R>
void add_parts(const Block<R>& block, const Column<R>& r, const Column<R>& u, bool loaded,
               FrictionResidual& result) {
  if (block.contact) {
    result.penetration = std::max(result.penetration, -u(0));
    result.cone = std::max(result.cone, -r(0));
    if (loaded) result.lift = std::max(result.lift, u(0));
  }
  for (const RowGroup& group : RowGroups<R>::all) {
    const Vector3 axes = Block<R>::rows(block.axes, group);
    const double sliding = group.first == 1 ? axes.head<2>().maxCoeff() : 0;
    const GroupMiss miss =
        miss_of(axes,
                !block.contact || sliding > 0 ? axes.maxCoeff()
                : axes.maxCoeff() > 0         ? 1
                                              : 0,
                block.contact ? r(0) : 1, Block<R>::rows(r, group), Block<R>::rows(u, group));
    result.cone = std::max(result.cone, miss.cone);
    if (block.contact && loaded) result.sliding = std::max(result.sliding, miss.sliding);
  }
}

}  // namespace

template <int R>
FrictionResidual friction_residual(const FrictionProblem& problem, const ContactSystem<R>& system,
                                   const Vector& r, const Vector& u) {
  FrictionResidual result;
  const std::vector<Eigen::Index> offsets = problem.offsets();
  double largest = 0;  // of forces
  for (int i = 0; i < system.n; ++i)
    for (int k = 0; k < system.layout[i]->rows; ++k)
      if (system.layout[i]->place[k] < 3) largest = std::max(largest, std::abs(r(offsets[i] + k)));
  double scaled_map = 0, map = 0, scaled_size = 0;
  for (int i = 0; i < system.n; ++i) {
    const Column<R> r_i = padded<R>(*system.layout[i], r, offsets[i]),
                    u_i = padded<R>(*system.layout[i], u, offsets[i]);
    const Column<R> r_scaled = r_i.cwiseQuotient(system.s.col(i) * system.sigma),
                    u_scaled = u_i.cwiseProduct(system.s.col(i) / system.sigma);
    const Block<R> block = make_block<R>(problem, i);
    scaled_map += natural<R>(system.block[i], r_scaled, u_scaled);
    map += natural<R>(block, r_i, u_i);
    scaled_size += r_scaled.squaredNorm();
    add_parts<R>(block, r_i, u_i, r_i(0) > 1e-9 * largest, result);
  }
  result.absolute = std::sqrt(scaled_map);
  result.round_off = round_off(std::sqrt(scaled_size));
  result.relative = result.absolute / std::max(1.0, std::sqrt(scaled_size));
  result.file = std::sqrt(map);
  return result;
}

template FrictionResidual friction_residual(const FrictionProblem&, const ContactSystem<3>&, const Vector&,
                                            const Vector&);
template FrictionResidual friction_residual(const FrictionProblem&, const ContactSystem<6>&, const Vector&,
                                            const Vector&);

namespace {

template <int R>
FrictionResidual residual_of(const FrictionProblem& problem, const Vector& r) {
  if (!problem.is_global())
    return friction_residual(problem, contact_system<R>(problem), r, problem.W.times(r) + problem.q);
  const MassResponse response(problem);
  Vector v, lambda;
  response.velocity(problem.H.times(r) + problem.f, v, lambda);
  return friction_residual(problem, contact_system<R>(problem, response), r,
                           problem.H.to_sparse().transpose() * v + problem.w);
}

template <int R>
Vector projected(const FrictionProblem& problem, Eigen::Index i, const Vector& z) {
  const BlockLayout& layout = layout_of(problem.kind(i));
  const Column<R> p = project_block<R>(make_block<R>(problem, i), padded<R>(layout, z, 0));
  Vector result(layout.rows);
  for (int k = 0; k < layout.rows; ++k) result(k) = p(layout.place[k]);
  return result;
}

}  // namespace

FrictionResidual friction_residual(const FrictionProblem& problem, const Vector& r) {
  check(problem);
  if (r.size() != problem.rows())
    refuse("friction_residual", "r size", static_cast<double>(r.size()),
           "as many entries as rows are needed");
  return column_rows(problem) == 3 ? residual_of<3>(problem, r) : residual_of<6>(problem, r);
}

Vector project_reaction(BlockKind kind, double mu, const Vector& z) {
  FrictionProblem problem;
  problem.kinds = {kind};
  problem.mu = Vector::Constant(1, mu);
  if (layout_of(kind).contact && column_rows(problem) > 3)
    refuse("project_reaction", "kind", "one with moments", "a kind that mu alone describes");
  return project_reaction(problem, 0, z);
}

Vector project_reaction(const FrictionProblem& problem, Eigen::Index block, const Vector& z) {
  if (z.size() != block_rows(problem.kind(block)))
    refuse("project_reaction", "z size", static_cast<double>(z.size()),
           "as many entries as the block's rows");
  return column_rows(problem) == 3 ? projected<3>(problem, block, z) : projected<6>(problem, block, z);
}

}  // namespace perp
