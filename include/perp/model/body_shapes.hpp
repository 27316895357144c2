// What the bodies of a model look like, and the contacts that this makes.
#pragma once

#include <map>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "perp/model/model.hpp"
#include "perp/model/shape.hpp"

namespace perp {

struct ShapeOptions {
  Pose pose = {};             ///< X_BS
  std::string material = {};  ///< decides friction and restitution, by set_friction
  std::string name = {};      ///< its kind, or KIND-2, ... on this body, if empty
};

/// Of one material on another.
struct MaterialPair {
  double mu = 0;       ///< Coulomb friction [-]
  double torsion = 0;  ///< ContactOptions::torsion [m]
  double rolling = 0;  ///< ContactOptions::rolling [m]
  double e = 0;        ///< Newton's restitution, in [0, 1]
};

/// The shapes of a model's bodies. Once the model has its bodies and joints, add_contacts gives it a contact for every pair of shapes that
/// may meet: on different bodies, one of which moves, that no joint joins and that are not listed by no_contact. A contact is called
/// BODY.SHAPE|BODY.SHAPE, the body that the model has first in front, its points that and |NUMBER of the feature (nothing where there is
/// one). Every function throws std::invalid_argument naming what it cannot take.
class BodyShapes {
 public:
  struct Placed {
    BodyId body;
    Shape shape;
    Pose pose;  ///< X_BS
    std::string material, name;
  };

  void add(const Model& model, BodyId body, const Shape& shape, ShapeOptions options = {});
  /// Friction and restitution of shapes of two materials on each other, in either order; without it they have neither.
  void set_friction(const std::string& material_a, const std::string& material_b, const MaterialPair& pair);
  void no_contact(BodyId a, BodyId b);
  /// Leaves out the pairs of shapes that overlap at x, and only these; returns their contacts' names.
  std::vector<std::string> leave_out_overlapping(const Model& model, const State& x);

  void add_contacts(Model& model) const;

  const std::vector<Placed>& all() const { return shapes_; }

 private:
  using Pair = std::pair<int, int>;  // indices in shapes_, the first on the body of lower number
  std::vector<Pair> pairs(const Model& model) const;
  std::string name(const Model& model, const Pair& pair) const;
  Gap gap(const Pair& pair) const;

  std::vector<Placed> shapes_;
  std::map<std::pair<std::string, std::string>, MaterialPair> materials_;  // names ascending
  std::set<std::pair<int, int>> apart_;                                    // bodies, ascending
  std::set<Pair> left_out_;
};

}  // namespace perp
