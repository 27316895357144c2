#include "view/encode.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>

namespace perp {

std::string base64(const void* data, std::size_t bytes) {
  static constexpr char letters[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  const auto* in = static_cast<const unsigned char*>(data);
  std::string out;
  out.reserve((bytes + 2) / 3 * 4);
  for (std::size_t i = 0; i < bytes; i += 3) {
    const std::size_t left = std::min<std::size_t>(3, bytes - i);
    std::uint32_t three = std::uint32_t{in[i]} << 16;
    if (left > 1) three |= std::uint32_t{in[i + 1]} << 8;
    if (left > 2) three |= in[i + 2];
    out += letters[three >> 18];
    out += letters[three >> 12 & 63];
    out += left > 1 ? letters[three >> 6 & 63] : '=';
    out += left > 2 ? letters[three & 63] : '=';
  }
  return out;
}

nlohmann::json encoded(const std::vector<double>& values, std::size_t width, Precision precision,
                       double& error) {
  if (precision == Precision::Double)
    return {{"type", "f64"}, {"data", base64(values.data(), values.size() * sizeof(double))}};
  if (precision == Precision::Single) {
    std::vector<float> stored(values.size());
    for (std::size_t i = 0; i < values.size(); ++i) {
      stored[i] = static_cast<float>(values[i]);
      if (std::isfinite(values[i]))
        error = std::max(error, std::abs(values[i] - static_cast<double>(stored[i])));
    }
    return {{"type", "f32"}, {"data", base64(stored.data(), stored.size() * sizeof(float))}};
  }
  constexpr double most = 65535;
  std::vector<double> low(width, std::numeric_limits<double>::max()), step(width, 0);
  std::vector<double> high(width, std::numeric_limits<double>::lowest());
  for (std::size_t i = 0; i < values.size(); ++i) {
    low[i % width] = std::min(low[i % width], values[i]);
    high[i % width] = std::max(high[i % width], values[i]);
  }
  for (std::size_t k = 0; k < width; ++k) {
    if (values.empty()) low[k] = high[k] = 0;
    step[k] = high[k] / most - low[k] / most;
  }
  std::vector<std::uint16_t> stored(values.size());
  for (std::size_t i = 0; i < values.size(); ++i) {
    const std::size_t k = i % width;
    if (step[k] > 0)
      stored[i] =
          static_cast<std::uint16_t>(std::clamp(std::round((values[i] - low[k]) / step[k]), 0.0, most));
    error = std::max(error, std::abs(low[k] + step[k] * stored[i] - values[i]));
  }
  return {{"type", "u16"},
          {"low", low},
          {"step", step},
          {"data", base64(stored.data(), stored.size() * sizeof(std::uint16_t))}};
}

nlohmann::json encoded_bytes(const std::vector<unsigned char>& values) {
  return {{"type", "u8"}, {"data", base64(values.data(), values.size())}};
}

}  // namespace perp
