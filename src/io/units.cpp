#include "io/units.hpp"

#include <charconv>
#include <cmath>
#include <numbers>

namespace perp {
namespace {

struct Unit {
  std::string_view name;
  Dimension dimension;
  double times = 1, over = 1;  ///< both, so that 3 mm is the double next to 0.003
};

constexpr double pi = std::numbers::pi;
constexpr Unit units[] = {
    {"m", Dimension::Length},
    {"km", Dimension::Length, 1e3},
    {"cm", Dimension::Length, 1, 1e2},
    {"mm", Dimension::Length, 1, 1e3},
    {"um", Dimension::Length, 1, 1e6},
    {"rad", Dimension::Angle},
    {"deg", Dimension::Angle, pi, 180},
    {"kg", Dimension::Mass},
    {"g", Dimension::Mass, 1, 1e3},
    {"t", Dimension::Mass, 1e3},
    {"s", Dimension::Time},
    {"ms", Dimension::Time, 1, 1e3},
    {"min", Dimension::Time, 60},
    {"m/s", Dimension::Velocity},
    {"mm/s", Dimension::Velocity, 1, 1e3},
    {"cm/s", Dimension::Velocity, 1, 1e2},
    {"km/h", Dimension::Velocity, 1, 3.6},
    {"rad/s", Dimension::Rate},
    {"deg/s", Dimension::Rate, pi, 180},
    {"rpm", Dimension::Rate, pi, 30},
    {"m/s^2", Dimension::Acceleration},
    {"N", Dimension::Force},
    {"mN", Dimension::Force, 1, 1e3},
    {"kN", Dimension::Force, 1e3},
    {"N m", Dimension::Moment},
    {"N mm", Dimension::Moment, 1, 1e3},
    {"N/m", Dimension::Stiffness},
    {"N/mm", Dimension::Stiffness, 1e3},
    {"kN/m", Dimension::Stiffness, 1e3},
    {"N s/m", Dimension::Damping},
    {"kg m^2", Dimension::Inertia},
    {"g mm^2", Dimension::Inertia, 1, 1e9},
    {"kg mm^2", Dimension::Inertia, 1, 1e6},
};

constexpr std::string_view names[] = {
    "any quantity", "a number without a unit", "a length",        "an angle", "a mass",   "a time",
    "a velocity",   "an angular velocity",     "an acceleration", "a force",  "a moment", "a stiffness",
    "a damping",    "a moment of inertia"};

/// "a length in m, km, cm, mm or um"
std::string allowed(Dimension dimension) {
  std::string text(names[static_cast<std::size_t>(dimension)]), list;
  for (const Unit& unit : units)
    if (unit.dimension == dimension || dimension == Dimension::Any) {
      list.append(list.empty() ? "" : ", ").append(unit.name);
    }
  return list.empty() ? text : text + " in one of " + list;
}

std::string_view trimmed(std::string_view text) {
  const std::size_t begin = text.find_first_not_of(" \t");
  if (begin == std::string_view::npos) return {};
  return text.substr(begin, text.find_last_not_of(" \t") + 1 - begin);
}

}  // namespace

std::optional<Quantity> read_quantity(std::string_view text, Dimension dimension) {
  const std::string_view whole = trimmed(text);
  const char* const end = whole.data() + whole.size();
  double value = 0;
  const auto read = std::from_chars(whole.data(), end, value);
  if (read.ec != std::errc()) return std::nullopt;
  const std::string_view name = trimmed({read.ptr, static_cast<std::size_t>(end - read.ptr)});
  const bool letter = !name.empty() && ((name[0] | 0x20) >= 'a' && (name[0] | 0x20) <= 'z');
  if (!letter) return std::nullopt;
  for (const Unit& unit : units)
    if (unit.name == name && (unit.dimension == dimension || dimension == Dimension::Any))
      return Quantity{value * unit.times / unit.over, unit.dimension, unit.name};
  throw ExpressionError("the unit '" + std::string(name) + "', needs " + allowed(dimension),
                        static_cast<std::size_t>(name.data() - text.data()));
}

std::string describe(Dimension dimension) { return std::string(names[static_cast<std::size_t>(dimension)]); }

}  // namespace perp
