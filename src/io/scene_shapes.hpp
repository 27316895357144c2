// [[shape]], [[material_pair]] and [[no_contact]] of scene files.
#pragma once

#include <optional>

#include "io/scene_table.hpp"

namespace perp {

/// A [[shape]] before its body is there.
struct SceneShape {
  SceneTable table;
  std::string body;
  Shape shape;
  ShapeOptions options;
  std::optional<double> density;
};

/// All of the file; `planar` are the names of its planar bodies, `all_planar`: whether nothing in space moves.
std::vector<SceneShape> read_shapes(const SceneTable& root);

/// Mass and inertia of a body by its shapes' densities; refuses at `body` where no shape has one, or where the centre of mass is not
/// the body's origin.
MassProperties mass_by_shapes(const std::vector<SceneShape>& shapes, const SceneTable& body);

void read_material_pair(const SceneTable& table, Model& model);

/// The tables of a model's shapes and materials.
std::string write_shapes(const Model& model);

}  // namespace perp
