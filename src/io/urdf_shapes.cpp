#include "io/urdf_shapes.hpp"

#include <algorithm>
#include <map>

#include "perp/model/gaps.hpp"

namespace perp {
namespace {

using Kind = UrdfShape::Kind;

class ShapeContacts {
 public:
  ShapeContacts(const ShapeContactOptions& options, const std::string& file, Model& model)
      : options_(options), file_(file), model_(model) {}

  void on_floor(const PlacedShape& s) {
    const Vector3& size = s.shape.size;
    switch (s.shape.kind) {
      case Kind::Sphere:
        return add(ground, s, s.name, [&] { return placed(sphere_on_plane(size.x()), {}, s.X_BS); });
      case Kind::Box:
        return add(ground, s, s.name, [&] { return placed(box_on_plane(size), {}, s.X_BS); });
      case Kind::Cylinder:
        for (const double side : {-0.5, 0.5})
          add(ground, s, s.name + (side < 0 ? "-bottom" : "-top"), [&] {
            return placed(disc_on_plane(size.x()), {},
                          s.X_BS * Pose{{0, 0, side * size.y()}, Quaternion::Identity()});
          });
    }
  }

  void between(const PlacedShape& first, const PlacedShape& second) {
    if (first.body == second.body || first.carrier == second.body || second.carrier == first.body) return;
    const bool box_first = first.shape.kind == Kind::Box;
    const PlacedShape &a = box_first ? first : second,
                      &b = box_first ? second : first;  // a box is the gap's A
    const bool cylinder = a.shape.kind == Kind::Cylinder || b.shape.kind == Kind::Cylinder;
    if (cylinder) {
      ++left_out["cylinders meet the floor alone"];
      return;
    }
    const double r = b.shape.size.x();
    const auto shapes = [&] {
      if (b.shape.kind == Kind::Box) return box_on_box(a.shape.size, b.shape.size);
      return a.shape.kind == Kind::Box ? sphere_on_box(r, a.shape.size)
                                       : sphere_on_sphere(a.shape.size.x(), r);
    };
    const Gap gap = at_line(file_, b.line, b.name, shapes);
    std::vector<ContactPoint> now(static_cast<std::size_t>(gap.points()));
    gap(a.X_WS_start, b.X_WS_start, 0, now);
    if (std::any_of(now.begin(), now.end(),
                    [&](const ContactPoint& c) { return c.gap < -1e-9 * a.shape.size.maxCoeff(); })) {
      unused.push_back(
          {b.line, "contact of '" + a.name + "' with '" + b.name + "': they overlap at the start"});
      return;
    }
    add(a.body, b, a.name + "-" + b.name, [&] { return placed(shapes(), a.X_BS, b.X_BS); });
  }

  std::vector<UrdfUnused> unused;
  std::map<std::string, int> left_out;  ///< pairs for which there is no gap

 private:
  template <class Make>
  void add(BodyId a, const PlacedShape& b, const std::string& name, Make make) {
    at_line(file_, b.line, "collision shape '" + name + "'", [&] {
      return model_.add_contact(a, b.body, make(), {.mu = options_.mu, .e = options_.e, .name = name});
    });
  }

  const ShapeContactOptions& options_;
  const std::string& file_;
  Model& model_;
};

}  // namespace

std::vector<UrdfUnused> add_shape_contacts(const std::vector<PlacedShape>& shapes,
                                           const ShapeContactOptions& options, const std::string& file,
                                           Model& model) {
  ShapeContacts contacts(options, file, model);
  for (const PlacedShape& s : shapes)
    if (options.floor && s.body != ground) contacts.on_floor(s);
  for (std::size_t i = 0; i < shapes.size(); ++i)
    for (std::size_t k = i + 1; k < shapes.size(); ++k) contacts.between(shapes[i], shapes[k]);
  for (const auto& [why, count] : contacts.left_out)
    contacts.unused.push_back(
        {0, std::to_string(count) + (count == 1 ? " pair" : " pairs") + " of collision shapes: " + why});
  return contacts.unused;
}

}  // namespace perp
