// Real functions written as text, with exact derivatives: what scene files say motions and forces with.
#pragma once

#include <cstddef>
#include <span>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include "perp/study/scene.hpp"

namespace perp {

/// What is wrong with an expression, and where.
class ExpressionError : public std::invalid_argument {
 public:
  ExpressionError(const std::string& what, std::size_t at) : std::invalid_argument(what), offset(at) {}
  std::size_t offset;  ///< in the text, from 0
};

/// f(x_1, ..., x_n), written with + - * / ^, parentheses, pi, the functions
///   sin cos tan asin acos atan sinh cosh tanh exp log sqrt abs step, of two arguments atan2 hypot min max,
/// named constants, whose values are taken when it is read, and named variables. ^ binds tightest and to the right: -2^2
/// is -4. step(x) is 0 where x < 0, else 1. Numbers and results are those of double arithmetic in the order written,
/// whatever the locale.
///
/// Derivatives are carried along with the values (forward mode), so they are exact to rounding; libraries of expressions
/// that Debian has give difference quotients at best.
class Expression {
 public:
  /// Throws ExpressionError if `text` is not an expression in these names.
  Expression(std::string_view text, const SceneParameters& constants,
             const std::vector<std::string>& variables = {});

  /// `at` has an entry for each variable.
  [[nodiscard]] double operator()(std::span<const double> at = {}) const;
  /// df/dx_i.
  [[nodiscard]] double derivative(std::span<const double> at, std::size_t i) const;

  /// The text with the constants' values in place of their names.
  const std::string& text() const { return text_; }
  bool constant() const;  ///< no variable in it
  bool uses(std::size_t variable) const;
  bool uses_only(std::size_t variable) const;  ///< and no other
  bool linear(std::size_t variable) const;     ///< c + d x_i by how it is written
  /// What its jumps, and those of its derivatives, lie at the zeros of: arguments of step and abs, a - b of min(a, b) and max(a, b).
  [[nodiscard]] std::vector<Expression> switches() const;
  bool may_jump() const;  ///< has a step: it is then no position of a body

  /// Whether an expression gives `name` a meaning of its own, so that no parameter may have it.
  static bool reserved(std::string_view name);

 private:
  Expression() = default;
  friend class ExpressionParser;
  struct Operation;
  static const Operation operations[];
  static const Operation* find(std::string_view name);

  /// One step on a stack: puts a number or a variable on top, or applies an operation to what is there.
  struct Step {
    const Operation* operation = nullptr;
    double number = 0;
    int variable = -1;
  };

  std::string text_;
  std::vector<Step> steps_;  ///< in the order of evaluation, on a stack
};

}  // namespace perp
