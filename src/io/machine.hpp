// Where a figure was measured: without it CPU seconds say little.
#pragma once

#include <map>
#include <string>

namespace perp {

/// One line: processor, cores, system, compiler, flags, version of perp.
[[nodiscard]] std::string machine();

/// Processor, cores and system alone.
[[nodiscard]] std::string computer();

/// Compiler and flags: what, with the versions, decides the bits of an answer.
[[nodiscard]] std::string build();

/// Of perp and the libraries that it was built with; those it was built without are not there.
[[nodiscard]] std::map<std::string, std::string> library_versions();

}  // namespace perp
