// Velocities that change at once: collisions, joints and stops that jerk, and jams without a collision.
#pragma once

#include <string_view>
#include <vector>

#include "perp/step/stepper.hpp"

namespace perp {

enum class Restitution {
  Newton,  ///< u_n+ >= -e u_n- at contacts that approach
  Poisson  ///< the normal impulse of the decompression is e times that of the compression
};

enum class ImpactOrder {
  Simultaneous,  ///< all contacts that touch at once
  Sequential     ///< one pair of bodies after the other, that which approaches fastest first, until none does
};

[[nodiscard]] std::string_view name_of(ImpactOrder order);  ///< "simultaneous", "sequential"
/// Throws std::invalid_argument for a name that is none.
[[nodiscard]] ImpactOrder impact_order_named(std::string_view name);

struct ImpactOptions {
  Restitution restitution = Restitution::Newton;
  ImpactOrder order = ImpactOrder::Simultaneous;
  bool without_collision = false;   ///< find impulses though nothing approaches: where CP1 has no solution
  double small_gap = not_set;       ///< contacts touch up to it [m]; 1e-10 of the largest length if not set
  std::vector<int> inelastic = {};  ///< points (of all the model's) that count with e = 0
  std::vector<int> only = {};       ///< points that count at all; all if empty
};

/// One contact point in an impact. World axes.
struct ImpactContact {
  int contact = 0;                       ///< in Model::contacts()
  int point = 0;                         ///< among all points of the model
  Vector3 impulse = Vector3::Zero();     ///< on b [N s]
  Vector3 moment = Vector3::Zero();      ///< of torsion and rolling on b [N m s]
  double p_n = 0;                        ///< >= 0 [N s]
  double approach = 0;                   ///< u_n- [m/s]
  double rebound = 0;                    ///< u_n+ [m/s]
  double friction = 0;                   ///< work of friction and moments [J], <= 0 on surfaces that rest
  ContactMode mode = ContactMode::Open;  ///< of p: Open where it is zero; of several impulses the last
};

struct Impact {
  bool solved = false;
  Vector nu;                            ///< nu+ (nv); nu- unless solved
  std::vector<ImpactContact> contacts;  ///< those that touch, in the model's order
  Vector joint_reactions;               ///< of each joint equation of the instant [N s, N m s]
  double energy = 0;                    ///< change of kinetic energy [J]
  double residual = not_set;            ///< of the friction problem, relative; of several the largest [-]
  int stages = 1;                       ///< impacts that followed each other; 1 of Simultaneous
  bool ambiguous =
      false;  ///< of Sequential: pairs approached alike, and another order gives other velocities
};

/// All contacts that touch and all joints at once: find nu+, p with
///   M (nu+ - nu-) = W_n p_n + W_f p_f + W_b p_b,   W_b^T nu+ + dpsi_b/dt = 0
///   0 <= p_n ⟂ u_n+ + e min(u_n-, 0) >= 0,   p_f = -mu p_n u_f+/|u_f+|, or |p_f| <= mu p_n where u_f+ = 0
/// with the circular cone, by solve_friction. Dry friction of joints, whose force is bounded, has no part in it.
///
/// Impacts at several contacts are one event. Of three equal balls in a row, the first with velocity 1 and e = 1, this makes
/// (-1/3, 2/3, 2/3): both contacts' velocities -1 and 0 become 1 and 0. ImpactOrder::Sequential makes (0, 0, 1): the law above for
/// the contacts of one pair of bodies alone, again and again, each time of the pair that approaches fastest. Rigid bodies do not tell which
/// is right. Pairs that approach alike to rounding are struck together, and `ambiguous` says if one after the other would end otherwise.
/// Stages that would go on without end (e < 1) end where nothing approaches faster than rounding.
///
/// Newton's restitution with friction may add energy (Kane's paradox); then Poisson's law takes its place, and e = 0 where that adds
/// some too.
[[nodiscard]] Impact solve_impact(const Model& model, const State& x, const ImpactOptions& options = {});

}  // namespace perp
