// Numbers for a page: base64 of little-endian binary, with the fewest bytes that hold them as well as is asked.
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

namespace perp {

[[nodiscard]] std::string base64(const void* data, std::size_t bytes);

/// How a column of keys is stored.
enum class Precision {
  Double,  ///< as it is
  Single,  ///< 4 bytes: 6e-8 of the value
  Whole    ///< 2 bytes: 1/65535 of the range of each of the `width` components
};

/// {type, data} and for Whole {low, step}; `error` grows to the largest difference of a stored number.
[[nodiscard]] nlohmann::json encoded(const std::vector<double>& values, std::size_t width,
                                     Precision precision, double& error);
[[nodiscard]] nlohmann::json encoded_bytes(const std::vector<unsigned char>& values);

}  // namespace perp
