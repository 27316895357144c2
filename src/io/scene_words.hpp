// Words of scene files that stand for kinds of bodies and joints.
#pragma once

#include <array>
#include <string>
#include <utility>
#include <vector>

#include "perp/model/body.hpp"
#include "perp/model/joint.hpp"

namespace perp::scene_words {

inline constexpr std::array body_kinds{
    std::pair{"spatial", BodyKind::Spatial}, std::pair{"planar", BodyKind::Planar},
    std::pair{"particle", BodyKind::Particle}, std::pair{"prescribed", BodyKind::Prescribed}};

inline constexpr std::array joint_kinds{std::pair{"fixed", JointKind::Fixed},
                                        std::pair{"ball", JointKind::Ball},
                                        std::pair{"revolute", JointKind::Revolute},
                                        std::pair{"prismatic", JointKind::Prismatic},
                                        std::pair{"cylindrical", JointKind::Cylindrical},
                                        std::pair{"universal", JointKind::Universal},
                                        std::pair{"planar", JointKind::Planar},
                                        std::pair{"screw", JointKind::Screw},
                                        std::pair{"rod", JointKind::Rod},
                                        std::pair{"gear", JointKind::Gear}};

template <class Words>
std::vector<std::string> names(const Words& words) {
  std::vector<std::string> list;
  for (const auto& [name, kind] : words) list.emplace_back(name);
  return list;
}

/// The word for a kind; null if there is none yet.
template <class Words, class Kind>
const char* name_of(const Words& words, Kind kind) {
  for (const auto& [name, same] : words)
    if (same == kind) return name;
  return nullptr;
}

}  // namespace perp::scene_words
