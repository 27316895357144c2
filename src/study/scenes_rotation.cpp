// Bodies that only turn.
#include "study/scene_parts.hpp"

namespace perp {

Scene dzhanibekov(Parameters& set) {
  const double spin = set.number("spin", 5, "about the middle axis [rad/s]");
  const double tilt = set.number("tilt", 0.01, "initial rate about the other two axes [rad/s]");
  const Vector3 moments(1, 2, 3), w0(tilt, spin, tilt);
  Scene s;
  s.id = "B12";
  s.what = "A free body that turns about its middle axis flips over and back, again and again";
  s.model.set_gravity(Vector3::Zero());
  const BodyId body = s.model.add_body(Inertia::principal(1, moments), {.name = "body"});
  s.start = s.model.rest();
  s.model.set_velocity(s.start, body, Vector3::Zero(), w0);

  // Euler's equations in body axes, y = (w, orientation)
  const RealVector3 J = moments.cast<Real>();
  const ReferenceMotion motion({{.rate =
                                     [=](Real, const Reals& y, Reals& dy) {
                                       const RealVector3 w(y[0], y[1], y[2]);
                                       const RealVector3 L = J.cwiseProduct(w);
                                       const RealVector3 a = L.cross(w).cwiseQuotient(J);
                                       for (int i = 0; i < 3; ++i) dy[static_cast<std::size_t>(i)] = a[i];
                                       turn_in_body_axes(y, w, dy, 3);
                                     }}},
                               {tilt, spin, tilt, 1, 0, 0, 0});
  s.exact = [=, model = s.model](double t) {
    const Reals y = motion.at(t).y;
    State state = model.rest();
    state.t = t;
    const Quaternion q = orientation(y, 3);
    model.set_orientation(state, body, q);
    model.set_velocity(state, body, Vector3::Zero(), q * Vector3(double(y[0]), double(y[1]), double(y[2])));
    return state;
  };
  return s;
}

}  // namespace perp
