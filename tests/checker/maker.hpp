// What recipes of random scenes share.
#pragma once

#include "mechanics.hpp"
#include "random_scene.hpp"

namespace checker {

class Maker {
 public:
  Maker(std::uint64_t seed, bool plane);
  RandomScene take();

  Random random;
  const bool plane;   // all bodies in the xy plane
  double L, T, V, h;  // a length, sqrt(L/g), sqrt(L g), the step
  int steps;
  Scene scene;

  double mass();
  double mu();
  double e();
  double size() { return L * random.decades(-0.4, 0.3); }
  Vector3d up() const { return plane ? Vector3d::UnitY() : Vector3d::UnitZ(); }
  Vector3d any(double scale);  // in the plane where the scene is

  int body(const std::string& shape, const std::vector<double>& sizes, const Vector3d& p,
           const Quaterniond& q = Quaterniond::Identity());
  int planar_body(double about, const Vector3d& p, double angle);
  int particle(const Vector3d& p);
  int prescribed(const Vector3d& p);
  int floor();  // ground, or something prescribed

  Contact& contact(const std::string& gap, int a, int b);
  /// Moves b along the normal of the scene's last contact until its least gap is `gap`.
  void settle(double gap);
  /// The same by moving a's plane.
  void raise_plane(double gap);
  /// Gives b of the last contact a slip, a turn and an approach; moves it off so far that it arrives within the run.
  void launch(bool rolls);
  Body& at(int i) { return scene.bodies[static_cast<std::size_t>(i)]; }

 private:
  double middle_ = 1;     // [kg]
  Touch nearest() const;  // of the last contact
};

inline std::vector<double> entries(const Vector3d& v) { return {v.x(), v.y(), v.z()}; }

void tilt(Maker& m, Contact& c);  // a slope for the last contact's plane
void add_spring(Maker& m, int a, int b);
void add_force(Maker& m, int b);
void add_extras(Maker& m, int b);  // one of these to some

void make_on_plane(Maker& m);
void make_pile(Maker& m);
void make_inside(Maker& m);
void make_boxes(Maker& m);
void make_linkage(Maker& m);
void make_planar(Maker& m);

}  // namespace checker
