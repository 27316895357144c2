// Projections onto the reaction sets of one padded block (N, T1, T2), and their derivatives.
#pragma once

#include "contact_system.hpp"

namespace perp {

/// û = u + mu |u_T| e_N, the velocity with the De Saxcé term [DSF98].
inline Vector3 augmented_velocity(BlockKind kind, double mu, const Vector3& u) {
  const bool friction = kind == BlockKind::Cone || kind == BlockKind::Planar;
  return friction ? Vector3(u(0) + mu * u.tail<2>().norm(), u(1), u(2)) : u;
}

/// The Euclidean projection of z onto the block's reactions.
Vector3 project_block(BlockKind kind, double mu, const Vector3& z);

/// The projection of Alart and Curnier: z_N onto the half line, then z_T onto the disc of radius mu z_N
/// [AC91]; r = p(r - u) holds exactly for solutions. P is a generalised derivative of p at z.
void alart_curnier_projection(BlockKind kind, double mu, const Vector3& z, Vector3& p, Matrix3& P);

/// The natural map's Euclidean norm over the scaled problem, |r - P_K(r - û)|.
double natural_map(const ContactSystem& system, const Columns3& r, const Columns3& u);

}  // namespace perp
