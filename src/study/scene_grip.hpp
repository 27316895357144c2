// A capsule between two pads.
#pragma once

#include "study/scene_parts.hpp"

namespace perp {

Scene grip(Parameters&);

}  // namespace perp
