// Maps of where a method is right, off, says that it fails, or is silently absurd, over two parameters of a scene.
#pragma once

#include <filesystem>
#include <functional>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "perp/core/types.hpp"

namespace perp {

/// One axis: a parameter of the scene, `h` (the step [s]), or a setting of penalty, at `count` values from low to high; geometric where both
/// are positive and a factor of 100 or more apart.
struct AtlasAxis {
  std::string name;
  double low = 0, high = 1;
  int count = 2;

  double value(int i) const;
  bool geometric() const { return low > 0 && high >= 100 * low; }
};

/// A=LO:HI:N. Throws std::invalid_argument naming `option` for what is not.
[[nodiscard]] AtlasAxis read_axis(const std::string& text, const std::string& option);

/// What a run came to, judged without asking the method.
enum class AtlasVerdict {
  Right,   ///< error at T within a hundredth of how far the motion goes; or nothing known against it
  Off,     ///< beyond that, without a word
  SaidSo,  ///< a step failed and said so
  Silent   ///< "solved" and absurd: NaN, energy from nothing, overlap, an open joint
};
enum class AtlasOutcome {
  Unknown,  ///< it did not come to T
  Sticks,   ///< contacts or joints with friction are closed at T and none slides
  Slides,   ///< one slides
  Jumps,    ///< a closed system's velocities jumped in the first step, as no load can make them
  Bounded,  ///< nothing touches; energy no more than at the start and from loads
  Grows     ///< energy has grown without a cause
};
[[nodiscard]] std::string_view name_of(AtlasVerdict verdict);  ///< "right", "off", "said-so", "silent"
[[nodiscard]] std::string_view name_of(AtlasOutcome outcome);  ///< "unknown", "sticks", ...

struct AtlasCell {
  std::string method;
  double a = 0, b = 0;
  AtlasVerdict verdict = AtlasVerdict::Right;
  AtlasOutcome outcome = AtlasOutcome::Unknown;
  double error = not_set;   ///< of the configuration at T, where a reference is known [m, rad]
  std::string reason = {};  ///< what said so, or what is absurd
};

struct AtlasRequest {
  std::string scene;  ///< built-in or a file
  std::vector<std::string> methods;
  AtlasAxis a, b;
  std::map<std::string, double> set = {}, set_method = {};
  double until = not_set;  ///< T [s]; the scene's own if not set
  double step = not_set;   ///< h [s]; T/100 if not set and no axis is h
};

/// The cell of one method at one place. The reference is the scene's exact motion, else a run of `event`; where neither comes to T, nothing is
/// known against an answer but that it is absurd: an overlap or open joint above a hundredth of the scene's length, an energy that rises
/// above all of loads, motors and surfaces by more than a tenth of the largest in the run (of a scene with springs only if its peaks keep
/// rising: what a step of first order swings about is no gain).
[[nodiscard]] AtlasCell atlas_cell(const AtlasRequest& request, const std::string& method, double a,
                                   double b);

/// All cells, methods in order, b outer and a inner.
[[nodiscard]] std::vector<AtlasCell> atlas(const AtlasRequest& request,
                                           const std::function<void(int done, int all)>& progress = {});

/// map.csv: method,A,B,verdict,outcome,error,reason; and for each method METHOD-map.svg: verdicts beside outcomes, each told by a sign as
/// well as by colour.
void write_atlas(const AtlasRequest& request, const std::vector<AtlasCell>& cells,
                 const std::filesystem::path& folder);

}  // namespace perp
