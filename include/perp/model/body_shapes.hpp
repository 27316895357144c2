// What the bodies of a model look like: shapes at places in bodies, and what materials do to each other.
#pragma once

#include <memory>
#include <string>

#include "perp/model/body.hpp"
#include "perp/model/shape.hpp"

namespace perp {

struct ShapeGeometry;

/// Handle of a shape in the Model that it was given to.
struct ShapeId {
  int index = 0;
  friend bool operator==(ShapeId, ShapeId) = default;
};

struct ShapeOptions {
  Pose pose = {};             ///< X_BS
  std::string material = {};  ///< decides friction and restitution, by Model::set_friction
  std::string name = {};      ///< its kind, or KIND-2, ... on this body, if empty
};

/// A body of one shape, which sits at the body's origin along its axes.
struct ShapeBodyOptions {
  double density = 0;  ///< [kg/m^3]; of planar shapes [kg/m^2]
  std::string material = {};
  std::string name = {};  ///< of the body, as in BodyOptions
  Pose pose = {};         ///< likewise
};

/// Of one material on another.
struct MaterialPair {
  double mu = 0;       ///< Coulomb friction [-]
  double torsion = 0;  ///< ContactOptions::torsion [m]
  double rolling = 0;  ///< ContactOptions::rolling [m]
  double e = 0;        ///< Newton's restitution, in [0, 1]
};

/// A shape as the model keeps it.
struct BodyShape {
  BodyId body;
  Shape shape;
  Pose pose;  ///< X_BS
  std::string material, name;
  int material_number;                            ///< of `material` among the model's
  std::shared_ptr<const ShapeGeometry> geometry;  ///< as pairs look at it
};

}  // namespace perp
