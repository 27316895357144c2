#include "io/scene_table.hpp"

#include <algorithm>
#include <cmath>

#include "io/names.hpp"
#include "io/units.hpp"
#include "perp/core/errors.hpp"

namespace perp {

using Kind = TomlValue::Kind;

void SceneTable::refuse_at(const Place& place, std::string_view found, std::string_view allowed) const {
  perp::refuse_at(source_->file, place, found, allowed);
}

void SceneTable::refuse(std::string_view key, std::string_view found, std::string_view allowed) const {
  const TomlValue::Entry* entry = table_->find(key);
  refuse_at(entry == nullptr ? table_->place : entry->value.place, found, allowed);
}

const TomlValue::Entry* SceneTable::key_named(const std::invalid_argument& error) const {
  const std::string_view what = error.what();  // "WHERE: ARGUMENT is VALUE, NEED"
  for (const TomlValue::Entry& entry : table_->entries)
    for (const char* before : {": ", "."})
      if (what.find(before + entry.key + " is ") != std::string_view::npos) return &entry;
  return nullptr;
}

void SceneTable::refuse(const std::invalid_argument& error) const {
  const std::string_view what = error.what();
  const TomlValue::Entry* named = key_named(error);
  const std::size_t comma = std::min(what.find(", "), what.size());
  refuse_at(named == nullptr ? table_->place : named->value.place, what.substr(0, comma),
            what.substr(std::min(comma + 2, what.size())));
}

void SceneTable::allow(const std::vector<std::string>& keys) const {
  for (const TomlValue::Entry& entry : table_->entries)
    if (std::find(keys.begin(), keys.end(), entry.key) == keys.end())
      refuse_at(entry.place, "the key '" + entry.key + "'", "needs " + one_of(keys, entry.key));
}

const TomlValue& SceneTable::value(std::string_view key) const {
  const TomlValue::Entry* entry = table_->find(key);
  if (entry == nullptr)
    refuse_at(table_->place, "a table without the key '" + std::string(key) + "'", "needs it");
  return entry->value;
}

double SceneTable::number(const TomlValue& value, Dimension dimension) const {
  if (value.kind == Kind::Number) return value.number;
  const std::string need = "needs " + describe(dimension) + ": a number or a text with an expression";
  if (value.kind != Kind::Text) refuse_at(value.place, value.described(), need);
  if (const auto given = source_->dimensions.find(value.text);
      given != source_->dimensions.end() && dimension != Dimension::Any && given->second != dimension)
    refuse_at(value.place, value.key + " is the parameter '" + value.text + "', " + describe(given->second),
              "needs " + describe(dimension));
  const Expression constant = expression(value, {}, dimension);
  const double x = constant();
  if (!std::isfinite(x)) refuse_at(value.place, value.key + " = " + shortest(x), "needs to be finite");
  return x;
}

Expression SceneTable::expression(const TomlValue& value, const std::vector<std::string>& variables,
                                  Dimension dimension) const {
  try {
    if (value.kind == Kind::Number) return Expression(shortest(value.number), {});
    if (value.kind != Kind::Text)
      refuse_at(value.place, value.described(), "needs a number or a text with an expression");
    if (const auto quantity = read_quantity(value.text, dimension))
      return Expression(shortest(quantity->value), {});
    return Expression(value.text, source_->parameters, variables);
  } catch (const ExpressionError& error) {
    const std::string_view what = error.what();
    const std::size_t comma = what.find(", needs");
    Place place = value.text_begin;
    if (place.column != value.place.column) place.column += error.offset;
    refuse_at(place, value.key + " has " + std::string(what.substr(0, comma)), what.substr(comma + 2));
  }
}

double SceneTable::number(std::string_view key, Dimension dimension) const {
  return number(value(key), dimension);
}

double SceneTable::number(std::string_view key, Dimension dimension, double otherwise) const {
  return has(key) ? number(key, dimension) : otherwise;
}

const TomlValue& SceneTable::list(std::string_view key, std::size_t least, std::size_t most) const {
  const TomlValue& found = value(key);
  if (found.kind != Kind::List || found.items.size() < least || found.items.size() > most) {
    std::string need = "needs a list of " + std::to_string(least);
    if (most != least) need += most > 3 ? " or more" : " or " + std::to_string(most);
    refuse_at(found.place, found.described(), need);
  }
  return found;
}

std::vector<double> SceneTable::numbers(std::string_view key, std::size_t least, std::size_t most,
                                        Dimension dimension) const {
  std::vector<double> all;
  for (const TomlValue& item : list(key, least, most).items) all.push_back(number(item, dimension));
  return all;
}

Vector3 SceneTable::vector(const TomlValue& value, Dimension dimension) const {
  if (value.kind != Kind::List || value.items.size() < 2 || value.items.size() > 3)
    refuse_at(value.place, value.described(), "needs a list of 3 numbers, or of 2 in the xy plane");
  Vector3 v = Vector3::Zero();
  for (std::size_t i = 0; i < value.items.size(); ++i)
    v[static_cast<int>(i)] = number(value.items[i], dimension);
  return v;
}

Vector3 SceneTable::vector(std::string_view key, Dimension dimension) const {
  return vector(value(key), dimension);
}

Vector3 SceneTable::vector(std::string_view key, Dimension dimension, const Vector3& otherwise) const {
  return has(key) ? vector(key, dimension) : otherwise;
}

std::vector<Vector3> SceneTable::vectors(std::string_view key, std::size_t count, Dimension dimension) const {
  std::vector<Vector3> all;
  for (const TomlValue& item : list(key, count, count).items) all.push_back(vector(item, dimension));
  return all;
}

std::vector<Expression> SceneTable::expressions(std::string_view key,
                                                const std::vector<std::string>& variables,
                                                Dimension dimension) const {
  if (!has(key)) return std::vector<Expression>(3, Expression("0", {}));
  std::vector<Expression> all;
  for (const TomlValue& item : list(key, 2, 3).items) all.push_back(expression(item, variables, dimension));
  if (all.size() == 2) all.emplace_back("0", SceneParameters{});
  return all;
}

Expression SceneTable::expression(std::string_view key, const std::vector<std::string>& variables,
                                  Dimension dimension) const {
  return expression(value(key), variables, dimension);
}

const std::string& SceneTable::text(std::string_view key) const {
  const TomlValue& found = value(key);
  if (found.kind != Kind::Text) refuse_at(found.place, found.described(), "needs a text in quotes");
  return found.text;
}

std::string SceneTable::name() const {
  if (!has("name")) return {};
  const std::string& given = text("name");
  const bool fits = !given.empty() && std::all_of(given.begin(), given.end(), [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_' || c == '-';
  });
  if (!fits)
    refuse("name", "name is \"" + given + "\"",
           "needs letters, digits, '_' and '-' (it names columns of files)");
  return given;
}

std::size_t SceneTable::word(std::string_view key, const std::vector<std::string>& words) const {
  const std::string& given = text(key);
  const auto it = std::find(words.begin(), words.end(), given);
  if (it == words.end())
    refuse(key, std::string(key) + " is '" + given + "'", "needs " + one_of(words, given));
  return static_cast<std::size_t>(it - words.begin());
}

SceneTable SceneTable::table(std::string_view key) const {
  const TomlValue& found = value(key);
  if (found.kind != Kind::Table) refuse_at(found.place, found.described(), "needs a table");
  return {found, *source_};
}

std::vector<SceneTable> SceneTable::tables(std::string_view key) const {
  std::vector<SceneTable> all;
  if (!has(key)) return all;
  const TomlValue& found = value(key);
  const std::string need = "needs tables, each under the line [[" + std::string(key) + "]]";
  if (found.kind != Kind::List) refuse_at(found.place, found.described(), need);
  for (const TomlValue& item : found.items) {
    if (item.kind != Kind::Table) refuse_at(item.place, item.described(), need);
    all.emplace_back(item, *source_);
  }
  return all;
}

BodyId SceneTable::body(std::string_view key) const {
  const std::string& given = text(key);
  const auto it = source_->body_of.find(given);
  if (it == source_->body_of.end())
    refuse(key, std::string(key) + " is the body '" + given + "'", "needs " + one_of(source_->bodies, given));
  return {it->second};
}

Quaternion SceneTable::orientation() const {
  if (value("orientation").kind == TomlValue::Kind::Table) {
    const SceneTable turn = table("orientation");
    turn.allow({"axis", "angle"});
    const Vector3 axis = turn.vector("axis", Dimension::None);
    if (!(axis.norm() > 0)) turn.refuse("axis", "an axis of length 0", "needs a direction");
    return rotation(turn.number("angle", Dimension::Angle) * axis.normalized());
  }
  const std::vector<double> q = numbers("orientation", 4, 4, Dimension::None);
  const Quaternion wxyz(q[0], q[1], q[2], q[3]);
  constexpr double typed = 0.01;  // what digits left out may come to; more is another thing than a rotation
  if (!(std::abs(wxyz.norm() - 1) <= typed))
    refuse("orientation", "a quaternion of length " + shortest(wxyz.norm()),
           "needs w, x, y, z of a rotation, of length 1");
  return unit(wxyz);
}

}  // namespace perp
