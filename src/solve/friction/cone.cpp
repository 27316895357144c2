#include "solve/friction/cone.hpp"

namespace perp {

Block<3> disc_block(BlockKind kind, double mu) {
  const BlockLayout& layout = layout_of(kind);
  Block<3> block;
  block.contact = layout.contact;
  block.tangents = layout.place[static_cast<size_t>(layout.rows) - 1];
  block.radius = block.tangents > 0 ? mu : 0;
  block.axes = {0, block.radius, block.tangents > 1 ? mu : 0};
  return block;
}

void alart_curnier_projection(BlockKind kind, double mu, const Vector3& z, Vector3& p, Matrix3& P) {
  alart_curnier_projection(disc_block(kind, mu), z, p, P);
}

}  // namespace perp
