#include "io/toml_file.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <map>
#include <sstream>
#include <stdexcept>
#include <toml.hpp>

#include "perp/core/errors.hpp"

namespace perp {
namespace {

using Value = toml::basic_value<toml::discard_comments, std::map>;

/// Line and column of an offset, in a time that does not grow with the file.
class Lines {
 public:
  explicit Lines(std::string_view text) : text_(text) {
    for (std::size_t i = 0; i < text.size(); ++i)
      if (text[i] == '\n') begins_.push_back(i + 1);
  }
  Place at(std::size_t offset) const {
    const auto next = std::upper_bound(begins_.begin(), begins_.end(), offset);
    return {static_cast<std::size_t>(next - begins_.begin()), offset - *std::prev(next) + 1};
  }
  std::string_view text() const { return text_; }

 private:
  std::string_view text_;
  std::vector<std::size_t> begins_{0};
};

constexpr int deepest = 32;  // brackets within brackets, and dots in a key: the parser recurses over both

/// Refuses what a recursive parser should not be given: before it, one pass over the bytes.
class Inspection {
 public:
  Inspection(const Lines& lines, const std::string& file) : lines_(lines), text_(lines.text()), file_(file) {}

  void run() {
    if (text_.size() > longest_toml)
      refuse_at(file_, {}, std::to_string(text_.size()) + " bytes",
                "a scene file needs to have 100 MB at most");
    while (at_ < text_.size()) {
      const char c = text_[at_];
      if (c == '#') {
        while (at_ < text_.size() && text_[at_] != '\n') letter();
      } else if (c == '"' || c == '\'') {
        quoted(c);
      } else {
        nesting(c);
        letter();
      }
    }
  }

 private:
  /// Over one letter of UTF-8 that may stand in a TOML file.
  void letter() {
    const auto byte = [&](std::size_t i) {
      return static_cast<unsigned char>(at_ + i < text_.size() ? text_[at_ + i] : 0);
    };
    const unsigned char c = byte(0);
    const bool control = (c < 0x20 && c != '\t' && c != '\n' && c != '\r') || c == 0x7f;
    const std::size_t length = c < 0x80                ? 1
                               : c >= 0xf0 && c < 0xf5 ? 4
                               : c >= 0xe0 && c < 0xf0 ? 3
                               : c >= 0xc2 && c < 0xe0 ? 2
                                                       : 0;
    bool whole = length > 0 && !control;
    for (std::size_t i = 1; i < length; ++i) whole = whole && (byte(i) & 0xc0) == 0x80;
    if (!whole)
      refuse_at(file_, lines_.at(at_), "the byte " + std::to_string(c),
                "a scene file needs to be text in UTF-8");
    at_ += length;
  }

  void quoted(char quote) {
    const std::string three(3, quote);
    const bool lines = text_.substr(at_, 3) == three;
    at_ += lines ? 3 : 1;
    while (at_ < text_.size()) {
      if (lines ? text_.substr(at_, 3) == three : text_[at_] == quote) break;
      if (!lines && text_[at_] == '\n') return;  // not closed: the parser says so
      if (quote == '"' && text_[at_] == '\\' && at_ + 1 < text_.size()) letter();
      letter();
    }
    at_ += lines ? 3 : 1;
  }

  void nesting(char c) {
    if (c == '[' || c == '{') ++depth_;
    if (c == ']' || c == '}') depth_ = std::max(0, depth_ - 1);
    if (c == '.') ++dots_;
    if (std::string_view("=,[]{}\n").find(c) != std::string_view::npos) dots_ = 0;
    if (depth_ > deepest || dots_ > deepest)
      refuse_at(file_, lines_.at(at_), "tables or lists that nest deeper than 32", "no scene needs that");
  }

  const Lines& lines_;
  std::string_view text_;
  const std::string& file_;
  std::size_t at_ = 0;
  int depth_ = 0, dots_ = 0;
};

/// The parser's complaint as a place and a sentence. It is a picture of several lines,
///   [error] toml::function: sentence
///    --> file
///    3 | a line of the file
///      |   ^--- remark
/// sometimes with more than one line of the file, of which the last is where reading stopped.
[[noreturn]] void refuse_syntax(const std::string& file, const Lines& lines, const toml::exception& error) {
  std::istringstream picture(error.what());
  std::string sentence, remark, line;
  std::getline(picture, sentence);
  const std::size_t function = sentence.find("toml::"), colon = sentence.find(": ", function);
  sentence.erase(0, function == std::string::npos || colon == std::string::npos ? 0 : colon + 2);
  Place place{error.location().line(), error.location().column()};
  while (std::getline(picture, line)) {
    const std::size_t bar = line.find(" | "), digits = line.find_first_not_of(' ');
    if (bar == std::string::npos) continue;
    std::size_t number = 0;
    if (std::from_chars(line.data() + digits, line.data() + bar, number).ec == std::errc()) {
      place.line = number;
    } else if (const std::size_t marker = line.find_first_of("^~", bar); marker != std::string::npos) {
      place.column = marker - (bar + 3) + 1;
      const std::size_t words = line.find_first_not_of("^~- ", marker);
      remark = words == std::string::npos ? std::string() : ": " + line.substr(words);
    }
  }
  for (std::string* words : {&sentence, &remark})
    while (words->ends_with('.')) words->pop_back();
  const Place end = lines.at(lines.text().size());  // the parser reads one line break more
  refuse_at(file, place.line > end.line ? end : place, (sentence.empty() ? "this" : sentence) + remark,
            "needs to be TOML");
}

class Converter {
 public:
  Converter(const Lines& lines, const std::string& file) : lines_(lines), file_(file) {}

  TomlValue value(const Value& from, const std::string& key = {}) const {
    TomlValue to;
    to.key = key;
    to.place = lines_.at(offset(from));
    switch (from.type()) {
      case toml::value_t::integer:
      case toml::value_t::floating:
        to.kind = TomlValue::Kind::Number;
        to.number = number(from, to.place);
        break;
      case toml::value_t::string:
        to.kind = TomlValue::Kind::Text;
        to.text = from.as_string().str;
        to.text_begin = first_letter(from, to);
        break;
      case toml::value_t::boolean:
        to.kind = TomlValue::Kind::Boolean;
        break;
      case toml::value_t::array:
        to.kind = TomlValue::Kind::List;
        for (const Value& item : from.as_array()) to.items.push_back(value(item, key));
        break;
      case toml::value_t::table:
        for (const auto& [entry_key, entry] : from.as_table())
          to.entries.push_back({entry_key, key_place(entry), value(entry, entry_key)});
        std::stable_sort(to.entries.begin(), to.entries.end(), [](const auto& a, const auto& b) {
          return std::pair(a.place.line, a.place.column) < std::pair(b.place.line, b.place.column);
        });
        break;
      default:
        to.kind = TomlValue::Kind::Date;
    }
    return to;
  }

 private:
  static const toml::detail::region* region(const Value& value) {
    return dynamic_cast<const toml::detail::region*>(toml::detail::get_region(value));
  }

  std::size_t offset(const Value& value) const {
    const auto* where = region(value);
    if (where == nullptr) {  // a list of [[tables]] has the place of the first
      const bool list = value.is_array() && !value.as_array().empty();
      return list ? offset(value.as_array().front()) : 0;
    }
    return std::min(static_cast<std::size_t>(where->first() - where->begin()), lines_.text().size());
  }

  /// The parser reads numbers with the locale of the program, so they are read again here.
  double number(const Value& from, const Place& place) const {
    const auto* where = region(from);
    std::string text = where == nullptr ? std::string() : where->str();
    std::erase(text, '_');
    const bool other_base = text.size() > 1 && text[0] == '0' &&
                            std::isalpha(static_cast<unsigned char>(text[1])) && text[1] != 'e' &&
                            text[1] != 'E';
    if (other_base && from.is_integer()) return static_cast<double>(from.as_integer());
    const char* begin = text.data() + (text.starts_with('+') ? 1 : 0);
    double value = 0;
    const auto [end, error] = std::from_chars(begin, text.data() + text.size(), value);
    if (error != std::errc() || end != text.data() + text.size() || !std::isfinite(value))
      refuse_at(file_, place, text, "needs to be a finite number that double can hold");
    return value;
  }

  Place first_letter(const Value& from, const TomlValue& to) const {
    const auto* where = region(from);
    if (where == nullptr || where->str().size() != to.text.size() + 2) return to.place;
    return {to.place.line, to.place.column + 1};
  }

  /// Backwards from the value over "=" and the key; a table under a header has the place of the header.
  Place key_place(const Value& value) const {
    const std::string_view text = lines_.text();
    const std::size_t begin = offset(value);
    const auto blank = [](char c) { return c == ' ' || c == '\t'; };
    std::size_t at = begin;
    while (at > 0 && blank(text[at - 1])) --at;
    if (at == 0 || text[at - 1] != '=') return lines_.at(begin);
    --at;
    while (at > 0 && blank(text[at - 1])) --at;
    const auto in_key = [&](char c) {
      return !blank(c) && std::string_view("\n,{[").find(c) == std::string_view::npos;
    };
    while (at > 0 && in_key(text[at - 1])) --at;
    return lines_.at(at);
  }

  const Lines& lines_;
  const std::string& file_;
};

}  // namespace

void refuse_at(std::string_view file, const Place& place, std::string_view found, std::string_view allowed) {
  constexpr std::size_t readable = 200;  // what was found stays one line, and a short one
  std::string shown(found.substr(0, readable));
  for (char& c : shown)
    if (static_cast<unsigned char>(c) < 0x20) c = ' ';
  if (found.size() > readable) shown += "...";
  std::string message(place.file ? std::string_view(*place.file) : file);
  message.append(":").append(std::to_string(place.line)).append(":").append(std::to_string(place.column));
  throw std::invalid_argument(message.append(": ").append(shown).append(", ").append(allowed));
}

const TomlValue::Entry* TomlValue::find(std::string_view wanted) const {
  const auto it =
      std::find_if(entries.begin(), entries.end(), [&](const Entry& entry) { return entry.key == wanted; });
  return it == entries.end() ? nullptr : &*it;
}

std::string TomlValue::described() const {
  const std::string is = key.empty() ? std::string() : key + " is ";
  switch (kind) {
    case Kind::Number:
      return is + "the number " + shortest(number);
    case Kind::Text:
      return is + "the text \"" + text.substr(0, 40) + (text.size() > 40 ? "...\"" : "\"");
    case Kind::Boolean:
      return is + "true or false";
    case Kind::Date:
      return is + "a date or time";
    case Kind::List:
      return is + "a list of " + std::to_string(items.size());
    case Kind::Table:
      break;
  }
  return is + "a table";
}

TomlValue parse_toml(std::string_view text, const std::string& file) {
  if (text.starts_with("\xEF\xBB\xBF")) text.remove_prefix(3);
  const Lines lines(text);
  Inspection(lines, file).run();
  std::istringstream stream{std::string(text)};
  try {
    return Converter(lines, file).value(toml::parse<toml::discard_comments, std::map>(stream, file));
  } catch (const toml::exception& error) {
    refuse_syntax(file, lines, error);
  } catch (const std::invalid_argument&) {
    throw;
  } catch (const std::exception& error) {  // of numbers, dates and characters that are none
    refuse_at(file, {}, error.what(), "needs to be TOML");
  }
}

}  // namespace perp
