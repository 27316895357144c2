// [[shape]], [[material_pair]] and [[no_contact]] of scene files.
#pragma once

#include <optional>

#include "io/scene_table.hpp"
#include "perp/study/scene.hpp"

namespace perp {

/// A [[shape]] before its body is there.
struct SceneShape {
  SceneTable table;
  std::string body;
  Shape shape;
  ShapeOptions options;
  std::optional<double> density;
};

/// All of the file. Kinds of planar shapes belong to planar bodies, and to what never moves beside these alone.
std::vector<SceneShape> read_shapes(const SceneTable& root);

/// Mass and inertia of a body by its shapes' densities; refuses at `body` where no shape has one, or where the centre of mass is not
/// the body's origin.
MassProperties mass_by_shapes(const std::vector<SceneShape>& shapes, const SceneTable& body);

/// Gives the model its shapes, reads [[no_contact]] and [[material_pair]]; returns the contacts that were left out because they overlap at
/// `start`, where the file asks for that.
std::vector<std::string> add_shapes(const SceneTable& root, const std::vector<SceneShape>& shapes,
                                    const State& start, Model& model);

/// The same tables of a model. `cannot_say` refuses what no file says.
std::string write_shapes(const Model& model, const std::function<void(const std::string&)>& cannot_say);

}  // namespace perp
