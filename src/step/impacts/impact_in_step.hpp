// Impacts within a step of fixed size: which law of restitution a step may use without adding energy.
#pragma once

#include <array>
#include <functional>

#include "perp/instant/instant.hpp"

namespace perp {

/// What a contact that closed in a step has as its normal velocity u_n+ at least, after u_n- before. A step may hold several impacts,
/// of which the first makes contacts close that were opening before: Newton's law, that of one impact, may then add energy.
enum class Rebound : int {
  Newton,  ///< -e u_n- of contacts that approached, 0 of others
  Moreau,  ///< -e u_n- of all: what opened may approach as much; with one e and without friction it never adds energy
  Inelastic  ///< 0: never adds energy
};
constexpr std::array<Rebound, 3> rebounds{Rebound::Newton, Rebound::Moreau, Rebound::Inelastic};

/// What stands beside u_n+ in 0 <= p_n ⟂ u_n+ + (it) >= 0 [m/s].
[[nodiscard]] double restitution_term(Rebound law, double e, double u_n_before);

/// The kinetic energy that bodies may have after an impact in a step from x.nu: of each the larger of that before the step's loads and
/// that after them (at nu_free). `struck` says which bodies count.
class EnergyBefore {
 public:
  void set(const Model& model, const Instant& instant, const Vector& nu, const Vector& nu_free,
           const std::function<bool(std::size_t body)>& struck);
  /// Whether nu has more. Where contacts or joints are moved (explicit velocities) impacts add energy by right, and it never has.
  [[nodiscard]] bool exceeded(const Model& model, const Instant& instant, const Vector& nu) const;

 private:
  double energy_ = 0;  // [J]
  bool moved_ = false;
  std::vector<char> counts_;
};

}  // namespace perp
