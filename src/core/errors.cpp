#include "perp/core/errors.hpp"

#include <array>
#include <charconv>
#include <stdexcept>

namespace perp {

void refuse(std::string_view where, std::string_view argument, std::string_view value,
            std::string_view need) {
  std::string message(where);
  message.append(": ").append(argument).append(" is ").append(value).append(", ").append(need);
  throw std::invalid_argument(message);
}

void refuse(std::string_view where, std::string_view argument, double value, std::string_view need) {
  refuse(where, argument, shortest(value), need);
}

std::string shortest(double value) {
  std::array<char, 32> buffer{};
  const auto [end, error] = std::to_chars(buffer.data(), buffer.data() + buffer.size(), value);
  return {buffer.data(), end};
}

}  // namespace perp
