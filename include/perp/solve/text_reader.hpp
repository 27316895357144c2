// Numbers and words out of a text, with the place of each: what a reader of problem files is made of.
#pragma once

#include <climits>
#include <stdexcept>
#include <string>
#include <string_view>

#include "perp/core/types.hpp"

namespace perp {

/// A text that is not what its reader allows. what() reads "FILE:LINE:COLUMN: FOUND, ALLOWED"; lines and columns
/// count from 1, columns in bytes.
class ParseError : public std::invalid_argument {
 public:
  ParseError(std::string_view file, int line, int column, std::string_view found, std::string_view allowed);
  int line() const { return line_; }
  int column() const { return column_; }

 private:
  int line_, column_;
};

/// Reads tokens separated by blanks and line ends, front to back. Numbers are read by std::from_chars, the same
/// under every locale. Every function throws ParseError at the token that is not what was asked for; `what`
/// names the quantity in that message ("mu of contact 3").
class TextReader {
 public:
  explicit TextReader(std::string text, std::string name = "text");
  /// Reads the file at `path`; throws std::invalid_argument if it cannot be read.
  [[nodiscard]] static TextReader from_file(const std::string& path);

  std::string_view word(std::string_view what);                                 ///< the next token
  int integer(std::string_view what, int least = INT_MIN, int most = INT_MAX);  ///< least <= i <= most
  double real(std::string_view what);                                           ///< finite
  Vector reals(int n, std::string_view what);                                   ///< (n)
  void expect(std::string_view literal);                                        ///< exactly this token
  bool next_is(std::string_view literal);  ///< takes the next token if it is exactly this one
  std::string_view rest_of_line();  ///< what stands before the next line end, which is passed; may be empty

  bool at_end();  ///< nothing but blanks is left
  size_t bytes_left() const { return text_.size() - at_; }
  const std::string& name() const { return name_; }

  /// Throws ParseError at the last token: "FILE:LINE:COLUMN: `what` is TOKEN, `allowed`".
  [[noreturn]] void reject(std::string_view what, std::string_view allowed) const;

 private:
  void skip_blanks();
  [[noreturn]] void fail(std::string_view found, std::string_view allowed) const;

  std::string text_, name_;
  size_t at_ = 0;     // first byte not read
  size_t token_ = 0;  // where the last token begins
  size_t token_size_ = 0;
};

}  // namespace perp
