// What a scene file says, read from its text alone: nothing here knows perp's own types. Written too, so that random scenes
// and smaller ones than those can be made.
#pragma once

#include <Eigen/Geometry>
#include <limits>
#include <map>
#include <string>
#include <vector>

namespace checker {

using Eigen::Matrix3d;
using Eigen::Quaterniond;
using Eigen::Vector3d;

constexpr double not_given = std::numeric_limits<double>::quiet_NaN();

/// Where a body's axes are: x_W = p + q x_B.
struct Place {
  Vector3d p = Vector3d::Zero();  // [m]
  Quaterniond q = Quaterniond::Identity();
  Vector3d operator*(const Vector3d& x) const { return p + q * x; }
  Place operator*(const Place& inner) const { return {p + q * inner.p, q * inner.q}; }
};

inline std::size_t at(int i) { return static_cast<std::size_t>(i); }  // a place in a vector

enum class Kind { Ground, Prescribed, Spatial, Planar, Particle };

/// Of a prescribed body: "" stands still, shaker (vector: amplitude), turntable (axis), belt (velocity).
struct Motion {
  std::string kind;
  Vector3d vector = Vector3d::Zero();
  double rate = 0, phase = 0;
};

struct Body {
  std::string name = "ground";
  Kind kind = Kind::Ground;
  double mass = 0;    // [kg]
  std::string shape;  // of a spatial inertia: solid_sphere, hollow_sphere, box, cylinder, ellipsoid, moments
  std::vector<double>
      size;               // of the shape [m]; moments [kg m^2]; a planar body's inertia is size[0] [kg m^2]
  Place rest;             // where joints are defined
  double rest_angle = 0;  // of a planar body
  bool starts_elsewhere = false;
  Place start;
  double start_angle = 0;
  Vector3d v = Vector3d::Zero(), w = Vector3d::Zero();  // world axes
  Motion motion;

  bool moves() const { return kind == Kind::Spatial || kind == Kind::Planar || kind == Kind::Particle; }
  bool turns() const { return kind == Kind::Spatial || kind == Kind::Planar; }
  Matrix3d inertia() const;  // about its centre of mass, body axes
  Place first() const;       // where the run begins
};

struct Joint {
  std::string name, kind;
  int a = 0, b = 0;
  Vector3d point = Vector3d::Zero(), axis = Vector3d::UnitZ(), axis_b = Vector3d::Zero();
  Vector3d point_b = Vector3d::Zero();
  double lead = not_given, ratio = not_given, friction = 0;
};

/// Of one coordinate of a joint.
struct Limit {
  int joint = 0;
  std::string coordinate;
  double lower = not_given, upper = not_given, e = 0;
};
struct Motor {
  int joint = 0;
  std::string coordinate, effort, motion;  // one of the two
};
struct JointSpring {
  int joint = 0;
  std::string coordinate;
  double stiffness = 0, damping = 0, rest = 0;
};

struct Spring {
  int a = 0, b = 0;
  Vector3d point_a = Vector3d::Zero(), point_b = Vector3d::Zero();
  double stiffness = 0, damping = 0, length = 0;
};

struct Contact {
  std::string name;
  int a = 0, b = 0;
  std::string gap;                                  // its kind
  std::map<std::string, std::vector<double>> size;  // its sizes as the file has them
  Place place_a, place_b;
  bool placed = false;
  double mu = 0, e = 0;
  Vector3d tangent = Vector3d::Zero();
};

struct Force {
  int body = 0;
  std::string force[3] = {"0", "0", "0"};
};

struct Scene {
  Vector3d gravity = {0, 0, -9.81};
  std::vector<Body> bodies = std::vector<Body>(1);  // the ground first
  std::vector<Joint> joints;
  std::vector<Limit> limits;
  std::vector<Motor> motors;
  std::vector<JointSpring> joint_springs;
  std::vector<Spring> springs;
  std::vector<Contact> contacts;
  std::vector<Force> forces;
};

/// Throws std::runtime_error for what the checker does not know, so that nothing goes unlooked at.
[[nodiscard]] Scene read_scene(const std::string& path);
[[nodiscard]] std::string text_of(const Scene& scene);

/// `number` with the digits that read back to the same double.
[[nodiscard]] std::string digits(double number);

}  // namespace checker
