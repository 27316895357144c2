// Units that numbers of a scene file may be given in.
#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "io/scene_table.hpp"

namespace perp {

struct Quantity {
  double value = 0;  ///< in SI units
  Dimension dimension = Dimension::None;
  std::string_view unit;
};

/// "10 mm" as a quantity; nothing if `text` is not a number and a name after it. Throws ExpressionError for a name that is
/// no unit of `dimension`.
[[nodiscard]] std::optional<Quantity> read_quantity(std::string_view text, Dimension dimension);

/// "a length [m]"
[[nodiscard]] std::string describe(Dimension dimension);

}  // namespace perp
