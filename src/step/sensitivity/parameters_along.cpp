#include "step/sensitivity/parameters_along.hpp"

#include <cmath>

#include "core/index.hpp"
#include "perp/core/errors.hpp"

namespace perp {
namespace {

constexpr double first_width = 3e-6;  // of a parameter's scale
constexpr double too_far =
    30;  // of the half-width that the tangent asks for, before the models are made again

void need_alike(const Model& a, const Model& b) {
  const bool alike = a.nq() == b.nq() && a.nv() == b.nv() && a.bodies().size() == b.bodies().size() &&
                     a.joints().size() == b.joints().size() && a.contact_points() == b.contact_points();
  if (!alike)
    throw std::invalid_argument(
        "sensitivity: model: has other bodies, joints or contacts at neighbouring parameters; it needs the "
        "same ones");
}

}  // namespace

ParametersAlong::ParametersAlong(const ParametricModel& model, const Vector& theta, const Vector& scale,
                                 const Model& here, Eigen::Index start_columns)
    : model_(model), theta_(theta), here_(here), scale_(theta.size()), start_columns_(start_columns) {
  if (scale.size() != 0 && scale.size() != theta.size())
    refuse("sensitivity", "scale", static_cast<double>(scale.size()),
           "needs as many entries as theta: " + std::to_string(theta.size()));
  pairs_.resize(perp::at(theta.size()));
  sides_.resize(perp::at(theta.size() + start_columns), {&here, &here, 0});
  for (Eigen::Index j = 0; j < theta.size(); ++j) {
    scale_[j] = scale.size() > 0 ? scale[j] : theta[j] != 0 ? std::abs(theta[j]) : 1;
    if (!(scale_[j] > 0) || !std::isfinite(scale_[j]))
      refuse("sensitivity", "scale", scale_[j], "needs to be positive and finite");
    make(j, first_width * scale_[j]);
  }
}

void ParametersAlong::make(Eigen::Index j, double eps) {
  Vector there = theta_;
  there[j] = theta_[j] + eps;
  const double plus = there[j];
  Pair& pair = pairs_[perp::at(j)];
  pair.plus = model_(there);
  there[j] = theta_[j] - eps;
  pair.minus = model_(there);
  need_alike(here_, pair.plus.model);
  need_alike(here_, pair.minus.model);
  sides_[perp::at(j)] = {&pair.plus.model, &pair.minus.model, 0.5 * (plus - there[j])};
}

StateTangent ParametersAlong::start(const State& x) const {
  const Eigen::Index nv = here_.nv(), m = theta_.size();
  StateTangent out{Matrix::Zero(nv, m + start_columns_), Matrix::Zero(nv, m + start_columns_)};
  for (Eigen::Index j = 0; j < m; ++j)
    difference(here_, x, pairs_[perp::at(j)].plus.start, pairs_[perp::at(j)].minus.start,
               sides_[perp::at(j)].eps, j, out);
  if (start_columns_ > 0) {
    out.xi.middleCols(m, nv).setIdentity();
    out.nu.middleCols(m + nv, nv).setIdentity();
  }
  return out;
}

const std::vector<ParameterSides>& ParametersAlong::at(const State& x, const StateTangent& tangent) {
  for (Eigen::Index j = 0; j < theta_.size(); ++j) {
    const double wanted = half_width(here_, x, tangent, j);
    if (sides_[perp::at(j)].eps > too_far * wanted) make(j, wanted);
  }
  return sides_;
}

}  // namespace perp
