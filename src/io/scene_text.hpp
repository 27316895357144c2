// Pieces of scene files as text: numbers that read back to the same bits, quotes, lists, inline tables.
#pragma once

#include <span>
#include <string>
#include <string_view>

#include "perp/core/types.hpp"

namespace perp {

[[nodiscard]] bool same_bits(double a, double b);  ///< unlike ==, tells 0 from -0

[[nodiscard]] std::string in_quotes(std::string_view text);  ///< as a basic string of TOML

[[nodiscard]] std::string written(std::span<const double> numbers);  ///< 3 or [1, 2, 3]
[[nodiscard]] std::string written(const Vector3& v);
[[nodiscard]] std::string written(std::span<const std::string> texts);  ///< ["a", "b"]

/// { key = value, ... }
class InlineTable {
 public:
  void add(std::string_view key, std::string_view value);
  std::string text() const { return text_.empty() ? "{}" : "{ " + text_ + " }"; }

 private:
  std::string text_;
};

}  // namespace perp
