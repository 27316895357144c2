// Minima of functions without derivatives, by NLopt, and what its return codes mean.
#pragma once

#include <functional>
#include <string>

#include "perp/core/types.hpp"

namespace perp {

struct SearchEnd {
  Vector x;
  double value = infinity;
  int evaluations = 0;
  std::string sentence;  ///< how it ended
};

/// What an NLopt return code says, a sentence for each.
[[nodiscard]] std::string sentence_of_nlopt(int code);

/// Controlled random search [KA06] over the box from x, then a quadratic model [Pow09] about the best point found.
/// Without NLopt: x itself, and the sentence says so.
[[nodiscard]] SearchEnd search(const std::function<double(const Vector&)>& f, const Vector& low,
                               const Vector& high, const Vector& x, long evaluations, unsigned seed);

}  // namespace perp
