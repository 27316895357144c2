#include "io/scene_text.hpp"

#include <bit>
#include <cstdint>

#include "perp/core/errors.hpp"

namespace perp {

bool same_bits(double a, double b) {
  return std::bit_cast<std::uint64_t>(a) == std::bit_cast<std::uint64_t>(b);
}

std::string in_quotes(std::string_view text) {
  constexpr std::string_view digits = "0123456789abcdef";
  std::string out = "\"";
  for (const char c : text) {
    const auto code = static_cast<unsigned char>(c);
    if (c == '"' || c == '\\') {
      out += '\\';
      out += c;
    } else if (code < 0x20 || code == 0x7f) {
      out.append("\\u00").append(1, digits[code >> 4]).append(1, digits[code & 15]);
    } else {
      out += c;
    }
  }
  return out += '"';
}

std::string written(std::span<const double> numbers) {
  if (numbers.size() == 1) return shortest(numbers[0]);
  std::string list;
  for (const double x : numbers) list.append(list.empty() ? "[" : ", ").append(shortest(x));
  return list += ']';
}

std::string written(const Vector3& v) { return written(std::span(v.data(), 3)); }

std::string written(std::span<const std::string> texts) {
  std::string list;
  for (const std::string& text : texts) list.append(list.empty() ? "[" : ", ").append(in_quotes(text));
  return list += ']';
}

void InlineTable::add(std::string_view key, std::string_view value) {
  if (!text_.empty()) text_ += ", ";
  text_.append(key).append(" = ").append(value);
}

}  // namespace perp
