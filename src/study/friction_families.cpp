#include "perp/study/friction_families.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "contact_assembly.hpp"
#include "perp/core/errors.hpp"
#include "sphere_packing.hpp"

namespace perp {
namespace {

constexpr double gravity = 9.81;
constexpr int world = ContactAssembly::fixed;

Matrix3 about(const Vector3& axis, double angle) {
  return Eigen::AngleAxisd(angle, axis.normalized()).toRotationMatrix();
}

/// Friction coefficients as families draw them: mostly ordinary, at times nearly none or very rough.
double draw_mu(Random& random) {
  const double which = random.uniform(0, 1);
  if (which < 0.1) return random.decades(-4, -1);
  if (which < 0.2) return random.uniform(1.5, 5);
  return random.uniform(0.1, 1.2);
}

/// Contacts at the corners of the rectangle [x0, x1] x [y0, y1] at height z, b above a.
void add_patch(ContactAssembly& assembly, int a, int b, double x0, double x1, double y0, double y1, double z,
               double mu, double e = 0) {
  for (const double x : {x0, x1})
    for (const double y : {y0, y1}) assembly.add_contact(a, b, {x, y, z}, Vector3::UnitZ(), mu, 0, e);
}

ContactAssembly box(Random& random, int side) {
  ContactAssembly assembly(random.decades(-4, -1.5));
  const double size = random.decades(-1.5, 0.5);
  const Vector3 sides =
      size * Vector3(random.uniform(0.3, 2), random.uniform(0.3, 2), random.uniform(0.1, 3));
  const int body = assembly.add_box(random.decades(-3, 3), sides, Matrix3::Identity(), {0, 0, sides.z() / 2});
  const double mu = draw_mu(random), e = random.chance(0.3) ? random.uniform(0, 0.9) : 0;
  for (int i = 0; i < side; ++i)
    for (int j = 0; j < side; ++j)
      assembly.add_contact(
          world, body,
          {sides.x() * (double(i) / (side - 1) - 0.5), sides.y() * (double(j) / (side - 1) - 0.5), 0},
          Vector3::UnitZ(), mu, 0, e);
  const double tilt = random.uniform(0, 1.2);
  assembly.gravity(about(random.vector(1), tilt) * Vector3(0, 0, -gravity));
  if (random.chance(0.7)) {
    const double speed = random.decades(-3, 1);
    assembly.set_velocity(body, random.vector(speed), random.vector(speed / size));
  }
  return assembly;
}

ContactAssembly stack(Random& random, bool large) {
  ContactAssembly assembly(random.decades(-3.5, -2));
  const int count = large ? random.integer(26, 40) : random.integer(2, 20);
  const double ratio = random.decades(0, 6), side = random.decades(-1, 0);
  const bool heavy_on_top = random.chance(0.6);
  const double mu = draw_mu(random);
  double x = 0, y = 0, z = 0;
  for (int i = 0; i < count; ++i) {
    const double share = double(i) / (count - 1), height = side * random.uniform(0.3, 1);
    const double mass = std::pow(ratio, heavy_on_top ? share : 1 - share);
    const double width = side * random.uniform(0.9, 1.1);
    const double old_x = x, old_y = y;
    x += side * random.uniform(-0.05, 0.05);
    y += side * random.uniform(-0.05, 0.05);
    const int body =
        assembly.add_box(mass, {width, width, height}, Matrix3::Identity(), {x, y, z + height / 2});
    const double reach = 0.42 * side, shift_x = (x + old_x) / 2, shift_y = (y + old_y) / 2;
    add_patch(assembly, i == 0 ? world : body - 1, body, shift_x - reach, shift_x + reach, shift_y - reach,
              shift_y + reach, z, random.chance(0.5) ? mu : draw_mu(random));
    if (random.chance(0.3))
      assembly.set_velocity(body, random.vector(random.decades(-2, 0.5)), Vector3::Zero());
    z += height;
  }
  assembly.gravity({0, 0, -gravity});
  return assembly;
}

FrictionProblem wall(Random& random, bool large) {
  ContactAssembly assembly(random.decades(-3.5, -2));
  const int rows = large ? random.integer(5, 7) : random.integer(2, 4);
  const int bricks = large ? random.integer(4, 6) : random.integer(2, 3);
  const double length = random.decades(-1, 0.3), depth = length / 2, height = length / 3;
  const double mu = draw_mu(random), density = random.decades(2, 4);
  std::vector<std::vector<std::pair<int, double>>> laid(rows);  // number and left end of each brick
  for (int row = 0; row < rows; ++row)
    for (int k = 0; k < bricks; ++k) {
      const double left = length * (k + (row % 2 == 0 ? 0 : 0.5)), z = row * height;
      const int body = assembly.add_box(density * length * depth * height, {length, depth, height},
                                        Matrix3::Identity(), {left + length / 2, depth / 2, z + height / 2});
      if (row == 0)
        add_patch(assembly, world, body, left, left + length, 0, depth, 0, mu);
      else
        for (const auto& [below, start] : laid[row - 1]) {
          const double from = std::max(left, start), to = std::min(left, start) + length;
          if (to - from > 0.1 * length) add_patch(assembly, below, body, from, to, 0, depth, z, mu);
        }
      if (k > 0)  // the head joint between neighbours
        for (const double y : {0.0, depth})
          for (const double up : {0.0, height})
            assembly.add_contact(body - 1, body, {left, y, z + up}, Vector3::UnitX(), mu);
      laid[row].emplace_back(body, left);
    }
  assembly.gravity(about(Vector3::UnitX(), random.chance(0.3) ? random.uniform(0, 0.5) : 0) *
                   Vector3(0, 0, -gravity));
  const auto& hit_row = laid[random.integer(0, rows - 1)];
  const int hit = hit_row[random.integer(0, bricks - 1)].first;
  assembly.set_velocity(hit, random.vector(random.decades(-2, 1)), random.vector(1));
  return assembly.problem();
}

FrictionProblem kapla(Random& random, bool large, int contacts) {
  ContactAssembly assembly(random.decades(-3.5, -2));
  int layers = large ? random.integer(5, 8) : random.integer(2, 4);
  int planks = large ? 3 : random.integer(2, 3);
  if (contacts > 0) {
    planks = contacts < 4 * 9 ? 2 : 3;
    layers = std::max(1, contacts / (4 * planks * planks));
  }
  const double length = 0.12, width = 0.024, height = 0.008, mass = random.decades(-3, 0),
               mu = draw_mu(random);
  const double pitch = (length - width) / (planks - 1);
  std::vector<int> below(planks, world);
  for (int layer = 0; layer < layers; ++layer) {
    std::vector<int> above;
    const bool along_x = layer % 2 == 0;
    for (int k = 0; k < planks; ++k) {
      const double across = k * pitch + width / 2, middle = length / 2;
      const Vector3 position(along_x ? middle : across, along_x ? across : middle, (layer + 0.5) * height);
      const Vector3 sides(along_x ? length : width, along_x ? width : length, height);
      const int body =
          assembly.add_box(mass * random.uniform(0.9, 1.1), sides, Matrix3::Identity(), position);
      above.push_back(body);
      for (int j = 0; j < planks; ++j) {
        const double a0 = j * pitch, b0 = k * pitch;  // ends of the crossing along and across this plank
        const double x0 = along_x ? a0 : b0, y0 = along_x ? b0 : a0;
        add_patch(assembly, below[j], body, x0, x0 + width, y0, y0 + width, layer * height, mu);
      }
      if (random.chance(0.2))
        assembly.set_velocity(body, random.vector(random.decades(-2, 0)), Vector3::Zero());
    }
    below = above;
  }
  assembly.gravity({0, 0, -gravity});
  return assembly.problem();
}

ContactAssembly spheres(Random& random, bool large) {
  ContactAssembly assembly(random.decades(-3.5, -2));
  const int side = large ? random.integer(4, 5) : random.integer(2, 3);
  const int layers = large ? random.integer(3, 5) : random.integer(1, 4);
  const double radius = random.decades(-2, 0), mu = draw_mu(random), spread = random.uniform(0, 0.02);
  const double ratio = random.decades(0, 3), play = radius * random.decades(-3, -1.5);
  std::vector<int> bodies;
  for (int layer = 0; layer < layers; ++layer) {
    const int row = side - layer % 2;  // each ball of an odd layer sits in a dimple
    const double first = radius * (1 + layer % 2), z = radius * (1 + layer * std::numbers::sqrt2);
    for (int i = 0; i < row; ++i)
      for (int j = 0; j < row; ++j) {
        const Vector3 position(first + 2 * radius * i, first + 2 * radius * j, z);
        const int body = assembly.add_sphere(std::pow(ratio, random.uniform(0, 1)), radius, position);
        const auto gap = [&] { return random.chance(0.5) ? 0 : random.uniform(0, spread * radius); };
        const double reach = 1.001 * radius;
        if (position.z() < reach)
          assembly.add_contact(world, body, position - radius * Vector3::UnitZ(), Vector3::UnitZ(), mu,
                               gap());
        for (int axis = 0; axis < 2; ++axis) {
          const Vector3 n = Vector3::Unit(axis);
          if (position(axis) < reach) assembly.add_contact(world, body, position - radius * n, n, mu, gap());
          if (position(axis) > 2 * radius * side - reach)  // the far wall leaves some play
            assembly.add_contact(world, body, position + radius * n, -n, mu, play);
        }
        for (const int other : bodies) {
          const Vector3 d = position - assembly.position(other);
          if (d.norm() < 2 * reach) assembly.add_contact(other, body, position - d / 2, d, mu, gap());
        }
        bodies.push_back(body);
        const double speed = random.decades(-2, 0.5);
        assembly.set_velocity(body, random.vector(speed), random.vector(speed / radius));
      }
  }
  assembly.gravity({0, 0, -gravity});
  return assembly;
}

/// A peg along z between four walls, `rings` rings of four contacts.
struct Peg {
  ContactAssembly assembly;
  int body;
  double half, length;
  std::vector<Vector3> points, normals;
};

Peg make_peg(Random& random, int rings, double mu) {
  Peg peg{ContactAssembly(random.decades(-3.5, -2)), 0, random.decades(-2, -0.5), 0, {}, {}};
  peg.length = peg.half * random.uniform(2, 10);
  peg.body = peg.assembly.add_box(random.decades(-2, 2), {2 * peg.half, 2 * peg.half, peg.length},
                                  Matrix3::Identity(), Vector3::Zero());
  for (int ring = 0; ring < rings; ++ring) {
    const double z = peg.length * (rings == 1 ? 0 : double(ring) / (rings - 1) - 0.5);
    for (const double sign : {1.0, -1.0})
      for (int axis = 0; axis < 2; ++axis) {
        peg.normals.push_back(-sign * Vector3::Unit(axis));
        Vector3 point = sign * peg.half * Vector3::Unit(axis) + z * Vector3::UnitZ();
        point(1 - axis) = peg.half * random.uniform(-0.9, 0.9);
        peg.points.push_back(point);
        peg.assembly.add_contact(world, peg.body, point, peg.normals.back(), mu);
      }
  }
  peg.assembly.push(peg.body, random.vector(random.decades(0, 3)));
  peg.assembly.gravity({0, 0, -gravity});
  const double speed = random.decades(-2, 0.5);
  peg.assembly.set_velocity(peg.body, random.vector(speed), random.vector(speed / peg.length));
  return peg;
}

FrictionProblem peg(Random& random, bool large) {
  const double mu = random.chance(0.5) ? random.uniform(0.5, 3) : draw_mu(random);
  Peg peg = make_peg(random, large ? random.integer(26, 40) : random.integer(2, 12), mu);
  // the hole moves as a rigid body, some of its walls a little away from the peg
  const double speed = random.decades(-2, 0);
  const Vector3 v = random.vector(speed), w = random.vector(speed / peg.length);
  for (int c = 0; c < peg.assembly.contacts(); ++c) {
    const double slack = random.chance(0.5) ? 0 : random.uniform(0, 0.1 * speed);
    peg.assembly.move(c, v + w.cross(peg.points[c]) - slack * peg.normals[c]);
  }
  return peg.assembly.problem();
}

FrictionProblem infeasible_peg(Random& random, bool large) {
  Peg peg = make_peg(random, large ? random.integer(26, 40) : random.integer(2, 12), draw_mu(random));
  // two contacts face each other on one line and close on the peg; the others do as they like
  const double z = peg.length * random.uniform(-0.5, 0.5), speed = random.decades(-2, 0);
  for (const double sign : {1.0, -1.0}) {
    peg.assembly.add_contact(world, peg.body, {sign * peg.half, 0, z}, {-sign, 0, 0}, draw_mu(random));
    const double closing = speed * (sign > 0 ? 1 : random.uniform(-0.5, 1));
    peg.assembly.move(peg.assembly.contacts() - 1, -sign * closing * Vector3::UnitX());
  }
  return peg.assembly.problem();
}

FrictionProblem wedge(Random& random, bool large) {
  ContactAssembly assembly(random.decades(-3.5, -2));
  const int count = large ? random.integer(9, 14) : random.integer(1, 7);
  const double angle = random.uniform(0.05, 0.7);  // of each side from the vertical
  const double critical = std::tan(angle), mu = critical * random.decades(-0.5, 0.7);
  const double height = random.decades(-1.5, 0), depth = height * random.uniform(0.5, 2),
               bottom = height * random.uniform(0.2, 1);
  for (int i = 0; i < count; ++i) {
    const double z0 = i * height, z1 = z0 + height;
    const double half_width = bottom + (z0 + z1) / 2 * critical;
    const int body = assembly.add_box(random.decades(-1, 1), {2 * half_width, depth, height},
                                      Matrix3::Identity(), {0, 0, (z0 + z1) / 2});
    for (const double sign : {1.0, -1.0})
      for (const double z : {z0, z1})
        for (const double y : {-depth / 2, depth / 2})
          assembly.add_contact(world, body, {sign * (bottom + z * critical), y, z},
                               {-sign * std::cos(angle), 0, std::sin(angle)}, mu);
    if (i > 0) {
      const double reach = bottom + z0 * critical;
      add_patch(assembly, body - 1, body, -reach, reach, -depth / 2, depth / 2, z0, draw_mu(random));
    }
    assembly.set_velocity(body, Vector3(0, 0, -random.decades(-2, 1)) + random.vector(0.1),
                          random.vector(0.5));
  }
  assembly.gravity({0, 0, -gravity});
  return assembly.problem();
}

FrictionProblem painleve(Random& random, bool large) {
  ContactAssembly assembly(random.decades(-4, -2));
  const int count = large ? random.integer(80, 120) : random.integer(1, 20);
  const double half = random.decades(-1, 0.3);
  Vector3 last_tip = Vector3::Zero();
  for (int i = 0; i < count; ++i) {
    const double angle = random.uniform(0.4, 1.4), mass = random.decades(-1, 1);
    const Vector3 along(std::cos(angle), 0, std::sin(angle)), centre = half * along + Vector3(i * half, 0, 0);
    const Matrix3 inertia =
        mass / 3 * half * half * (1.0001 * Matrix3::Identity() - along * along.transpose());
    const int rod = assembly.add_body(mass, inertia, centre);
    assembly.add_contact(world, rod, centre - half * along, Vector3::UnitZ(), random.uniform(1.0, 10.0));
    if (i > 0 && random.chance(0.4))
      assembly.add_contact(rod - 1, rod, last_tip,
                           Vector3(random.uniform(0.2, 1), random.uniform(-0.3, 0.3), 0.5), draw_mu(random));
    last_tip = centre + half * along;
    const double speed = random.decades(-1, 1);
    assembly.set_velocity(rod, {(random.chance(0.5) ? speed : -speed), random.uniform(-0.2, 0.2), 0},
                          Vector3(0, random.uniform(-1, 1), 0));
  }
  assembly.gravity({0, 0, -gravity});
  return assembly.problem();
}

/// The contacts of a packing, lowest spheres first, as long as they are no more than `most`; `walled` says along which axes there are walls.
ContactAssembly contacts_of(const SpherePacking& packing, double step, double density, bool walled_x,
                            double mu, int most) {
  constexpr double near = 0.01;  // of the smaller radius: a gap that a step may close
  ContactAssembly assembly(step);
  std::vector<int> bodies;
  for (std::size_t i = 0; i < packing.centre.size(); ++i) {
    const Vector3& p = packing.centre[i];
    const double r = packing.radius[i];
    struct Touch {
      int other;
      Vector3 point, normal;
      double gap;
    };
    std::vector<Touch> found;
    const auto wall = [&](const Vector3& n, double gap) {
      if (gap < near * r) found.push_back({world, p - r * n, n, std::max(gap, 0.0)});
    };
    wall(Vector3::UnitZ(), p.z() - r);
    wall(Vector3::UnitY(), p.y() - r);
    wall(-Vector3::UnitY(), packing.box.y() - p.y() - r);
    if (walled_x) wall(Vector3::UnitX(), p.x() - r);
    if (walled_x) wall(-Vector3::UnitX(), packing.box.x() - p.x() - r);
    for (std::size_t j = 0; j < i; ++j) {
      const Vector3 d = p - packing.centre[j];
      const double reach = r + packing.radius[j] + near * std::min(r, packing.radius[j]);
      if (std::abs(d.z()) > reach || d.squaredNorm() > reach * reach) continue;
      const double distance = d.norm();
      found.push_back({bodies[j], packing.centre[j] + packing.radius[j] / distance * d, d,
                       std::max(distance - r - packing.radius[j], 0.0)});
    }
    if (assembly.contacts() + static_cast<int>(found.size()) > most) break;
    bodies.push_back(assembly.add_sphere(density * 4 / 3 * std::numbers::pi * std::pow(r, 3), r, p));
    for (const Touch& t : found) assembly.add_contact(t.other, bodies.back(), t.point, t.normal, mu, t.gap);
  }
  return assembly;
}

/// How many spheres have so many contacts at least.
int spheres_of(int contacts) { return std::max(2, static_cast<int>(contacts / 2.2)); }

/// Radii alike in a third of the packings, else up to 5 to 8 times the smallest.
SpherePacking draw_packing(Random& random, int contacts, bool alike) {
  const double largest = random.decades(-3, -1);
  return pack_spheres(random, spheres_of(contacts), largest, alike ? 1.05 : random.uniform(5.2, 8));
}

FrictionProblem pile(Random& random, int contacts) {
  const bool alike = random.chance(0.5);
  const SpherePacking packing = draw_packing(random, contacts, alike);
  const double mu = random.chance(0.3) ? 1 : draw_mu(random);
  ContactAssembly assembly =
      contacts_of(packing, random.decades(-3.5, -2), random.decades(2.5, 4), true, mu, contacts);
  assembly.gravity({0, 0, -gravity});
  const double largest = *std::max_element(packing.radius.begin(), packing.radius.end());
  if (random.chance(0.5)) {  // it still trembles
    const double speed = std::sqrt(gravity * largest) * random.decades(-3, -0.5);
    for (int b = 0; b < assembly.bodies(); ++b)
      assembly.set_velocity(b, random.vector(speed), random.vector(speed / largest));
  }
  return assembly.problem();
}

/// A packing that flows down an inclined channel, the faster the higher.
FrictionProblem chute(Random& random, int contacts) {
  const bool alike = random.chance(0.35);
  const SpherePacking packing = draw_packing(random, contacts, alike);
  const double mu = random.chance(0.5) ? 1 : random.uniform(0.2, 0.8);
  ContactAssembly assembly =
      contacts_of(packing, random.decades(-3.5, -2), random.decades(2.5, 4), false, mu, contacts);
  assembly.gravity(about(Vector3::UnitY(), -random.uniform(0.2, 0.7)) * Vector3(0, 0, -gravity));
  const double largest = *std::max_element(packing.radius.begin(), packing.radius.end());
  const double rate = std::sqrt(gravity / largest) * random.decades(-2, 0), noise = 0.1 * rate * largest;
  for (int b = 0; b < assembly.bodies(); ++b)
    assembly.set_velocity(b, rate * assembly.position(b).z() * Vector3::UnitX() + random.vector(noise),
                          rate / 2 * Vector3::UnitY() + random.vector(noise / largest));
  return assembly.problem();
}

/// Piles of spheres, stacks or a box of at most so many contacts, with moments at them: over the normal reaction 10^-3 to 1 of a
/// length of the bodies, at one contact in ten none, in half of the problems the same at all.
FrictionProblem with_moments(Random& random, bool large, bool torsion, bool rolling, int most) {
  constexpr int tries = 20;  // then a box, which has four contacts
  const double which = random.uniform(0, 1);
  ContactAssembly assembly(0);
  for (int i = 0; i == 0 || assembly.contacts() > most; ++i)
    assembly = i < tries && which < 0.6   ? spheres(random, large && i < tries / 2)
               : i < tries && which < 0.9 ? stack(random, large && i < tries / 2)
                                          : box(random, 2);
  const double length =
      assembly.position(0).z();  // of the first body over the floor: a radius, or half a height
  const bool alike = random.chance(0.5);
  const auto draw = [&] { return random.chance(0.1) ? 0 : length * random.decades(-3, 0); };
  const double torsion_of_all = draw(), rolling_of_all = draw();
  for (int c = 0; c < assembly.contacts(); ++c) {
    if (torsion) assembly.set_torsion(c, alike ? torsion_of_all : draw());
    if (rolling) assembly.set_rolling(c, alike ? rolling_of_all : draw());
    if (random.chance(0.05)) assembly.set_mu(c, 0);
  }
  return assembly.problem();
}

}  // namespace

const std::vector<std::string>& friction_families() {
  static const std::vector<std::string> names{"box4",    "box16",   "stack", "wall",     "kapla",
                                              "spheres", "peg",     "wedge", "painleve", "infeasible-peg",
                                              "torsion", "rolling", "twist", "pile",     "chute"};
  return names;
}

bool takes_contacts(std::string_view family) {
  return family == "kapla" || family == "torsion" || family == "rolling" || family == "twist" ||
         family == "pile" || family == "chute";
}

FrictionProblem friction_family(std::string_view family, std::uint64_t seed, int index, int contacts) {
  const auto& names = friction_families();
  const auto found = std::find(names.begin(), names.end(), family);
  Random seeds(seed * 1000003u + static_cast<std::uint64_t>(found - names.begin()) * 7919u +
               static_cast<std::uint64_t>(index));
  Random random(seeds.bits());
  const bool large = index % 3 == 2;
  const int most = contacts > 0 ? contacts : 300;
  const auto packed = [&] {
    return contacts > 0 ? contacts : large ? random.integer(110, 200) : random.integer(10, 80);
  };
  if (family == "box4") return box(random, 2).problem();
  if (family == "box16") return box(random, 4).problem();
  if (family == "stack") return stack(random, large).problem();
  if (family == "wall") return wall(random, large);
  if (family == "kapla") return kapla(random, large, contacts);
  if (family == "spheres") return spheres(random, large).problem();
  if (family == "peg") return peg(random, large);
  if (family == "wedge") return wedge(random, large);
  if (family == "painleve") return painleve(random, large);
  if (family == "infeasible-peg") return infeasible_peg(random, large);
  if (family == "torsion") return with_moments(random, large, true, false, most);
  if (family == "rolling") return with_moments(random, large, false, true, most);
  if (family == "twist") return with_moments(random, large, true, true, most);
  if (family == "pile") return pile(random, packed());
  if (family == "chute") return chute(random, packed());
  std::string known;
  for (const std::string& name : names) known += " " + name;
  refuse("friction_family", "family", family, "one of" + known + " is needed");
}

}  // namespace perp
