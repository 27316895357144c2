// A short name of a text: what is kept where the text itself would be too long, to see whether it changed.
#pragma once

#include <string>
#include <string_view>

namespace perp {

/// 16 hexadecimal digits: 64 bits of FNV-1a. Finds damage and change, not malice.
[[nodiscard]] std::string fingerprint(std::string_view text);

}  // namespace perp
