// Lists of names in messages: what is known, and what was probably meant.
#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace perp {

/// "a, b, c"; "none" for none.
[[nodiscard]] std::string listed(std::span<const std::string> names);

/// "one of a, b, c", and after it " (did you mean b?)" if one of them is at most a third of its letters away from `word`.
[[nodiscard]] std::string one_of(std::span<const std::string> names, std::string_view word);

}  // namespace perp
