// Where bodies are, how near, what joints tie and what loads pull: the checker's own, from a scene's text and a state.
#pragma once

#include "scene.hpp"

namespace checker {

/// Of one body, world axes; `at` its centre of mass and axes.
struct BodyState {
  Place at;
  double angle = 0;  // of a planar body
  Vector3d v = Vector3d::Zero(), w = Vector3d::Zero();

  Vector3d velocity_at(const Vector3d& x) const { return v + w.cross(x - at.p); }
};

/// Of all bodies, the ground and prescribed ones among them.
struct State {
  double t = 0;
  std::vector<BodyState> bodies;
};

[[nodiscard]] State first_state(const Scene& scene);
void prescribe(const Scene& scene, State& x);               // puts prescribed bodies where they are at x.t
[[nodiscard]] Vector3d surface_velocity(const Body& body);  // of a belt

/// What `x` becomes as its bodies keep the velocities of `by` for h; prescribed ones where they are then.
[[nodiscard]] State moved(const Scene& scene, const State& x, const State& by, double h);

/// The velocities that lead from x to y in h: (q_y - q_x)/h, turning about a fixed axis.
[[nodiscard]] State between(const Scene& scene, const State& x, const State& y, double h);

/// A point where two bodies may touch. The normal points from a to b.
struct Touch {
  std::string name;
  int contact = 0, a = 0, b = 0;
  double gap = 0;
  Vector3d normal = Vector3d::UnitZ(), point = Vector3d::Zero();
  double mu = 0, e = 0;
  // of a joint's stop: a push along a coordinate
  bool stop = false, turns = false;
};
[[nodiscard]] std::vector<Touch> touches(const Scene& scene, const State& x,
                                         const std::vector<double>& coordinates);

/// b's velocity less a's at the point; with what a belt's surface adds.
[[nodiscard]] Vector3d relative_velocity(const Scene& scene, const State& x, const Touch& c);

/// One scalar equation psi = 0 or coordinate of a joint, and the wrench that goes with it: force at the joint's anchor on b, moments.
struct JointRow {
  double psi = 0;
  Vector3d force = Vector3d::Zero(), moment_a = Vector3d::Zero(), moment_b = Vector3d::Zero();
  bool angle = false;
};
struct JointState {
  Vector3d anchor = Vector3d::Zero();  // on b
  double apart = 0;                    // how far the anchor on a is from that
  std::vector<JointRow> rows;          // prescribed motions last
  std::vector<JointRow> coordinates;   // psi: the coordinate
};
[[nodiscard]] const std::vector<std::string>& coordinate_names(const std::string& kind);
/// near: what each coordinate was when last looked at.
[[nodiscard]] JointState joint_state(const Scene& scene, int joint, const State& x, const double* near);
/// The coordinates of all joints, one after the other; those of joint j begin at first_coordinate.
[[nodiscard]] std::vector<double> coordinates(const Scene& scene, const State& x,
                                              const std::vector<double>& near);
[[nodiscard]] std::size_t first_coordinate(const Scene& scene, int joint);
[[nodiscard]] std::size_t coordinate_index(const Scene& scene, int joint, const std::string& name);
[[nodiscard]] double rate(const State& x, const Joint& joint, const JointRow& row, const Vector3d& anchor);

struct Wrench {
  Vector3d force = Vector3d::Zero(), moment = Vector3d::Zero();  // about the centre of mass, world axes
};
/// Weights, springs, forces, motors, joint springs; no gyroscopic terms.
[[nodiscard]] std::vector<Wrench> loads(const Scene& scene, const State& x,
                                        const std::vector<double>& coordinates);

[[nodiscard]] double kinetic_energy(const Scene& scene, const State& x);
/// Weights, springs, joint springs.
[[nodiscard]] double potential_energy(const Scene& scene, const State& x,
                                      const std::vector<double>& coordinates);

/// The power of all that is in `loads` but not in the potential, and of dampers.
[[nodiscard]] double load_power(const Scene& scene, const State& x, const std::vector<double>& coordinates);

/// An expression of named numbers: + - * / ( ) sin cos; the derivative by `by` too.
struct Dual {
  double value = 0, slope = 0;
};
[[nodiscard]] Dual evaluate(const std::string& text, const std::map<std::string, double>& names,
                            const std::string& by = "t");

}  // namespace checker
