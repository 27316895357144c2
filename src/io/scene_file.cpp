#include "perp/io/scene_file.hpp"

namespace perp {

Scene load_scene(const std::string& name_or_file, const SceneParameters& set) {
  return scene(name_or_file, set);
}

}  // namespace perp
