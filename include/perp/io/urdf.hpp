// Robots as scenes: the tree of links and joints of a URDF file, on a floor or fixed to the world. doc/urdf.md says what is read.
#pragma once

#include <string>
#include <string_view>

#include "perp/study/scene.hpp"

namespace perp {

/// The scene that the URDF text describes; `file` is what messages call it. Links become spatial bodies, those that fixed
/// joints hold together one body; a body's origin is its centre of mass, its axes those of its first link. Its name is that
/// link's, and joints keep theirs; letters that names cannot have become '_'. Parameters:
///   base.fixed           1: the root link is fixed to the world; else it floats. 1 by default if it is called "world" or
///                        has no inertia
///   base.x .. base.yaw   where the root link's frame is [m, rad], roll, pitch, yaw as in URDF; 0
///   floor                1: there is a floor, solid where z < 0. 1 by default if the base floats
///   mu, e                of all contacts of collision shapes
///   q.JOINT, v.JOINT     start of a joint with one freedom [rad, m; rad/s, m/s]; 0, or the middle between stops that leave
///                        0 out; of a joint that mimics another as that one has it
/// Scene::unused says what of the file does not enter.
/// Throws std::invalid_argument with "FILE:LINE:COLUMN: what was found, what is allowed", if `set` names a parameter that is
/// none of these, and where perp was built without urdfdom.
[[nodiscard]] Scene read_urdf(std::string_view text, const std::string& file,
                              const SceneParameters& set = {});

}  // namespace perp
