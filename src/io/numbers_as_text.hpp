// Numbers in files that perp writes for itself: the shortest decimals that read back to the same double, with blanks between them.
#pragma once

#include <charconv>
#include <stdexcept>
#include <string>
#include <vector>

#include "perp/core/errors.hpp"
#include "perp/core/types.hpp"

namespace perp {

/// The whole text as a number; throws std::runtime_error if it is none.
inline double number_in(const std::string& text) {
  double value = not_set;
  const auto read = std::from_chars(text.data(), text.data() + text.size(), value);
  if (read.ec != std::errc() || read.ptr != text.data() + text.size())
    throw std::runtime_error("'" + text + "' is no number");
  return value;
}

inline std::string as_text(const Vector& v) {
  std::string text;
  for (const double x : v) text += (text.empty() ? "" : " ") + shortest(x);
  return text;
}

inline Vector vector_in(const std::string& text) {
  std::vector<double> values;
  for (std::size_t begin = 0; begin < text.size();) {
    const std::size_t end = std::min(text.find(' ', begin), text.size());
    values.push_back(number_in(text.substr(begin, end - begin)));
    begin = end + 1;
  }
  return Eigen::Map<const Vector>(values.data(), static_cast<Eigen::Index>(values.size()));
}

}  // namespace perp
