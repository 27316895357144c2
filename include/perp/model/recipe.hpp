// How a thing made of functions was made, so that it can be written down and made again.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "perp/core/pose.hpp"

namespace perp {

/// A maker's name and what it was given: "sphere_on_plane" and radius, normal, point. Gaps, motions and forces carry one; it
/// is empty where a function of one's own made them, which no file can say.
struct Recipe {
  std::string_view maker;          ///< a literal: lives as long as the program
  std::vector<double> numbers;     ///< all arguments that are numbers, one after the other
  std::vector<std::string> texts;  ///< those that are expressions
  std::vector<Pose> places = {};   ///< of a gap that was `placed`: where its shapes sit in A and in B

  bool known() const { return !maker.empty(); }
};

}  // namespace perp
