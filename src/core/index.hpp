// Eigen counts with signed numbers, the standard containers with unsigned ones.
#pragma once

#include <cstddef>

namespace perp {

/// The place of i >= 0 in a standard container.
constexpr std::size_t at(std::ptrdiff_t i) { return static_cast<std::size_t>(i); }

}  // namespace perp
