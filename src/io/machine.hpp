// Where a figure was measured: without it CPU seconds say little.
#pragma once

#include <string>

namespace perp {

/// One line: processor, cores, system, compiler, flags, version of perp.
[[nodiscard]] std::string machine();

}  // namespace perp
