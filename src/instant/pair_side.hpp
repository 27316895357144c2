// One of the two bodies that a contact, a joint or a spring ties, as derivatives see it.
#pragma once

#include "perp/instant/instant.hpp"

namespace perp {

/// World twist of a body for each of its velocities.
inline Eigen::Matrix<double, 6, 6> twist_of(const Body& body, const Matrix3& R) {
  Eigen::Matrix<double, 6, 6> T = Eigen::Matrix<double, 6, 6>::Zero();
  switch (body.kind) {
    case BodyKind::Spatial:
      T.topLeftCorner<3, 3>().setIdentity();
      T.bottomRightCorner<3, 3>() = R;
      break;
    case BodyKind::Planar:
      T(0, 0) = T(1, 1) = T(5, 2) = 1;
      break;
    case BodyKind::Particle:
      T.topLeftCorner<3, 3>().setIdentity();
      break;
    default:
      break;
  }
  return T;
}

/// One of the two bodies of a pair.
struct Side {
  const Body& body;
  const Twist& V;
  Vector3 r;                      // from its origin to the point
  double sign;                    // -1 for a, +1 for b
  int v, w;                       // its first columns of velocity and turning
  Eigen::Matrix<double, 6, 6> T;  // twist_of(body)
};

inline Side side_of(const Model& model, const Instant& s, int body, double sign, const Vector3& point) {
  const Body& b = model.bodies()[static_cast<std::size_t>(body)];
  const int first = sign < 0 ? 0 : 6;
  return {b,
          s.V[static_cast<std::size_t>(body)],
          point - s.X[static_cast<std::size_t>(body)].p,
          sign,
          first,
          first + 3,
          twist_of(b, s.R[static_cast<std::size_t>(body)])};
}

}  // namespace perp
