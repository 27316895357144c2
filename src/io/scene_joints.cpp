#include "io/scene_joints.hpp"

#include <algorithm>
#include <array>

#include "io/expression_timing.hpp"
#include "io/scene_text.hpp"
#include "io/scene_words.hpp"
#include "perp/core/errors.hpp"

namespace perp {
namespace {

/// Which coordinate of which joint a table is about: keys `joint` and, where the joint has several, `coordinate`.
struct JointPlace {
  JointId joint;
  int coordinate = 0;
  JointFreedom freedom = JointFreedom::Rotation;

  bool turns() const { return freedom == JointFreedom::Rotation; }
  Dimension dimension() const { return turns() ? Dimension::Angle : Dimension::Length; }
};

JointPlace read_place(const SceneTable& table, const Model& model) {
  std::vector<std::string> names, coordinates;
  for (const JointGeometry& j : model.joints()) names.push_back(j.name);
  JointPlace place;
  place.joint.index = static_cast<int>(table.word("joint", names));
  const JointGeometry& joint = model.joint(place.joint);
  for (const JointCoordinate& c : joint.coordinates) coordinates.emplace_back(c.name);
  if (coordinates.empty())
    table.refuse("joint", "the joint '" + joint.name + "'", "needs one that has a coordinate");
  if (coordinates.size() > 1 || table.has("coordinate"))
    place.coordinate = static_cast<int>(table.word("coordinate", coordinates));
  place.freedom = joint.coordinates[static_cast<std::size_t>(place.coordinate)].freedom;
  return place;
}

}  // namespace

void read_joint(const SceneTable& table, Model& model) {
  table.allow({"name", "kind", "a", "b", "point", "axis", "axis_b", "point_b", "lead", "ratio",
               "friction"});  // of some kind; below of its own
  const std::vector<std::string> kinds = scene_words::names(scene_words::joint_kinds);
  Joint joint;
  joint.kind = scene_words::joint_kinds[table.word("kind", kinds)].second;
  std::vector<std::string> keys{"name", "kind", "a", "b", "point"};
  const bool rod = joint.kind == JointKind::Rod, screws = joint.kind == JointKind::Screw,
             geared = joint.kind == JointKind::Gear;
  if (!rod) keys.emplace_back("axis");
  if (rod) keys.emplace_back("point_b");
  if (screws) keys.emplace_back("lead");
  if (geared) keys.emplace_back("ratio");
  if (geared || joint.kind == JointKind::Universal) keys.emplace_back("axis_b");
  keys.emplace_back("friction");
  table.allow(keys);
  joint.a = table.body("a");
  joint.b = table.body("b");
  JointOptions& options = joint.options;
  options.name = table.name();
  options.point = table.vector("point", Dimension::Length, options.point);
  options.point_b = table.vector("point_b", Dimension::Length, options.point_b);
  options.axis = table.vector("axis", Dimension::None, options.axis);
  options.axis_b = table.vector("axis_b", Dimension::None, options.axis_b);
  if (screws) options.lead = table.number("lead", Dimension::Length);
  if (geared) options.ratio = table.number("ratio", Dimension::None);
  const bool slides = joint.kind == JointKind::Prismatic;
  if (table.has("friction") && table.toml().find("friction")->value.kind == TomlValue::Kind::List)
    options.frictions = table.numbers("friction", 1, 3, Dimension::Any);  // [N m] of angles, [N] of slides
  else
    options.friction = table.number("friction", slides ? Dimension::Force : Dimension::Moment, 0);
  table.placed([&] { return model.add_joint(joint); });
}

void read_limit(const SceneTable& table, Model& model) {
  table.allow({"joint", "coordinate", "lower", "upper", "e"});
  const JointPlace place = read_place(table, model);
  JointLimit limit{.coordinate = place.coordinate};
  limit.lower = table.number("lower", place.dimension(), limit.lower);
  limit.upper = table.number("upper", place.dimension(), limit.upper);
  limit.e = table.number("e", Dimension::None, 0);
  table.placed([&] {
    model.add_limit(place.joint, limit);
    return 0;
  });
}

void read_motor(const SceneTable& table, Model& model) {
  table.allow({"joint", "coordinate", "effort", "motion"});
  const JointPlace place = read_place(table, model);
  if (table.has("effort") == table.has("motion"))
    table.refuse("effort", table.has("effort") ? "an effort beside a motion" : "neither effort nor motion",
                 "needs one of the two");
  if (table.has("effort")) {
    const Dimension dimension = place.turns() ? Dimension::Moment : Dimension::Force;
    const Expression effort = table.expression("effort", {"t", "coordinate", "rate"}, dimension);
    using Effort = Timed<double(const Model&, const State&, double, double)>;
    const Effort value(
        [effort](const Model&, const State& x, double coordinate, double rate) {
          return effort(std::array{x.t, coordinate, rate});
        },
        timing_of(std::span(&effort, 1), [place](const Model& m, const State& x) {
          return std::vector{x.t, m.coordinate(x, place.joint, place.coordinate),
                             m.coordinate_rate(x, place.joint, place.coordinate)};
        }));
    table.placed([&] {
      model.add_motor({.joint = place.joint,
                       .effort = value,
                       .coordinate = place.coordinate,
                       .recipe = {"expression", {}, {effort.text()}}});
      return 0;
    });
    return;
  }
  const Expression path = table.expression("motion", {"t"}, place.dimension());
  if (path.may_jump())
    table.refuse("motion", "the expression \"" + path.text() + "\" with a step",
                 "a motion needs to be continuous");
  const JointMotion motion{
      .position = [path](double t) { return path(std::array{t}); },
      .rate = Timed<double(double)>([path](double t) { return path.derivative(std::array{t}, 0); },
                                    timing_of(std::span(&path, 1), {})),
      .acceleration = {},
      .recipe = {"expression", {}, {path.text()}}};
  table.placed([&] {
    model.add_motion(place.joint, motion, place.coordinate);
    return 0;
  });
}

void read_joint_spring(const SceneTable& table, Model& model) {
  table.allow({"joint", "coordinate", "stiffness", "damping", "rest"});
  const JointPlace place = read_place(table, model);
  JointSpring spring{.joint = place.joint, .coordinate = place.coordinate};
  spring.stiffness = table.number("stiffness", place.turns() ? Dimension::Moment : Dimension::Stiffness, 0);
  spring.damping = table.number("damping", place.turns() ? Dimension::None : Dimension::Damping, 0);
  spring.rest = table.number("rest", place.dimension(), 0);
  table.placed([&] {
    model.add_joint_spring(spring);
    return 0;
  });
}

namespace {

class JointWriter {
 public:
  JointWriter(const Model& model, const std::function<void(const std::string&)>& cannot_say)
      : model_(model), cannot_say_(cannot_say) {}

  std::string text() {
    for (std::size_t i = 0; i < model_.joints().size(); ++i) joint(model_.joints()[i], i);
    for (std::size_t i = 0; i < model_.contacts().size(); ++i) i = limit(i);
    for (int i = 0; i < static_cast<int>(model_.joints().size()); ++i) motions({i});
    for (const JointMotor& motor : model_.motors()) {
      if (!motor.recipe.known()) cannot_say_("motor of joint '" + model_.joint(motor.joint).name + "'");
      begin("motor", motor.joint, motor.coordinate);
      line("effort", in_quotes(motor.recipe.texts[0]));
    }
    for (const JointSpring& spring : model_.joint_springs()) {
      begin("joint_spring", spring.joint, spring.coordinate);
      line("stiffness", shortest(spring.stiffness));
      line("damping", shortest(spring.damping));
      line("rest", shortest(spring.rest));
    }
    return std::move(out_);
  }

 private:
  void line(std::string_view key, std::string_view value) {
    out_.append(key).append(" = ").append(value).append("\n");
  }

  void begin(const char* table, JointId joint, int coordinate) {
    const JointGeometry& j = model_.joint(joint);
    out_ += "\n[[" + std::string(table) + "]]\n";
    line("joint", in_quotes(j.name));
    if (j.coordinates.size() > 1)
      line("coordinate", in_quotes(j.coordinates[static_cast<std::size_t>(coordinate)].name));
  }

  void joint(const JointGeometry& joint, std::size_t i) {
    out_ += "\n[[joint]]\n";
    if (joint.name != "joint " + std::to_string(i + 1)) line("name", in_quotes(joint.name));
    line("kind", in_quotes(scene_words::name_of(scene_words::joint_kinds, joint.kind)));
    line("a", in_quotes(model_.body(joint.a).name));
    line("b", in_quotes(model_.body(joint.b).name));
    line("point", written(joint.asked.point));
    if (joint.kind == JointKind::Rod) return line("point_b", written(joint.asked.point_b));
    line("axis", written(joint.asked.axis));
    if (!joint.asked.axis_b.isZero(0)) line("axis_b", written(joint.asked.axis_b));
    if (joint.kind == JointKind::Screw) line("lead", shortest(joint.asked.lead));
    if (joint.kind == JointKind::Gear) line("ratio", shortest(joint.asked.ratio));
    if (joint.asked.friction > 0) line("friction", shortest(joint.asked.friction));
    if (!joint.asked.frictions.empty())
      line("friction", written(std::span<const double>(joint.asked.frictions)));
  }

  void motions(JointId id) {
    const JointGeometry& joint = model_.joint(id);
    for (std::size_t i = 0; i < joint.motions.size(); ++i) {
      if (!joint.motions[i]) continue;
      if (!joint.motions[i]->recipe.known()) cannot_say_("motion of joint '" + joint.name + "'");
      begin("motor", id, static_cast<int>(i));
      line("motion", in_quotes(joint.motions[i]->recipe.texts[0]));
    }
  }

  /// A stop and the upper one that goes with it; the index of the last contact that was said.
  std::size_t limit(std::size_t i) {
    const Contact& contact = model_.contacts()[i];
    const Contact::Stop& stop = contact.stop;
    if (stop.joint < 0) return i;
    begin("limit", {stop.joint}, stop.coordinate);
    line(stop.side > 0 ? "lower" : "upper", shortest(stop.limit));
    if (contact.e != 0) line("e", shortest(contact.e));
    if (stop.side < 0 || i + 1 == model_.contacts().size()) return i;
    const Contact& next = model_.contacts()[i + 1];
    const bool pair = next.stop.joint == stop.joint && next.stop.coordinate == stop.coordinate &&
                      next.stop.side < 0 && next.e == contact.e;
    if (!pair) return i;
    line("upper", shortest(next.stop.limit));
    return i + 1;
  }

  const Model& model_;
  const std::function<void(const std::string&)>& cannot_say_;
  std::string out_;
};

}  // namespace

std::string write_joints(const Model& model, const std::function<void(const std::string&)>& cannot_say) {
  return JointWriter(model, cannot_say).text();
}

}  // namespace perp
