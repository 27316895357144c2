#include "perp/solve/text_reader.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <utility>

#include "core/files.hpp"
#include "perp/core/errors.hpp"

namespace perp {
namespace {

bool is_blank(char c) { return c == ' ' || c == '\t' || c == '\n' || c == '\r' || c == '\v' || c == '\f'; }

// The whole token as a number, or false; a leading '+', which from_chars refuses, is allowed.
template <class Number>
bool parse(std::string_view token, Number& value) {
  if (token.size() > 1 && token[0] == '+' && token[1] != '-') token.remove_prefix(1);
  const auto [end, error] = std::from_chars(token.data(), token.data() + token.size(), value);
  return error == std::errc() && end == token.data() + token.size();
}

std::string message(std::string_view file, int line, int column, std::string_view found,
                    std::string_view allowed) {
  std::string text(file);
  text.append(":").append(std::to_string(line)).append(":").append(std::to_string(column));
  return text.append(": ").append(found).append(", ").append(allowed);
}

}  // namespace

ParseError::ParseError(std::string_view file, int line, int column, std::string_view found,
                       std::string_view allowed)
    : std::invalid_argument(message(file, line, column, found, allowed)), line_(line), column_(column) {}

TextReader::TextReader(std::string text, std::string name) : text_(std::move(text)), name_(std::move(name)) {}

TextReader TextReader::from_file(const std::string& path) {
  return TextReader(read_file(path, "a readable file is needed"), path);
}

void TextReader::skip_blanks() {
  while (at_ < text_.size() && is_blank(text_[at_])) ++at_;
}

bool TextReader::at_end() {
  skip_blanks();
  return at_ == text_.size();
}

std::string_view TextReader::word(std::string_view what) {
  skip_blanks();
  token_ = at_;
  while (at_ < text_.size() && !is_blank(text_[at_])) ++at_;
  token_size_ = at_ - token_;
  if (token_size_ == 0) reject(what, "more text is needed");
  return std::string_view(text_).substr(token_, token_size_);
}

int TextReader::integer(std::string_view what, int least, int most) {
  const std::string_view token = word(what);
  int value = 0;
  if (!parse(token, value) || value < least || value > most) {
    std::string need = "an integer";
    if (least != INT_MIN) need.append(" >= ").append(std::to_string(least));
    if (most != INT_MAX) need.append(least != INT_MIN ? " and <= " : " <= ").append(std::to_string(most));
    reject(what, need.append(" is needed"));
  }
  return value;
}

double TextReader::real(std::string_view what) {
  const std::string_view token = word(what);
  double value = 0;
  if (!parse(token, value) || !std::isfinite(value)) reject(what, "a finite number is needed");
  return value;
}

Vector TextReader::reals(int n, std::string_view what) {
  if (static_cast<size_t>(n) > bytes_left()) {
    skip_blanks();
    token_ = at_;
    fail("only " + std::to_string(bytes_left()) + " bytes are left for " + std::string(what),
         std::to_string(n) + " numbers are needed");
  }
  Vector x(n);
  for (double& value : x) value = real(what);
  return x;
}

void TextReader::expect(std::string_view literal) {
  if (word(literal) != literal) reject("the word", "\"" + std::string(literal) + "\" is needed");
}

bool TextReader::next_is(std::string_view literal) {
  skip_blanks();
  const size_t end = at_ + literal.size();
  if (text_.compare(at_, literal.size(), literal) != 0 || (end < text_.size() && !is_blank(text_[end])))
    return false;
  at_ = end;
  return true;
}

std::string_view TextReader::rest_of_line() {
  token_ = at_;
  const size_t end = std::min(text_.find('\n', at_), text_.size());
  token_size_ = end - token_;
  at_ = std::min(end + 1, text_.size());
  return std::string_view(text_).substr(token_, token_size_);
}

void TextReader::reject(std::string_view what, std::string_view allowed) const {
  const std::string found = token_size_ == 0
                                ? "missing at the end"
                                : "\"" + text_.substr(token_, std::min<size_t>(token_size_, 40)) + "\"";
  fail(std::string(what) + " is " + found, allowed);
}

void TextReader::fail(std::string_view found, std::string_view allowed) const {
  const auto here = text_.begin() + static_cast<std::ptrdiff_t>(token_);
  const auto line = 1 + std::count(text_.begin(), here, '\n');
  const size_t line_begin = token_ == 0 ? 0 : text_.rfind('\n', token_ - 1) + 1;  // npos + 1 is 0
  throw ParseError(name_, static_cast<int>(line), static_cast<int>(token_ - line_begin + 1), found, allowed);
}

}  // namespace perp
