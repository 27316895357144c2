// Families of contact problems for measuring solvers: one step of assemblies that are hard in a known way.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "perp/solve/friction_problem.hpp"

namespace perp {

/// The families' names:
///   box4, box16      a box on a tilted plane, 4 or 4x4 contacts, sliding, falling or at rest
///   stack            2 to 40 boxes, 4 contacts each, mass ratio over the stack 1 to 1e6, the heavy end up or down
///   wall             bricks in running bond with head joints, one of them hit
///   kapla            layers of planks laid crosswise, 4 contacts a crossing: many more contacts than freedoms
///   spheres          a close pile in an open box, gaps up to 2 % of the radius
///   peg              a peg in a hole that touches on all sides, pushed and tilted; jams at high friction
///   wedge            blocks in a V-shaped groove on top of each other, driven in
///   painleve         rods on a rough plane with mu past the paradox's threshold, some leaning on the next
///   torsion          spheres, stack or box4 with torsion at every contact (4 rows)
///   rolling          likewise with rolling (5 rows)
///   twist            with both (6 rows)
///   pile             spheres that lie in an open box, in half of the problems with radii up to 5 to 8 times the smallest
///   chute            such a packing that flows down a channel, mu 1 in half of the problems
///   infeasible-peg   a peg whose hole closes: no velocity keeps out of both sides
/// Parameters and ranges stand in doc/contact-problems.md.
const std::vector<std::string>& friction_families();

/// Member `index` of the family drawn from `seed`, in global form; the same bits on every machine with IEEE
/// arithmetic. A third of the members (index 2, 5, 8, ...) have more than 100 contacts where the family can.
/// Throws std::invalid_argument for an unknown family, naming the known ones.
/// `contacts` > 0 says how many: of pile, chute, torsion, rolling and twist at most so many, of the first two nearly so many; of kapla as many
/// whole layers. The others have as many as the family draws.
FrictionProblem friction_family(std::string_view family, std::uint64_t seed, int index, int contacts = 0);
/// Whether `contacts` matters to it.
bool takes_contacts(std::string_view family);

}  // namespace perp
