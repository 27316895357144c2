// The method that a model needs: `perp run --method auto`.
#pragma once

#include <string>
#include <string_view>

#include "perp/model/model.hpp"

namespace perp {

struct MethodChoice {
  std::string_view method;  ///< as in `perp methods`
  std::string why;          ///< one line
};

/// By what the model has, in this order:
///   without a step   `event`, if it has at most `few_points` contact points: events are few. Throws std::invalid_argument where it has
///                    more: a step is needed
///   with a step      `lcp` where all gaps are linear in q and all directions fixed (points on planes that do not move, of bodies that do
///                    not turn, friction along one line or none), and no joints: there it gives what `ncp` gives, cheaper, and exact normals;
///                    `ncp` where there are more than `many_points` contact points; else `ncp2`.
[[nodiscard]] MethodChoice choose_method(const Model& model, bool with_step);

}  // namespace perp
