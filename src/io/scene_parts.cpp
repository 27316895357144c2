#include "io/scene_parts.hpp"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <memory>

#include "perp/core/errors.hpp"

namespace perp {
namespace {

using Kind = TomlValue::Kind;

bool is_tables(const TomlValue& value) {
  return value.kind == Kind::List &&
         std::all_of(value.items.begin(), value.items.end(),
                     [](const TomlValue& item) { return item.kind == Kind::Table; });
}

TomlValue::Entry& entry_of(TomlValue& table, const TomlValue::Entry& like) {
  for (TomlValue::Entry& entry : table.entries)
    if (entry.key == like.key) return entry;
  TomlValue::Entry& made = table.entries.emplace_back(like);
  made.value.items.clear();
  made.value.entries.clear();
  return made;
}

// include

/// Says of everything in it that it stands in `file`.
void mark(TomlValue& value, const std::shared_ptr<const std::string>& file) {
  value.place.file = value.text_begin.file = file;
  for (TomlValue& item : value.items) mark(item, file);
  for (TomlValue::Entry& entry : value.entries) {
    entry.place.file = file;
    mark(entry.value, file);
  }
}

/// The entries of `part` that `whole` has none of; lists of tables end to end, whole's first.
void add_missing(TomlValue& whole, TomlValue&& part) {
  for (TomlValue::Entry& entry : part.entries) {
    const auto own = std::find_if(whole.entries.begin(), whole.entries.end(),
                                  [&](const TomlValue::Entry& e) { return e.key == entry.key; });
    if (own == whole.entries.end())
      whole.entries.push_back(std::move(entry));
    else if (own->value.kind == Kind::Table && entry.value.kind == Kind::Table)
      add_missing(own->value, std::move(entry.value));
    else if (is_tables(own->value) && is_tables(entry.value))
      std::move(entry.value.items.begin(), entry.value.items.end(), std::back_inserter(own->value.items));
  }
}

/// `own` over what it includes.
TomlValue over(TomlValue&& own, TomlValue&& included) {
  TomlValue whole = own;
  whole.entries.clear();
  // an entry of both: a table's keys in the order of the included file, each with own's value; tables in lists: own's last
  for (TomlValue::Entry& entry : included.entries) {
    auto mine = std::find_if(own.entries.begin(), own.entries.end(),
                             [&](const TomlValue::Entry& e) { return e.key == entry.key; });
    if (mine == own.entries.end()) {
      whole.entries.push_back(std::move(entry));
      continue;
    }
    if (is_tables(mine->value) && is_tables(entry.value)) {
      std::move(mine->value.items.begin(), mine->value.items.end(), std::back_inserter(entry.value.items));
      whole.entries.push_back(std::move(entry));
    } else if (mine->value.kind == Kind::Table && entry.value.kind == Kind::Table) {
      TomlValue both = over(std::move(mine->value), std::move(entry.value));
      whole.entries.push_back({entry.key, mine->place, std::move(both)});
    } else {
      whole.entries.push_back(std::move(*mine));
    }
    own.entries.erase(mine);
  }
  add_missing(whole, std::move(own));
  return whole;
}

class Includer {
 public:
  explicit Includer(const ReadFile& read) : read_(read) {}

  TomlValue complete(TomlValue root, const std::string& file) {
    const TomlValue::Entry* key = root.find("include");
    if (key == nullptr) return root;
    const TomlValue wanted = key->value;
    std::erase_if(root.entries, [](const TomlValue::Entry& e) { return e.key == "include"; });
    TomlValue parts;
    for (const TomlValue& path : wanted.kind == Kind::List ? wanted.items : std::vector<TomlValue>{wanted})
      parts = over(include(path, file), std::move(parts));
    return over(std::move(root), std::move(parts));
  }

 private:
  TomlValue include(const TomlValue& path, const std::string& from) {
    if (path.kind != Kind::Text || path.text.empty())
      refuse_at(from, path.place, path.described(), "needs the path of a scene file, in quotes");
    namespace fs = std::filesystem;
    const std::string file = (fs::path(from).parent_path() / path.text).lexically_normal().string();
    if (std::find(open_.begin(), open_.end(), file) != open_.end())
      refuse_at(from, path.place, "include = \"" + path.text + "\"",
                "needs a file that does not include this one");
    constexpr int most = 100;
    if (++count_ > most) refuse_at(from, path.place, "more than 100 files", "no scene needs that");
    std::string text;
    try {
      text = read_(file);
    } catch (const std::invalid_argument& error) {
      refuse_at(from, path.place, "include = \"" + path.text + "\"", error.what());
    }
    open_.push_back(file);
    TomlValue part = parse_toml(text, file);
    mark(part, std::make_shared<const std::string>(file));
    part = complete(std::move(part), file);
    open_.pop_back();
    return part;
  }

  const ReadFile& read_;
  std::vector<std::string> open_;  // the files around the one being read
  int count_ = 0;
};

// [[repeat]]

class Writer {
 public:
  Writer(TomlValue& root, const SceneSource& source) : root_(root), source_(source) {}

  void write_out(const TomlValue& repeat, const SceneSource& counters) {
    const SceneTable table(repeat, counters);
    const std::string& over = table.text("over");
    const bool fits =
        !over.empty() && std::isalpha(static_cast<unsigned char>(over[0])) != 0 &&
        over.find_first_not_of("abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_") ==
            std::string::npos;
    if (!fits || Expression::reserved(over))
      table.refuse("over", "over is \"" + over + "\"",
                   "needs a name of letters, digits and '_' that is no function, nor pi or t");
    if (counters.parameters.contains(over))
      table.refuse("over", "over is \"" + over + "\"",
                   "needs a name that no parameter has, nor a repeat around it");
    if (table.has("n") == (table.has("from") || table.has("to")))
      table.refuse("n", "a repeat", "needs n, or from and to");
    const bool n = table.has("n");
    const double from = n ? 0 : whole(table, "from"), to = n ? whole(table, "n") - 1 : whole(table, "to");
    for (double i = from; i <= to; ++i) {
      SceneSource inner = counters;
      inner.parameters[over] = i;
      for (const TomlValue::Entry& entry : repeat.entries) {
        if (entry.key == "over" || entry.key == "n" || entry.key == "from" || entry.key == "to") continue;
        if (!is_tables(entry.value))
          refuse_at(source_.file, entry.place, "the key '" + entry.key + "'",
                    "needs over, n, from, to, or tables to repeat, as [[repeat.body]]");
        for (const TomlValue& item : entry.value.items)
          if (entry.key == "repeat")
            write_out(item, inner);
          else
            add(entry, item, inner);
      }
    }
  }

 private:
  double whole(const SceneTable& table, const char* key) const {
    const double value = table.number(key, Dimension::None);
    if (value != std::floor(value) || std::abs(value) > SceneTable::many)
      table.refuse(key, std::string(key) + " = " + shortest(value),
                   "needs a whole number of 1,000,000 at most");
    return value;
  }

  void add(const TomlValue::Entry& kind, TomlValue item, const SceneSource& counters) {
    if (++count_ > SceneTable::many)
      refuse_at(source_.file, kind.place, "more than 1,000,000 tables", "needs fewer");
    put_numbers(item, counters);
    TomlValue& list = entry_of(root_, kind).value;
    list.kind = Kind::List;
    list.items.push_back(std::move(item));
  }

  void put_numbers(TomlValue& value, const SceneSource& counters) const {
    for (TomlValue& item : value.items) put_numbers(item, counters);
    for (TomlValue::Entry& entry : value.entries) put_numbers(entry.value, counters);
    if (value.kind != Kind::Text || value.text.find("${") == std::string::npos) return;
    std::string text;
    for (std::size_t begin = 0, at; begin <= value.text.size(); begin = at + 1) {
      const std::size_t open = std::min(value.text.find("${", begin), value.text.size());
      text += value.text.substr(begin, open - begin);
      if (open == value.text.size()) break;
      at = value.text.find('}', open);
      if (at == std::string::npos)
        refuse_at(source_.file, value.place, value.described(), "needs a } after ${");
      text += evaluated(value, value.text.substr(open + 2, at - open - 2), counters);
    }
    value.text = text;
    value.text_begin = value.place;
  }

  std::string evaluated(const TomlValue& value, const std::string& text, const SceneSource& counters) const {
    try {
      const double x = Expression(text, counters.parameters)();
      if (std::isfinite(x)) return shortest(x);
      refuse_at(source_.file, value.place, value.key + " has ${" + text + "} = " + shortest(x),
                "needs to be finite");
    } catch (const ExpressionError& error) {
      refuse_at(source_.file, value.place, value.key + " has ${" + text + "}", error.what());
    }
  }

  TomlValue& root_;
  const SceneSource& source_;
  std::size_t count_ = 0;
};

}  // namespace

TomlValue with_includes(TomlValue root, const std::string& file, const ReadFile& read) {
  return Includer(read).complete(std::move(root), file);
}

TomlValue with_repeats(TomlValue root, const SceneSource& source) {
  const TomlValue::Entry* key = root.find("repeat");
  if (key == nullptr) return root;
  const TomlValue repeats = key->value;
  if (!is_tables(repeats))
    refuse_at(source.file, repeats.place, repeats.described(),
              "needs tables, each under the line [[repeat]]");
  std::erase_if(root.entries, [](const TomlValue::Entry& e) { return e.key == "repeat"; });
  Writer writer(root, source);
  for (const TomlValue& repeat : repeats.items) writer.write_out(repeat, source);
  return root;
}

}  // namespace perp
