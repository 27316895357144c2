// How much contacts and joints give in the rule for redundant reactions: doc/methods/redundant.md.
#pragma once

#include "perp/instant/instant.hpp"

namespace perp {

// Of one row, as a displacement a unit of impulse, relative to all others: 1 [-] of rows in m (contacts, points of joints), 1/L² [1/m²]
// of rows in rad, L the largest radius of gyration of the bodies that the joint connects. Only ratios count.
[[nodiscard]] double compliance_of(const Model& model,
                                   const ContactInstant& contact);  ///< of each of n, t, o
[[nodiscard]] double moments_compliance_of(const Model& model,
                                           const ContactInstant& contact);  ///< of torsion and rolling
[[nodiscard]] double compliance_of(const Model& model,
                                   const JointRowInstant& row);  ///< an equation or a friction

}  // namespace perp
