// A scene as the text of a file: numbers alone, in the reader's words and the model's order.
#include <algorithm>
#include <cmath>

#include "io/scene_events.hpp"
#include "io/scene_gaps.hpp"
#include "io/scene_joints.hpp"
#include "io/scene_motions.hpp"
#include "io/scene_shapes.hpp"
#include "io/scene_text.hpp"
#include "io/scene_words.hpp"
#include "perp/core/errors.hpp"
#include "perp/io/scene_file.hpp"

namespace perp {
namespace {

[[noreturn]] void cannot_say(const Scene& scene, const std::string& what) {
  refuse("scene '" + scene.name + "'", what, "a function of its own", "which no file can say");
}

template <class V, class W>
bool same(const V& a, const W& b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(), same_bits);
}

bool zero(const Vector3& v) { return same(v, Vector3::Zero().eval()); }

std::array<double, 4> wxyz(const Quaternion& q) { return {q.w(), q.x(), q.y(), q.z()}; }

class SceneWriter {
 public:
  explicit SceneWriter(const Scene& scene) : scene_(scene), model_(scene.model) {}

  std::string text() {
    line("name", in_quotes(scene_.name));
    line("what", in_quotes(what()));
    line("t_end", shortest(scene_.t_end));
    line("gravity", written(model_.gravity()));
    for (int i = 1; i < static_cast<int>(model_.bodies().size()); ++i) body({i});
    const auto refused = [&](const std::string& what) { cannot_say(scene_, what); };
    out_ += write_joints(model_, refused);
    for (const Spring& s : model_.springs()) spring(s);
    for (std::size_t i = 0; i < model_.contacts().size(); ++i) contact(model_.contacts()[i], i);
    out_ += write_shapes(model_, refused);
    for (const BodyForce& force : model_.forces()) {
      if (!force.recipe.known()) cannot_say(scene_, "force on '" + model_.body(force.body).name + "'");
      out_ += "\n[[force]]\n" + write_force(model_, force);
    }
    for (const UserEvent& event : scene_.events) {
      if (!event.recipe.known()) cannot_say(scene_, "event '" + event.name + "'");
      out_ += "\n[[event]]\n" + write_event(event);
    }
    for (const auto& [method, settings] : scene_.method_settings) {
      out_ += "\n[method." + method + "]\n";
      for (const auto& [key, value] : settings) line(key, value);
    }
    return std::move(out_);
  }

 private:
  void line(std::string_view key, std::string_view value) {
    out_.append(key).append(" = ").append(value).append("\n");
  }
  void line(std::string_view key, const Vector3& v) { line(key, written(v)); }
  void line(std::string_view key, double x) { line(key, shortest(x)); }

  std::string what() const {
    std::string values;
    for (const SceneParameter& p : scene_.parameters)
      values += (values.empty() ? "" : ", ") + p.name + " = " + shortest(p.value);
    return values.empty() ? scene_.what : scene_.what + " (" + values + ")";
  }

  void body(BodyId id) {
    const Body& b = model_.body(id);
    if (b.kind == BodyKind::Generalized) cannot_say(scene_, "body '" + b.name + "'");
    out_ += "\n[[body]]\n";
    if (b.name != "body " + std::to_string(id.index)) line("name", in_quotes(b.name));
    line("kind", in_quotes(scene_words::name_of(scene_words::body_kinds, b.kind)));
    if (b.kind == BodyKind::Prescribed) return prescribed(b);
    line("mass", b.mass);
    if (b.kind == BodyKind::Spatial) line("inertia", inertia(b.J));
    if (b.kind == BodyKind::Planar) line("inertia", b.J(2, 2));
    pose(b.rest);
    start(b);
    velocity(id, b);
  }

  void prescribed(const Body& b) {
    if (!b.motion.recipe.known()) cannot_say(scene_, "motion of '" + b.name + "'");
    pose(pose_of_motion(b.motion.recipe));
    const std::string motion = write_motion(b.motion.recipe);
    if (!motion.empty()) line("motion", motion);
  }

  void pose(const Pose& X) {
    line("position", X.p);
    if (!same(wxyz(X.q), wxyz(Quaternion::Identity()))) line("orientation", written(wxyz(X.q)));
  }

  static std::string inertia(const Matrix3& J) {
    InlineTable table;
    if (same(J.reshaped(), Matrix3(J.diagonal().asDiagonal()).reshaped()))
      table.add("moments", written(Vector3(J.diagonal())));
    else
      table.add("tensor", "[" + written(Vector3(J.row(0))) + ", " + written(Vector3(J.row(1))) + ", " +
                              written(Vector3(J.row(2))) + "]");
    return table.text();
  }

  /// What of the start is not the place at rest.
  void start(const Body& b) {
    const State rest = model_.rest();
    const auto now = scene_.start.q.segment(b.q0, b.nq), then = rest.q.segment(b.q0, b.nq);
    const int n = b.kind == BodyKind::Planar ? 2 : 3;  // coordinates of place; orientation follows
    InlineTable table;
    if (!same(now.head(n), then.head(n)))
      table.add("position", written(std::span(now.data(), static_cast<std::size_t>(n))));
    if (!same(now.tail(b.nq - n), then.tail(b.nq - n)))
      table.add(n == 2 ? "angle" : "orientation",
                written(std::span(now.data() + n, static_cast<std::size_t>(b.nq - n))));
    if (table.text() != "{}") line("start", table.text());
  }

  void velocity(BodyId id, const Body& b) {
    const auto nu = scene_.start.nu.segment(b.v0, b.nv);
    if (b.kind == BodyKind::Planar) {
      if (!zero({nu[0], nu[1], 0})) line("velocity", written(std::span(nu.data(), 2)));
      if (!same_bits(nu[2], 0)) line("angular_velocity", nu[2]);
      return;
    }
    if (!zero(nu.head<3>())) line("velocity", Vector3(nu.head<3>()));
    if (b.kind == BodyKind::Particle || zero(nu.tail<3>())) return;
    State again = scene_.start;  // in world axes if that gives the same bits
    const Vector3 w = model_.angular_velocity(again, id);
    model_.set_velocity(again, id, nu.head<3>(), w);
    if (same(again.nu.segment(b.v0, 6), nu))
      line("angular_velocity", w);
    else
      line("angular_velocity_body", Vector3(nu.tail<3>()));
  }

  void connects(BodyId a, BodyId b) {
    line("a", in_quotes(model_.body(a).name));
    line("b", in_quotes(model_.body(b).name));
  }

  void spring(const Spring& spring) {
    out_ += "\n[[spring]]\n";
    connects(spring.a, spring.b);
    line("point_a", spring.point_a);
    line("point_b", spring.point_b);
    line("stiffness", spring.stiffness);
    line("damping", spring.damping);
    line("length", spring.length);
  }

  static std::string axes(const FrictionAxes& axes) {
    InlineTable table;
    table.add("mu", written(std::span(axes.mu.data(), 2)));
    table.add("axes_of", in_quotes(axes.of == FrictionAxes::Of::A ? "a" : "b"));
    table.add("t", written(axes.t));
    return table.text();
  }

  void contact(const Contact& contact, std::size_t i) {
    if (contact.stop.joint >= 0) return;  // said by its joint's limit
    if (!contact.gap.recipe().known()) cannot_say(scene_, "gap of contact '" + contact.name + "'");
    out_ += "\n[[contact]]\n";
    const bool numbered = model_.shapes().empty() && contact.name == "contact " + std::to_string(i + 1);
    if (!numbered) line("name", in_quotes(contact.name));
    connects(contact.a, contact.b);
    line("gap", write_gap(contact.gap.recipe()));
    if (contact.mu != 0 && !contact.friction_axes) line("mu", contact.mu);
    if (contact.torsion != 0) line("torsion", contact.torsion);
    if (contact.rolling != 0) line("rolling", contact.rolling);
    if (contact.friction_axes) line("friction_axes", axes(*contact.friction_axes));
    if (contact.e != 0) line("e", contact.e);
    if (!zero(contact.tangent)) line("tangent", contact.tangent);
    if (contact.compliance != 1) line("compliance", contact.compliance);
  }

  const Scene& scene_;
  const Model& model_;
  std::string out_;
};

}  // namespace

std::string write_scene(const Scene& scene) { return SceneWriter(scene).text(); }

}  // namespace perp
