#include "io/urdf_robot.hpp"

#include "io/toml_file.hpp"

#ifdef PERP_HAS_URDFDOM
#include <console_bridge/console.h>
#include <tinyxml.h>
#include <urdf_parser/urdf_parser.h>

#include <algorithm>
#include <array>
#include <locale>
#include <map>
#include <mutex>
#include <set>
#include <sstream>

#include "perp/core/errors.hpp"
#endif

namespace perp {

#ifndef PERP_HAS_URDFDOM

UrdfRobot read_urdf_robot(std::string_view, const std::string& file) {
  refuse_at(file, {}, "a URDF file", "needs a perp that was built with urdfdom (liburdfdom-dev)");
}

#else

namespace {

constexpr int deepest_xml = 100;  ///< elements in one another; URDF has six

/// How deep the elements of `text` nest, comments left out; of what is not XML some number.
int nesting(std::string_view text) {
  int depth = 0, deepest = 0;
  for (std::size_t at = text.find('<'); at != text.npos && at + 1 < text.size();
       at = text.find('<', at + 1)) {
    if (text.substr(at, 4) == "<!--") {
      at = std::min(text.find("-->", at), text.size() - 1);
    } else if (text[at + 1] == '/') {
      --depth;
    } else if (text[at + 1] != '!' && text[at + 1] != '?') {
      const std::size_t end = text.find('>', at);
      if (end == text.npos || text[end - 1] != '/') deepest = std::max(deepest, ++depth);
    }
  }
  return deepest;
}

/// What perp reads of an element, by its path; the rest is unused.
struct Read {
  std::string_view path;
  std::set<std::string_view> attributes, children;
};

const std::vector<Read>& what_is_read() {
  static const std::vector<Read> all{
      {"robot", {"name", "version"}, {"link", "joint"}},
      {"robot/link", {"name"}, {"inertial", "collision"}},
      {"robot/link/inertial", {}, {"origin", "mass", "inertia"}},
      {"robot/link/inertial/origin", {"xyz", "rpy"}, {}},
      {"robot/link/inertial/mass", {"value"}, {}},
      {"robot/link/inertial/inertia", {"ixx", "ixy", "ixz", "iyy", "iyz", "izz"}, {}},
      {"robot/link/collision", {"name"}, {"origin", "geometry"}},
      {"robot/link/collision/origin", {"xyz", "rpy"}, {}},
      {"robot/link/collision/geometry", {}, {"sphere", "box", "cylinder", "capsule", "mesh"}},
      {"robot/link/collision/geometry/sphere", {"radius"}, {}},
      {"robot/link/collision/geometry/box", {"size"}, {}},
      {"robot/link/collision/geometry/cylinder", {"radius", "length"}, {}},
      {"robot/link/collision/geometry/capsule", {"radius", "length"}, {}},
      {"robot/link/collision/geometry/mesh", {"filename", "scale"}, {}},
      {"robot/joint", {"name", "type"}, {"origin", "parent", "child", "axis", "limit", "dynamics", "mimic"}},
      {"robot/joint/origin", {"xyz", "rpy"}, {}},
      {"robot/joint/parent", {"link"}, {}},
      {"robot/joint/child", {"link"}, {}},
      {"robot/joint/axis", {"xyz"}, {}},
      {"robot/joint/limit", {"lower", "upper"}, {}},
      {"robot/joint/dynamics", {"damping", "friction"}, {}},
      {"robot/joint/mimic", {"joint", "multiplier", "offset"}, {}},
  };
  return all;
}

/// The file as XML: its elements' lines, the order of links and joints, and what of it is not read.
class Xml {
 public:
  Xml(std::string_view text, const std::string& file) : file_(file) {
    if (text.find('\0') != text.npos) refuse_at(file, {}, "a byte 0", "needs to be XML");
    if (nesting(text) > deepest_xml)
      refuse_at(file, {}, "elements that nest deeper than " + std::to_string(deepest_xml),
                "no robot needs that");
    document_.Parse(std::string(text).c_str());
    if (document_.Error()) {
      const auto place = [](int x) { return static_cast<std::size_t>(std::max(x, 1)); };
      refuse_at(file, {place(document_.ErrorRow()), place(document_.ErrorCol())},
                std::string("'") + document_.ErrorDesc() + "'", "needs to be XML");
    }
    const TiXmlElement* root = document_.RootElement();
    if (root == nullptr || root->ValueStr() != "robot")
      refuse_at(file, {}, root == nullptr ? "no element" : "the element <" + root->ValueStr() + ">",
                "a URDF file needs to be one <robot>");
    walk(*root, "robot", "");
    for (const TiXmlElement* e = root->FirstChildElement(); e != nullptr; e = e->NextSiblingElement())
      if (const char* name = e->Attribute("name"); name != nullptr) {
        if (e->ValueStr() == "link") links.emplace(name, e);
        if (e->ValueStr() == "joint" && joints.emplace(name, e).second) joint_order.emplace_back(name);
      }
    without_capsules = take_capsules(text);
  }

  static int line(const TiXmlElement* element) { return element == nullptr ? 1 : element->Row(); }
  int line_of_link(const std::string& name) const { return line(find(links, name)); }
  int line_of_joint(const std::string& name) const { return line(find(joints, name)); }

  /// What urdfdom complained of, at the joint or link that it names.
  [[noreturn]] void refuse(const std::string& complaint) const {
    const TiXmlElement* about = nullptr;
    for (const auto* elements :
         {&links, &joints})  // joints after links: a complaint of a joint names links too
      for (const auto& [name, element] : *elements)
        if (complaint.find("[" + name + "]") != complaint.npos ||
            complaint.find("'" + name + "'") != complaint.npos)
          about = element;
    refuse_at(file_, place(line(about)), "'" + complaint + "'", "needs to be URDF");
  }

  static Place place(int line) { return {static_cast<std::size_t>(std::max(line, 1)), 1}; }

  std::map<std::string, const TiXmlElement*> links, joints;
  std::vector<std::string> joint_order;            ///< as they stand in the file
  std::multimap<std::string, UrdfShape> capsules;  ///< of each link: urdfdom has none
  std::string without_capsules;                    ///< the file's text, as urdfdom takes it
  std::vector<UrdfUnused> unused;

 private:
  static Vector3 three(const TiXmlElement* element, const char* attribute) {
    Vector3 v = Vector3::Zero();
    const char* text = element == nullptr ? nullptr : element->Attribute(attribute);
    std::istringstream numbers(text == nullptr ? "" : text);
    numbers.imbue(std::locale::classic());
    numbers >> v.x() >> v.y() >> v.z();
    return v;
  }

  /// Out of a copy of the file; the lines of its elements stay as they were.
  std::string take_capsules(std::string_view text) {
    TiXmlDocument copy;
    copy.Parse(std::string(text).c_str());
    bool any = false;
    for (TiXmlElement* link = copy.RootElement()->FirstChildElement("link"); link != nullptr;
         link = link->NextSiblingElement("link"))
      for (TiXmlElement* e = link->FirstChildElement(); e != nullptr;) {
        TiXmlElement* const next = e->NextSiblingElement();
        const TiXmlElement* const geometry = e->FirstChildElement("geometry");
        const TiXmlElement* const capsule =
            geometry == nullptr ? nullptr : geometry->FirstChildElement("capsule");
        if (capsule != nullptr) {
          any = true;
          const TiXmlElement* const origin = e->FirstChildElement("origin");
          const Vector3 rpy = three(origin, "rpy");
          UrdfShape shape{.kind = UrdfShape::Kind::Capsule};
          capsule->QueryDoubleAttribute("radius", &shape.size.x());
          capsule->QueryDoubleAttribute("length", &shape.size.y());
          shape.X_LS = {
              three(origin, "xyz"),
              perp::unit(rotation({0, 0, rpy.z()}) * rotation({0, rpy.y(), 0}) * rotation({rpy.x(), 0, 0}))};
          const char* name = link->Attribute("name");
          if (e->ValueStr() == "collision" && name != nullptr) capsules.emplace(name, shape);
          link->RemoveChild(e);
        }
        e = next;
      }
    if (!any) return std::string(text);
    TiXmlPrinter printer;
    copy.Accept(&printer);
    return printer.Str();
  }

  using Elements = std::map<std::string, const TiXmlElement*>;
  static const TiXmlElement* find(const Elements& elements, const std::string& name) {
    const auto found = elements.find(name);
    return found == elements.end() ? nullptr : found->second;
  }

  /// `owner`: " of link 'arm'", of the link or joint that the element is in.
  void walk(const TiXmlElement& element, const std::string& path, const std::string& owner) {
    const auto read = std::find_if(what_is_read().begin(), what_is_read().end(),
                                   [&](const Read& r) { return r.path == path; });
    for (const TiXmlAttribute* a = element.FirstAttribute(); a != nullptr; a = a->Next())
      if (!read->attributes.contains(a->Name()))
        unused.push_back(
            {element.Row(), std::string(a->Name()) + " in <" + element.ValueStr() + ">" + owner});
    std::set<std::string> seen;
    for (const TiXmlElement* e = element.FirstChildElement(); e != nullptr; e = e->NextSiblingElement()) {
      const std::string kind = e->ValueStr();
      const bool many = kind == "link" || kind == "joint" || kind == "collision";
      const char* name = e->Attribute("name");
      if (!read->children.contains(kind)) {
        const std::string named = name == nullptr ? "" : " '" + std::string(name) + "'";
        unused.push_back({e->Row(), "<" + kind + ">" + named + owner});
      } else if (!many && !seen.insert(kind).second) {
        unused.push_back({e->Row(), "a second <" + kind + ">" + owner});
      } else {
        walk(*e, path + "/" + kind,
             path == "robot" ? " of " + kind + " '" + (name == nullptr ? "" : name) + "'" : owner);
      }
    }
  }

  const std::string& file_;
  TiXmlDocument document_;
};

/// Collects what urdfdom would print, while it lives.
class Listener : public console_bridge::OutputHandler {
 public:
  Listener() : before_(console_bridge::getOutputHandler()) { console_bridge::useOutputHandler(this); }
  ~Listener() override { console_bridge::useOutputHandler(before_); }
  Listener(const Listener&) = delete;
  Listener& operator=(const Listener&) = delete;

  void log(const std::string& text, console_bridge::LogLevel level, const char*, int) override {
    if (level >= console_bridge::CONSOLE_BRIDGE_LOG_ERROR && complaint.size() < 1000)
      complaint += (complaint.empty() ? "" : "; ") + text;
  }

  std::string complaint;

 private:
  console_bridge::OutputHandler* before_;
};

/// urdfdom's model; its console is one for the whole program.
urdf::ModelInterfaceSharedPtr parse(std::string_view text, const Xml& xml) {
  static std::mutex one_at_a_time;
  const std::lock_guard lock(one_at_a_time);
  Listener listener;
  urdf::ModelInterfaceSharedPtr model;
  try {
    model = urdf::parseURDF(std::string(text));
  } catch (const std::exception& error) {
    xml.refuse(error.what());
  }
  if (model == nullptr || !listener.complaint.empty())
    xml.refuse(listener.complaint.empty() ? "no robot" : listener.complaint);
  return model;
}

Vector3 vector(const urdf::Vector3& v) { return {v.x, v.y, v.z}; }

Pose pose(const urdf::Pose& X) {
  const urdf::Rotation& q = X.rotation;
  return {vector(X.position), unit(Quaternion(q.w, q.x, q.y, q.z))};
}

UrdfLink read_link(const urdf::Link& from, const Xml& xml) {
  UrdfLink link;
  link.name = from.name;
  link.line = xml.line_of_link(from.name);
  if (from.inertial != nullptr) {
    const urdf::Inertial& i = *from.inertial;
    link.mass = i.mass;
    link.X_LC = pose(i.origin);
    link.J << i.ixx, i.ixy, i.ixz, i.ixy, i.iyy, i.iyz, i.ixz, i.iyz, i.izz;
  }
  for (const auto& collision : from.collision_array) {
    if (collision->geometry == nullptr) continue;
    UrdfShape shape{.X_LS = pose(collision->origin)};
    switch (collision->geometry->type) {
      case urdf::Geometry::SPHERE:
        shape.size.x() = static_cast<const urdf::Sphere&>(*collision->geometry).radius;
        break;
      case urdf::Geometry::BOX:
        shape.kind = UrdfShape::Kind::Box;
        shape.size = vector(static_cast<const urdf::Box&>(*collision->geometry).dim);
        break;
      case urdf::Geometry::CYLINDER: {
        const auto& cylinder = static_cast<const urdf::Cylinder&>(*collision->geometry);
        shape.kind = UrdfShape::Kind::Cylinder;
        shape.size << cylinder.radius, cylinder.length, 0;
        break;
      }
      case urdf::Geometry::MESH: {
        const auto& mesh = static_cast<const urdf::Mesh&>(*collision->geometry);
        shape.kind = UrdfShape::Kind::Mesh;
        shape.size = vector(mesh.scale);
        shape.file = mesh.filename;
        break;
      }
      default:
        continue;
    }
    link.shapes.push_back(shape);
  }
  const auto [first, last] = xml.capsules.equal_range(from.name);
  for (auto capsule = first; capsule != last; ++capsule) link.shapes.push_back(capsule->second);
  return link;
}

UrdfJoint read_joint(const urdf::Joint& from, const Xml& xml, const std::string& file) {
  UrdfJoint joint;
  joint.name = from.name;
  joint.line = xml.line_of_joint(from.name);
  constexpr std::array kinds{std::pair{urdf::Joint::REVOLUTE, UrdfJoint::Kind::Revolute},
                             std::pair{urdf::Joint::CONTINUOUS, UrdfJoint::Kind::Continuous},
                             std::pair{urdf::Joint::PRISMATIC, UrdfJoint::Kind::Prismatic},
                             std::pair{urdf::Joint::FIXED, UrdfJoint::Kind::Fixed},
                             std::pair{urdf::Joint::FLOATING, UrdfJoint::Kind::Floating},
                             std::pair{urdf::Joint::PLANAR, UrdfJoint::Kind::Planar}};
  const auto kind =
      std::find_if(kinds.begin(), kinds.end(), [&](const auto& k) { return k.first == from.type; });
  if (kind == kinds.end())
    refuse_at(file, Xml::place(joint.line), "joint '" + joint.name + "' of a type that URDF does not have",
              "needs revolute, continuous, prismatic, fixed, floating or planar");
  joint.kind = kind->second;
  joint.X_PJ = pose(from.parent_to_joint_origin_transform);
  joint.axis = vector(from.axis);
  if (from.limits != nullptr) {
    joint.limited = true;
    joint.lower = from.limits->lower;
    joint.upper = from.limits->upper;
  }
  if (from.dynamics != nullptr) {
    joint.friction = from.dynamics->friction;
    joint.damping = from.dynamics->damping;
  }
  if (from.mimic != nullptr) {
    joint.mimic = from.mimic->joint_name;
    joint.multiplier = from.mimic->multiplier;
    joint.offset = from.mimic->offset;
  }
  return joint;
}

}  // namespace

UrdfRobot read_urdf_robot(std::string_view text, const std::string& file) {
  const Xml xml(text, file);
  const urdf::ModelInterfaceSharedPtr model = parse(xml.without_capsules, xml);
  UrdfRobot robot{.name = model->getName(), .links = {}, .joints = {}, .unused = xml.unused};

  std::map<std::string, std::vector<std::string> > children;  // joints of each link, in the file's order
  std::map<std::string, std::string> held;                    // by which joint each link
  for (const std::string& name : xml.joint_order) {
    const urdf::Joint& joint = *model->getJoint(name);
    children[joint.parent_link_name].push_back(name);
    if (const auto [other, first] = held.emplace(joint.child_link_name, name); !first)
      refuse_at(file, Xml::place(xml.line_of_joint(name)),
                "joint '" + name + "' holds link '" + joint.child_link_name + "', as joint '" +
                    other->second + "' does",
                "URDF needs to be a tree");
  }
  std::vector<std::pair<std::string, int> > waiting;  // joints whose parents are there, the next one last
  const auto add = [&](const std::string& link) {
    const int index = static_cast<int>(robot.links.size());
    robot.links.push_back(read_link(*model->getLink(link), xml));
    const std::vector<std::string>& next = children[link];
    for (auto name = next.rbegin(); name != next.rend(); ++name) waiting.emplace_back(*name, index);
  };
  add(model->getRoot()->name);
  while (!waiting.empty()) {
    const auto [name, parent] = waiting.back();
    waiting.pop_back();
    const urdf::Joint& from = *model->getJoint(name);
    robot.joints.push_back(read_joint(from, xml, file));
    robot.joints.back().parent = parent;
    robot.joints.back().child = static_cast<int>(robot.links.size());
    add(from.child_link_name);
  }
  std::set<std::string> reached;
  for (const UrdfLink& link : robot.links) reached.insert(link.name);
  for (const auto& [name, element] : xml.links)
    if (!reached.contains(name))
      refuse_at(file, Xml::place(Xml::line(element)), "link '" + name + "' in a loop of joints",
                "URDF needs to be a tree");
  return robot;
}

#endif

}  // namespace perp
