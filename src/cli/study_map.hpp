// The maps of perp study.
#pragma once

#include "perp/io/atlas.hpp"

namespace perp {

/// Runs the map, writes it to `folder`, prints how many cells came to what; the exit status.
[[nodiscard]] int study_map(const AtlasRequest& request, const std::filesystem::path& folder);

}  // namespace perp
