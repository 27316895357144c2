// The version of perp: the one place that states it; the build reads it from here.
#pragma once

#define PERP_VERSION "0.1.0"

namespace perp {

inline constexpr const char* version = PERP_VERSION;  ///< major.minor.patch of these headers

}  // namespace perp
