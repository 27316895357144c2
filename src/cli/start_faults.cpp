#include "cli/start_faults.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>

namespace perp {
namespace {

/// "0.05" of six digits.
std::string brief(double x) {
  char text[32];
  std::snprintf(text, sizeof text, "%.6g", x);
  return text;
}

}  // namespace

StartJudge::StartJudge(const Scene& scene, const Instant& now) : scene_(scene), now_(now) {
  for (const Pose& X : now.X) length_ = std::max(length_, X.p.cwiseAbs().maxCoeff());
  for (const ContactInstant& c : now.contacts) length_ = std::max(length_, c.position.cwiseAbs().maxCoeff());
  for (const JointGeometry& j : scene.model.joints())
    length_ = std::max({length_, j.anchor_a.norm(), j.anchor_b.norm()});
  for (const Twist& V : now.V) speed_ = std::max({speed_, V.v.norm(), V.w.norm() * length_});
}

std::vector<StartFault> StartJudge::contact(const ContactInstant& c) const {
  const std::string name = "contact " + (*scene_.model.point_names())[static_cast<std::size_t>(c.point)];
  const double u = c.velocity(scene_.start.nu)[0];
  std::vector<StartFault> faults;
  if (is_length(-c.psi_n)) faults.push_back({name + " overlaps by " + brief(-c.psi_n) + " m", -c.psi_n});
  if (!is_length(std::abs(c.psi_n)) && is_speed(-u))
    faults.push_back({name + " is closed and closes at " + brief(-u) + " m/s: an impact in the first step"});
  return faults;
}

std::pair<double, double> StartJudge::joint_error(std::size_t number) const {
  double error = 0, speed = 0;
  for (const JointRowInstant& row : now_.joint_rows)
    if (row.joint == static_cast<int>(number)) {
      error = std::max(error, std::abs(row.psi_b));
      speed = std::max(speed, std::abs(row.velocity(scene_.start.nu)));
    }
  return {error, speed};
}

std::vector<StartFault> StartJudge::joint(std::size_t number) const {
  const auto [error, speed] = joint_error(number);
  const std::string name = "joint " + scene_.model.joints()[number].name;
  std::vector<StartFault> faults;
  if (is_length(error)) faults.push_back({name + " is open by " + brief(error) + " m or rad", error});
  if (is_speed(speed)) faults.push_back({name + " opens at " + brief(speed) + " m/s or rad/s"});
  return faults;
}

std::vector<StartFault> StartJudge::all() const {
  std::vector<StartFault> faults;
  const auto add = [&](const std::vector<StartFault>& more) {
    faults.insert(faults.end(), more.begin(), more.end());
  };
  for (const ContactInstant& c : now_.contacts) add(contact(c));
  for (std::size_t j = 0; j < scene_.model.joints().size(); ++j) add(joint(j));
  return faults;
}

}  // namespace perp
