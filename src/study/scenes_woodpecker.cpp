// The woodpecker toy, in coordinates of its own: a bird on a spring on a sleeve that slips down a pole.
#include <cmath>

#include "study/scene_parts.hpp"
#include "study/woodpecker_sizes.hpp"

namespace perp {

Scene woodpecker(Parameters& set) {
  const double mu = set.number("mu", 0.3, "friction of beak and sleeve on the pole", not_negative);
  const double e = set.number("e", 0.5, "restitution of the beak", fraction);
  Scene s;
  s.id = "C11";
  s.what = "A toy woodpecker rattles down its pole: a limit cycle of sticking, slipping and pecking";
  s.t_end = 1;

  // q = (height, angle of the sleeve M, angle of the bird S)
  const double m_M = 3e-4, J_M = 5e-9, m_S = 4.5e-3, J_S = 7e-7, c = 0.0056;
  const WoodpeckerSizes size;
  const double r_0 = size.r_0, r_M = size.r_M, h_M = size.h_M;
  const double l_M = size.l_M, l_G = size.l_G, h_S = size.h_S, l_S = size.l_S;
  Matrix M(3, 3);
  M << m_S + m_M, m_S * l_M, m_S * l_G,                   //
      m_S * l_M, J_M + m_S * l_M * l_M, m_S * l_M * l_G,  //
      m_S * l_G, m_S * l_M * l_G, J_S + m_S * l_G * l_G;
  const auto force = [=](const Vector& q, const Vector&, double) -> Vector {
    const double twist = c * (q[1] - q[2]);
    return Vector3(-(m_S + m_M) * g, -twist - m_S * l_M * g, twist - m_S * l_G * g);
  };
  const auto potential = [=](const Vector& q) {
    const double twist = q[1] - q[2];
    return (m_S + m_M) * g * q[0] + m_S * g * (l_M * q[1] + l_G * q[2]) + 0.5 * c * twist * twist;
  };
  const BodyId bird = s.model.add_generalized(
      3, {.mass = [=](const Vector&) { return M; }, .force = force, .potential = potential}, "woodpecker");
  const auto touch = [&](const char* name, double gap_0, const Vector3& normal, const Vector3& tangent,
                         double restitution) {
    const GeneralizedGap gap = [=](const Vector& q, double) {
      return GeneralizedPoint{.gap = gap_0 + normal.dot(q), .normal = normal, .tangent = tangent};
    };
    s.model.add_contact(bird, gap, {.mu = mu, .e = restitution, .name = name});
  };
  touch("beak", l_M + l_G - l_S - r_0, {0, 0, -h_S}, {1, l_M, l_G - l_S}, e);
  touch("upper", r_M - r_0, {0, h_M, 0}, {1, r_M, 0}, 0);
  touch("lower", r_M - r_0, {0, -h_M, 0}, {1, r_M, 0}, 0);
  s.start = s.model.rest();
  // the sleeve is wedged, its upper edge on the pole
  s.model.set_coordinates(s.start, bird, Vector3(0, -(r_M - r_0) / h_M, -0.2788),
                          Vector3(-0.3411, 0, -7.4583));
  return s;
}

}  // namespace perp
