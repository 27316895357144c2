// How perp refuses what it cannot accept: one exception type, one sentence, always the same three facts.
#pragma once

#include <string>
#include <string_view>

namespace perp {

/// Throws std::invalid_argument with "WHERE: ARGUMENT is VALUE, NEED"; for a caller's mistake, never for a
/// numerical outcome (those are a status and a residual in the result).
[[noreturn]] void refuse(std::string_view where, std::string_view argument, std::string_view value,
                         std::string_view need);
[[noreturn]] void refuse(std::string_view where, std::string_view argument, double value,
                         std::string_view need);

/// The shortest decimal that reads back to the same double, '.' whatever the locale.
[[nodiscard]] std::string shortest(double value);

}  // namespace perp
