#include "perp/io/urdf.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <numeric>

#include "io/names.hpp"
#include "io/toml_file.hpp"
#include "io/urdf_groups.hpp"
#include "io/urdf_shapes.hpp"
#include "perp/core/errors.hpp"

namespace perp {
namespace {

using Kind = UrdfJoint::Kind;

/// A group of links as a body of the model, or part of the ground.
struct Group : UrdfGroup {
  BodyId body = ground;
  Pose X_WG = {}, X_WG_start = {};  ///< of its frame, at rest() and at the start
  Twist V = {};                     ///< at the start, of the frame's origin
};

bool slides(Kind kind) { return kind == Kind::Prismatic; }
bool one_freedom(Kind kind) { return kind == Kind::Revolute || kind == Kind::Continuous || slides(kind); }

/// As names in perp's files have them.
std::string fitting(std::string name) {
  for (char& c : name) {
    const bool fits =
        (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_' || c == '-';
    if (!fits) c = '_';
  }
  return name;
}

class Builder {
 public:
  Builder(UrdfRobot robot, const std::string& file, const SceneParameters& set)
      : robot_(std::move(robot)), file_(file), set_(set) {
    for (UrdfUnused& u : robot_.unused) unused(u.line, std::move(u.what));
  }

  Scene scene() {
    scene_.name = fitting(robot_.name);
    scene_.what = "the robot '" + robot_.name + "'";
    read_base();
    gather();
    read_starts();
    place(1);
    for (Group& g : groups_) add_body(g);
    for (const UrdfJoint& j : robot_.joints) add_joint(j);
    for (const UrdfJoint& j : robot_.joints) add_mimic(j);
    add_shapes();
    start();
    part_overlapping();
    for (const auto& [name, value] : set_) need_parameter(name);
    std::stable_sort(unused_.begin(), unused_.end(),
                     [](const UrdfUnused& a, const UrdfUnused& b) { return a.line < b.line; });
    for (const UrdfUnused& u : unused_)
      scene_.unused.push_back((u.line > 0 ? file_ + ":" + std::to_string(u.line) : file_) + ": " + u.what);
    return std::move(scene_);
  }

 private:
  Model& model() { return scene_.model; }
  const UrdfLink& link(int i) const { return robot_.links[static_cast<std::size_t>(i)]; }
  Group& group_of(int i) { return groups_[static_cast<std::size_t>(group_[static_cast<std::size_t>(i)])]; }
  void unused(int line, std::string what) { unused_.push_back({line, std::move(what)}); }

  /// make(), its refusals placed where the joint stands.
  template <class Make>
  auto at(const UrdfJoint& j, Make make) const {
    return at_line(file_, j.line, "joint '" + j.name + "'", make);
  }

  double parameter(const std::string& name, double otherwise, const std::string& what) {
    SceneParameter p{.name = name, .value = otherwise, .what = what};
    if (const auto given = set_.find(name); given != set_.end()) {
      if (!std::isfinite(given->second)) refuse(file_, name, given->second, "needs to be finite");
      p.value = given->second;
    }
    scene_.parameters.push_back(p);
    return p.value;
  }

  bool flag(const std::string& name, bool otherwise, const std::string& what) {
    const double value = parameter(name, otherwise ? 1 : 0, what);
    if (value != 0 && value != 1) refuse(file_, name, value, "needs to be 0 or 1");
    return value == 1;
  }

  void need_parameter(const std::string& name) const {
    std::vector<std::string> known;
    for (const SceneParameter& p : scene_.parameters) known.push_back(p.name);
    if (std::find(known.begin(), known.end(), name) == known.end())
      refuse(file_, "parameter", name, "needs to be " + one_of(known, name));
  }

  void read_base() {
    const UrdfLink& root = link(0);
    fixed_ = flag("base.fixed", root.name == "world" || root.mass == 0,
                  "1: link '" + root.name + "' is fixed to the world; 0: it floats");
    const auto number = [&](const char* name, const char* what) { return parameter(name, 0, what); };
    base_.p.x() = number("base.x", "where the root link's frame is [m]");
    base_.p.y() = number("base.y", "[m]");
    base_.p.z() = number("base.z", "[m]");
    const double roll = number("base.roll", "how it is turned, about the world's x, then y, then z [rad]");
    const double pitch = number("base.pitch", "[rad]"), yaw = number("base.yaw", "[rad]");
    base_.q = unit(rotation(yaw * Vector3::UnitZ()) * rotation(pitch * Vector3::UnitY()) *
                   rotation(roll * Vector3::UnitX()));
    if (!fixed_) {
      V_base_.v.x() = number("base.vx", "its velocity, world axes [m/s]");
      V_base_.v.y() = number("base.vy", "[m/s]");
      V_base_.v.z() = number("base.vz", "[m/s]");
      V_base_.w.x() = number("base.wx", "its angular velocity, world axes [rad/s]");
      V_base_.w.y() = number("base.wy", "[rad/s]");
      V_base_.w.z() = number("base.wz", "[rad/s]");
    }
    floor_ = flag("floor", !fixed_, "1: a floor, solid where z < 0; 0: none");
    mu_ = parameter("mu", 0.5, "friction where collision shapes touch");
    e_ = parameter("e", 0, "Newton's restitution there");
  }

  void gather() {
    UrdfGroups found = gather_links(robot_, file_, fixed_);
    for (const UrdfGroup& g : found.all) groups_.push_back({g});
    group_ = std::move(found.of_link);
    X_GL_ = std::move(found.X_GL);
    unused_.insert(unused_.end(), found.unused.begin(), found.unused.end());
  }

  const UrdfJoint& joint(const Group& g) const { return robot_.joints[static_cast<std::size_t>(g.joint)]; }

  int find_joint(const std::string& name) const {
    const auto found = std::find_if(robot_.joints.begin(), robot_.joints.end(),
                                    [&](const UrdfJoint& j) { return j.name == name; });
    return found == robot_.joints.end() ? -1 : static_cast<int>(found - robot_.joints.begin());
  }

  bool moves(std::size_t i) {
    return one_freedom(robot_.joints[i].kind) && !group_of(robot_.joints[i].child).left_out;
  }

  /// q and v of the joints: leaders first, then those who mimic them.
  void read_starts() {
    q_.assign(robot_.joints.size(), 0);
    v_.assign(robot_.joints.size(), 0);
    for (const bool mimics : {false, true})
      for (std::size_t i = 0; i < robot_.joints.size(); ++i) {
        const UrdfJoint& j = robot_.joints[i];
        if (!moves(i) || j.mimic.empty() == mimics) continue;
        double q = 0, v = 0;
        const bool stops = j.limited && j.kind != Kind::Continuous;
        if (stops && (j.lower > 0 || j.upper < 0)) q = 0.5 * (j.lower + j.upper);
        if (const int leader = mimics ? find_joint(j.mimic) : -1; leader >= 0) {
          q = j.multiplier * q_[static_cast<std::size_t>(leader)] + j.offset;
          v = j.multiplier * v_[static_cast<std::size_t>(leader)];
        }
        const char* unit = slides(j.kind) ? "m" : "rad";
        q_[i] = parameter("q." + fitting(j.name), q,
                          std::string("start of joint '") + j.name + "' [" + unit + "]");
        v_[i] = parameter("v." + fitting(j.name), v, std::string("its rate there [") + unit + "/s]");
      }
  }

  /// Where the groups are, all coordinates zero, and with `part` of the start's.
  void place(double part) {
    for (Group& g : groups_) {
      if (g.joint < 0) {
        g.X_WG = g.X_WG_start = base_;
        g.V = V_base_;
        continue;
      }
      const UrdfJoint& j = joint(g);
      const Group& parent = group_of(j.parent);
      const Pose X_PJ = X_GL_[static_cast<std::size_t>(j.parent)] * j.X_PJ;
      g.X_WG = parent.X_WG * X_PJ;
      g.X_WG_start = parent.X_WG_start * X_PJ;
      g.V.w = parent.V.w;
      g.V.v = parent.V.at(g.X_WG_start.p - parent.X_WG_start.p);
      const auto i = static_cast<std::size_t>(g.joint);
      if (!moves(i)) continue;
      const Vector3 axis = at(j, [&] {
        const double length = j.axis.norm();
        if (!(length > 0) || !std::isfinite(length)) refuse("joint", "axis", length, "needs a direction");
        return Vector3(j.axis / length);
      });
      const Vector3 world = g.X_WG_start.q * axis;
      const double q = part * q_[i];
      if (slides(j.kind)) {
        g.V.v += g.V.w.cross(q * world) + v_[i] * world;
        g.X_WG_start.p += q * world;
      } else {
        g.V.w += v_[i] * world;
        g.X_WG_start.q = g.X_WG_start.q * rotation(q * axis);
      }
    }
    for (Group& g : groups_) g.X_WG.q = perp::unit(g.X_WG.q);
  }

  void add_body(Group& g) {
    if (g.left_out || (g.first == 0 && fixed_)) return;
    const UrdfLink& l = link(g.first);
    const Pose X_WB{g.X_WG * g.centre, g.X_WG.q};
    g.body = at_line(file_, l.line, "link '" + l.name + "'", [&] {
      return model().add_body(Inertia(g.mass, g.J), {.pose = X_WB, .name = fitting(l.name)});
    });
  }

  void add_joint(const UrdfJoint& j) {
    const auto leaves = [&](bool there, const char* what) {
      if (there)
        unused(j.line, std::string("<") + what + "> of joint '" + j.name + "', " + kind_name(j.kind));
    };
    const bool single = one_freedom(j.kind);
    leaves(!single && (j.friction > 0 || j.damping > 0), "dynamics");
    leaves((j.lower != 0 || j.upper != 0) && (!single || j.kind == Kind::Continuous), "limit");
    if (j.kind == Kind::Fixed || group_of(j.child).left_out || j.kind == Kind::Floating) return;
    const Group &a = group_of(j.parent), &b = group_of(j.child);
    at(j, [&] {
      const JointOptions options{.point = b.X_WG.p,
                                 .axis = b.X_WG.q * j.axis,
                                 .friction = single ? j.friction : 0,
                                 .name = fitting(j.name)};
      const JointId id = model().add_joint(j.kind == Kind::Planar ? planar(a.body, b.body, options)
                                           : slides(j.kind)       ? prismatic(a.body, b.body, options)
                                                                  : revolute(a.body, b.body, options));
      if (!single) return 0;
      if (j.limited && j.kind != Kind::Continuous)
        model().add_limit(id, {.lower = j.lower, .upper = j.upper});
      if (j.damping != 0) model().add_joint_spring({.joint = id, .damping = j.damping});
      return 0;
    });
  }

  static const char* kind_name(Kind kind) {
    constexpr const char* names[] = {"revolute", "continuous", "prismatic", "fixed", "floating", "planar"};
    return names[static_cast<std::size_t>(kind)];
  }

  /// One joint's coordinate a multiple of another's: a gear, where both turn on the ground.
  void add_mimic(const UrdfJoint& j) {
    if (j.mimic.empty()) return;
    const int leader = find_joint(j.mimic);
    const auto follower = static_cast<std::size_t>(&j - robot_.joints.data());
    if (leader < 0)
      refuse_at(file_, {static_cast<std::size_t>(j.line), 1},
                "joint '" + j.name + "' mimics '" + j.mimic + "'", "needs a joint of that name");
    const UrdfJoint& l = robot_.joints[static_cast<std::size_t>(leader)];
    const bool turn =
        moves(follower) && moves(static_cast<std::size_t>(leader)) && !slides(j.kind) && !slides(l.kind);
    const bool on_ground = group_of(j.parent).body == ground && group_of(l.parent).body == ground;
    if (!turn || !on_ground || j.offset != 0 || j.multiplier == 0) {
      unused(j.line, "<mimic> of joint '" + j.name +
                         "': both joints need to turn on what is fixed to the world, without an offset");
      return;
    }
    const Group &a = group_of(l.child), &b = group_of(j.child);
    at(j, [&] {
      return model().add_joint(gear(a.body, b.body,
                                    {.point = a.X_WG.p,
                                     .axis = a.X_WG.q * l.axis,
                                     .axis_b = b.X_WG.q * j.axis,
                                     .ratio = j.multiplier,
                                     .name = fitting(j.name) + ".mimic"}));
    });
  }

  void add_shapes() {
    std::vector<PlacedShape> shapes;
    for (int i = 0; i < static_cast<int>(robot_.links.size()); ++i) {
      const Group& g = group_of(i);
      if (g.left_out) continue;
      for (std::size_t k = 0; k < link(i).shapes.size(); ++k) {
        const Pose X_GS = X_GL_[static_cast<std::size_t>(i)] * link(i).shapes[k].X_LS;
        PlacedShape s{.shape = link(i).shapes[k],
                      .name = fitting(link(i).name) + (k == 0 ? "" : "_" + std::to_string(k + 1)),
                      .line = link(i).line,
                      .body = g.body,
                      .X_BS = g.body == ground ? g.X_WG * X_GS : Pose{X_GS.p - g.centre, X_GS.q}};
        s.X_BS.q = unit(s.X_BS.q);
        shapes.push_back(std::move(s));
      }
    }
    const std::vector<UrdfUnused> unused = add_robot_shapes(shapes, file_, model());
    unused_.insert(unused_.end(), unused.begin(), unused.end());
    model().set_friction("robot", "robot", {.mu = mu_, .e = e_});
    model().set_friction("robot", "floor", {.mu = mu_, .e = e_});
  }

  /// Shapes of the robot that overlap at the start have no contact; what stands in the floor does.
  void part_overlapping() {
    for (const std::string& pair : model().leave_out_overlapping(scene_.start))
      unused(0, "contact '" + pair + "': the shapes overlap at the start");
    if (floor_) model().add_shape(ground, Shape::half_space(), {.material = "floor", .name = "floor"});
  }

  /// Poses and velocities of the bodies. Angles grow to what they are by a quarter turn at most, so that their turns count.
  void start() {
    scene_.start = model().rest();
    const double largest = std::transform_reduce(
        q_.begin(), q_.end(), 1.0, [](double a, double b) { return std::max(a, b); },
        [](double q) { return std::abs(q); });
    const int parts = static_cast<int>(std::ceil(largest / (std::numbers::pi / 2)));
    for (int k = 1; k <= parts; ++k) {
      place(static_cast<double>(k) / parts);
      for (const Group& g : groups_) {
        if (g.body == ground) continue;
        const Vector3 r = g.X_WG_start.q * g.centre;
        model().set_position(scene_.start, g.body, g.X_WG_start.p + r);
        model().set_orientation(scene_.start, g.body, g.X_WG_start.q);
        model().set_velocity(scene_.start, g.body, g.V.at(r), g.V.w);
      }
      model().follow_turns(scene_.start);
    }
  }

  UrdfRobot robot_;
  const std::string& file_;
  const SceneParameters& set_;
  Scene scene_;
  bool fixed_ = false, floor_ = false;
  double mu_ = 0, e_ = 0;
  Pose base_;
  Twist V_base_;
  std::vector<Group> groups_;  // parents before children
  std::vector<int> group_;     // of each link
  std::vector<Pose> X_GL_;     // of each link in its group's frame
  std::vector<double> q_, v_;  // of each joint, at the start
  std::vector<UrdfUnused> unused_;
};

}  // namespace

Scene read_urdf(std::string_view text, const std::string& file, const SceneParameters& set) {
  return Builder(read_urdf_robot(text, file), file, set).scene();
}

}  // namespace perp
