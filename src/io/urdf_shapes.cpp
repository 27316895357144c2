#include "io/urdf_shapes.hpp"

#include <algorithm>
#include <filesystem>
#include <map>
#include <optional>

#include "io/mesh_file.hpp"
#include "model/pairs/shape_geometry.hpp"
#include "perp/core/errors.hpp"

namespace perp {
namespace {

using Kind = UrdfShape::Kind;

/// Where a mesh's URI points to: a path from the robot's folder; of package://NAME/REST the folder of that name is looked for above it.
std::filesystem::path mesh_path(const std::string& robot, std::string uri) {
  namespace fs = std::filesystem;
  const std::string file = "file://", package = "package://";
  if (uri.starts_with(file)) uri = uri.substr(file.size());
  fs::path folder = fs::path(robot).parent_path();
  if (!uri.starts_with(package)) return folder / uri;
  const std::string rest = uri.substr(package.size());
  const std::string inside = rest.substr(std::min(rest.size(), rest.find('/') + 1));
  constexpr int levels = 5;
  std::error_code none;
  fs::path above = folder.empty() ? fs::path(".") : folder;
  for (int k = 0; k < levels; ++k, above = above / "..")
    for (const std::string& place : {rest, inside})
      if (fs::is_regular_file(above / place, none)) return above / place;
  return folder / rest;
}

class RobotShapes {
 public:
  RobotShapes(const std::string& file, Model& model) : file_(file), model_(model) {}

  void add(const PlacedShape& s) {
    Pose X = s.X_BS;
    const std::optional<Shape> shape = made(s, X);
    if (!shape) {
      lost_.push_back(&s);
      return;
    }
    const ShapeGeometry geometry(*shape, X);
    for (const BodyShape& other : model_.shapes()) {
      const bool known = ShapePair(*other.geometry, geometry).known();
      if (known || other.body == s.body || joined(other.body, s.body)) continue;
      ++without_gap_[std::string(other.shape.name()) + " and " + std::string(shape->name())];
      model_.no_contact(other.body, s.body);
    }
    at_line(file_, s.line, "collision shape '" + s.name + "'", [&] {
      return model_.add_shape(s.body, *shape, {.pose = X, .material = "robot", .name = s.name});
    });
  }

  std::vector<UrdfUnused> finish() {
    for (const auto& [kinds, count] : without_gap_)
      unused_.push_back({0, std::to_string(count) + (count == 1 ? " pair" : " pairs") +
                                " of collision shapes, and contacts of their bodies: there is no gap of " +
                                kinds});
    for (const PlacedShape* s : lost_) {
      const auto on_body = [&](const BodyShape& other) { return other.body == s->body; };
      if (std::none_of(model_.shapes().begin(), model_.shapes().end(), on_body))
        unused_.push_back({s->line, "body '" + model_.body(s->body).name +
                                        "' in contacts: it is left without any shape, and meets nothing"});
    }
    return std::move(unused_);
  }

 private:
  bool joined(BodyId a, BodyId b) const {
    return std::any_of(model_.joints().begin(), model_.joints().end(), [&](const JointGeometry& j) {
      return (j.a == a && j.b == b) || (j.a == b && j.b == a);
    });
  }

  std::optional<Shape> made(const PlacedShape& s, Pose& X) {
    const Vector3& size = s.shape.size;
    if (s.shape.kind == Kind::Mesh) return hull(s, X);
    return at_line(file_, s.line, "collision shape '" + s.name + "'", [&]() -> std::optional<Shape> {
      switch (s.shape.kind) {
        case Kind::Sphere:
          return Shape::sphere(size.x());
        case Kind::Box:
          return Shape::box(size);
        case Kind::Capsule:
          return Shape::capsule(size.x(), size.y());
        default:
          return Shape::cylinder(size.x(), size.y());
      }
    });
  }

  /// The convex hull of a mesh, of a few dozen corners: what it adds is said. Empty, and said, of what is no solid.
  std::optional<Shape> hull(const PlacedShape& s, Pose& X) {
    constexpr int most_corners = 40;  // pairs of its edges are all looked at
    const auto refused = [&](const std::string& why) {
      unused_.push_back({s.line, "mesh '" + s.shape.file + "' of link '" + s.name + "': " + why});
      return std::nullopt;
    };
    if (!((s.shape.size.array() > 0).all()))
      return refused("a scale that is not positive, which mirrors it or leaves nothing");
    try {
      TriangleMesh mesh = read_mesh(mesh_path(file_, s.shape.file));
      for (Vector3& x : mesh.points) x = x.cwiseProduct(s.shape.size);
      const std::vector<Vector3> corners = outermost(mesh.points, most_corners);
      Shape shape = Shape::polyhedron(corners);
      X = X * Pose{shape.centre(), Quaternion::Identity()};
      const double volume = mesh.volume(), added = volume > 0 ? shape.volume() / volume - 1 : not_set;
      const std::string change = std::isnan(added)
                                     ? "a volume where the mesh has none"
                                     : shortest(std::round(1000 * added) / 10) + " % more volume";
      if (corners.size() < mesh.points.size() || !(std::abs(added) < 1e-6))
        unused_.push_back({s.line, "hollows and details of mesh '" + s.shape.file + "' of link '" + s.name +
                                       "': its hull has " + std::to_string(shape.vertices().size()) +
                                       " corners of " + std::to_string(mesh.points.size()) + " points, and " +
                                       change});
      return shape;
    } catch (const std::invalid_argument& error) {
      return refused(error.what());
    }
  }

  const std::string& file_;
  Model& model_;
  std::vector<UrdfUnused> unused_;
  std::map<std::string, int> without_gap_;
  std::vector<const PlacedShape*> lost_;
};

}  // namespace

std::vector<UrdfUnused> add_robot_shapes(const std::vector<PlacedShape>& shapes, const std::string& file,
                                         Model& model) {
  RobotShapes robot(file, model);
  for (const PlacedShape& s : shapes) robot.add(s);
  return robot.finish();
}

}  // namespace perp
