// Scenes as files: a model, its start and its parameters in TOML. doc/scene-files.md is the schema, with examples.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>

#include "perp/study/scene.hpp"

namespace perp {

struct UserEvent;

/// What SCENE means wherever perp asks for one: the built-in scene of that name, or the scene file or robot (.urdf) of
/// that path, with some of its parameters set. Throws std::invalid_argument: of a file as read_scene or read_urdf does, of a built-in scene as
/// scene() does.
[[nodiscard]] Scene load_scene(const std::string& name_or_file, const SceneParameters& set = {});

/// The scene that `text` describes; `file` is what messages call it, and its stem the scene's name if it gives none.
/// Throws std::invalid_argument with "FILE:LINE:COLUMN: what was found, what is allowed" for the first thing that is
/// not a scene, and if `set` names a parameter that the file does not have. A scene is read whole or not at all.
[[nodiscard]] Scene read_scene(std::string_view text, const std::string& file,
                               const SceneParameters& set = {});

/// What a scene file looks out for, its tables [[event]], for SimulateOptions::events; nothing of a built-in scene or a robot.
[[nodiscard]] std::vector<UserEvent> load_events(const std::string& name_or_file,
                                                 const SceneParameters& set = {});
[[nodiscard]] std::vector<UserEvent> read_events(std::string_view text, const std::string& file,
                                                 const SceneParameters& set = {});

/// The text that read_scene makes the same model and start of, to the last bit, and write_scene the same text again;
/// all in numbers, the parameters' values said in `what`. Throws std::invalid_argument naming what no file can say: a
/// gap, a motion or a force that was made from a function of one's own.
[[nodiscard]] std::string write_scene(const Scene& scene);

}  // namespace perp
