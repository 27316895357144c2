// When expressions jump: what scene files' forces, motors and motions say of their times.
#pragma once

#include <functional>
#include <span>
#include <vector>

#include "perp/io/expression.hpp"
#include "perp/model/timing.hpp"

namespace perp {

/// Values of the variables at a state.
using VariablesAt = std::function<std::vector<double>(const Model&, const State&)>;

/// Of expressions whose first variable is t: steady if none uses it. Arguments of step and abs, and differences of those of min and
/// max, are switches: those of t alone are solved for their times, exactly where they are linear; others are functions of the state.
[[nodiscard]] Timing timing_of(std::span<const Expression> parts, const VariablesAt& at);

}  // namespace perp
