// A table of a scene file as its reader sees it: keys that are allowed, numbers with units and expressions, and refusals
// that say where.
#pragma once

#include <initializer_list>
#include <map>
#include <stdexcept>
#include <string>
#include <string_view>
#include <unordered_map>
#include <vector>

#include "io/toml_file.hpp"
#include "perp/io/expression.hpp"
#include "perp/model/model.hpp"

namespace perp {

/// What a number measures; decides which units it may be given in. `Any` is a parameter, which may measure anything.
enum class Dimension {
  Any,
  None,
  Length,
  Angle,
  Mass,
  Time,
  Velocity,
  Rate,
  Acceleration,
  Force,
  Moment,
  Stiffness,
  Damping,
  Inertia
};

/// What the reading of one file has found so far.
struct SceneSource {
  std::string file;
  SceneParameters parameters;
  std::map<std::string, Dimension, std::less<>> dimensions;  ///< of parameters that were given with a unit
  std::vector<std::string> bodies;                           ///< names, in the model's order
  std::unordered_map<std::string, int> body_of;              ///< where in the model
};

class SceneTable {
 public:
  SceneTable(const TomlValue& table, const SceneSource& source) : table_(&table), source_(&source) {}

  static constexpr std::size_t many = 1'000'000;

  /// Refuses the first key that is none of these.
  void allow(const std::vector<std::string>& keys) const;
  bool has(std::string_view key) const { return table_->find(key) != nullptr; }

  // Values of keys; without `otherwise` the key must be there. Numbers come in SI units.
  double number(std::string_view key, Dimension dimension) const;
  double number(std::string_view key, Dimension dimension, double otherwise) const;
  std::vector<double> numbers(std::string_view key, std::size_t least, std::size_t most,
                              Dimension dimension) const;
  Vector3 vector(std::string_view key, Dimension dimension) const;  ///< of 3 numbers, or of 2: then z = 0
  Vector3 vector(std::string_view key, Dimension dimension, const Vector3& otherwise) const;
  const std::string& text(std::string_view key) const;
  std::string name() const;  ///< the key "name", empty if it is not there
  /// One of the words; its place among them.
  std::size_t word(std::string_view key, const std::vector<std::string>& words) const;
  SceneTable table(std::string_view key) const;
  std::vector<SceneTable> tables(std::string_view key) const;  ///< of [[key]]; empty if there is none
  std::vector<Vector3> vectors(std::string_view key, std::size_t count, Dimension dimension) const;
  /// Of 3 expressions, or of 2: then the third is 0; all are 0 without the key.
  std::vector<Expression> expressions(std::string_view key, const std::vector<std::string>& variables,
                                      Dimension dimension) const;
  Expression expression(std::string_view key, const std::vector<std::string>& variables,
                        Dimension dimension) const;
  BodyId body(std::string_view key) const;
  /// Of the key "orientation": a quaternion w, x, y, z, or { axis, angle }.
  Quaternion orientation() const;

  /// A number, or a text that is a number with a unit or an expression in the parameters.
  double number(const TomlValue& value, Dimension dimension) const;

  /// Refuses at the value of `key`, or at the table if it does not have it.
  [[noreturn]] void refuse(std::string_view key, std::string_view found, std::string_view allowed) const;
  /// Whether the library's message is about the value of a key of this table.
  bool concerns(const std::invalid_argument& error) const { return key_named(error) != nullptr; }
  /// Refuses with the library's message, at the key that it names.
  [[noreturn]] void refuse(const std::invalid_argument& error) const;

  /// make(), its refusals placed in this table.
  template <class Make>
  auto placed(Make make) const {
    try {
      return make();
    } catch (const std::invalid_argument& error) {
      refuse(error);
    }
  }

  const TomlValue& toml() const { return *table_; }
  const SceneSource& source() const { return *source_; }

 private:
  const TomlValue::Entry* key_named(const std::invalid_argument& error) const;
  const TomlValue& value(std::string_view key) const;
  const TomlValue& list(std::string_view key, std::size_t least, std::size_t most) const;
  Expression expression(const TomlValue& value, const std::vector<std::string>& variables,
                        Dimension dimension) const;
  Vector3 vector(const TomlValue& value, Dimension dimension) const;
  [[noreturn]] void refuse_at(const Place& place, std::string_view found, std::string_view allowed) const;

  const TomlValue* table_;
  const SceneSource* source_;
};

}  // namespace perp
