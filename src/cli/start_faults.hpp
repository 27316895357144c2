// What does not fit together where a scene starts: by how much, and where.
#pragma once

#include <string>
#include <vector>

#include "perp/instant/instant.hpp"
#include "perp/study/scene.hpp"

namespace perp {

struct StartFault {
  std::string what;   ///< "contact floor overlaps by 0.05 m"
  double length = 0;  ///< overlap or open joint [m, rad]; 0: a velocity
};

/// Judges above rounding, in relation to the scene's extent (its largest coordinate, lever arm or speed).
class StartJudge {
 public:
  StartJudge(const Scene& scene, const Instant& now);
  std::vector<StartFault> contact(const ContactInstant& c) const;
  std::vector<StartFault> joint(std::size_t number) const;
  std::vector<StartFault> all() const;
  double length() const { return length_; }  ///< the scene's extent [m]

  /// |psi_b| and |rate| of a joint, the largest of its rows.
  std::pair<double, double> joint_error(std::size_t number) const;

 private:
  static constexpr double rounding = 1e-10;  ///< of starts that were typed with 10 digits or more
  bool is_length(double x) const { return x > rounding * length_; }
  bool is_speed(double u) const { return u > rounding * speed_; }

  const Scene& scene_;
  const Instant& now_;
  double length_ = 0, speed_ = 0;
};

}  // namespace perp
