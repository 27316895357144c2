// Blocks of three rows at most that one coefficient describes.
#pragma once

#include "solve/blocks/block.hpp"

namespace perp {

/// A half line, planar contact, circular cone or interval in a column of three rows.
Block<3> disc_block(BlockKind kind, double mu);

/// alart_curnier_projection() of disc_block().
void alart_curnier_projection(BlockKind kind, double mu, const Vector3& z, Vector3& p, Matrix3& P);

}  // namespace perp
