#include "perp/io/expression.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <numbers>

#include "io/names.hpp"
#include "perp/core/errors.hpp"

namespace perp {

using Slopes = std::array<double, 2>;

/// An operator or function f(a, b) and its slopes df/da, df/db, which may use f. Without a second argument b is zero.
struct Expression::Operation {
  std::string_view name;
  std::size_t arguments;
  double (*value)(double a, double b);
  Slopes (*slopes)(double a, double b, double f);
};

namespace {

constexpr std::size_t deepest = 64;  // values that wait on the stack; parentheses within parentheses

/// A value and its derivative.
struct Dual {
  double x = 0, d = 0;
};

bool letter(char c) { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '_'; }
bool digit(char c) { return c >= '0' && c <= '9'; }

}  // namespace

constexpr Expression::Operation Expression::operations[] = {
    {"+", 2, [](double a, double b) -> double { return a + b; },
     [](double, double, double) -> Slopes {
       return {1, 1};
     }},
    {"-", 2, [](double a, double b) -> double { return a - b; },
     [](double, double, double) -> Slopes {
       return {1, -1};
     }},
    {"*", 2, [](double a, double b) -> double { return a * b; },
     [](double a, double b, double) -> Slopes {
       return {b, a};
     }},
    {"/", 2, [](double a, double b) -> double { return a / b; },
     [](double, double b, double f) -> Slopes {
       return {1 / b, -f / b};
     }},
    {"^", 2, [](double a, double b) -> double { return std::pow(a, b); },
     [](double a, double b, double f) -> Slopes {
       return {b == 0 ? 0 : b * std::pow(a, b - 1), a > 0 ? f * std::log(a) : f == 0 ? 0 : not_set};
     }},
    {"-x", 1, [](double a, double) -> double { return -a; },
     [](double, double, double) -> Slopes {
       return {-1, 0};
     }},
    {"sin", 1, [](double a, double) -> double { return std::sin(a); },
     [](double a, double, double) -> Slopes {
       return {std::cos(a), 0};
     }},
    {"cos", 1, [](double a, double) -> double { return std::cos(a); },
     [](double a, double, double) -> Slopes {
       return {-std::sin(a), 0};
     }},
    {"tan", 1, [](double a, double) -> double { return std::tan(a); },
     [](double, double, double f) -> Slopes {
       return {1 + f * f, 0};
     }},
    {"asin", 1, [](double a, double) -> double { return std::asin(a); },
     [](double a, double, double) -> Slopes {
       return {1 / std::sqrt((1 - a) * (1 + a)), 0};
     }},
    {"acos", 1, [](double a, double) -> double { return std::acos(a); },
     [](double a, double, double) -> Slopes {
       return {-1 / std::sqrt((1 - a) * (1 + a)), 0};
     }},
    {"atan", 1, [](double a, double) -> double { return std::atan(a); },
     [](double a, double, double) -> Slopes {
       return {1 / (1 + a * a), 0};
     }},
    {"sinh", 1, [](double a, double) -> double { return std::sinh(a); },
     [](double a, double, double) -> Slopes {
       return {std::cosh(a), 0};
     }},
    {"cosh", 1, [](double a, double) -> double { return std::cosh(a); },
     [](double a, double, double) -> Slopes {
       return {std::sinh(a), 0};
     }},
    {"tanh", 1, [](double a, double) -> double { return std::tanh(a); },
     [](double, double, double f) -> Slopes {
       return {(1 - f) * (1 + f), 0};
     }},
    {"exp", 1, [](double a, double) -> double { return std::exp(a); },
     [](double, double, double f) -> Slopes {
       return {f, 0};
     }},
    {"log", 1, [](double a, double) -> double { return std::log(a); },
     [](double a, double, double) -> Slopes {
       return {1 / a, 0};
     }},
    {"sqrt", 1, [](double a, double) -> double { return std::sqrt(a); },
     [](double, double, double f) -> Slopes {
       return {0.5 / f, 0};
     }},
    {"abs", 1, [](double a, double) -> double { return std::abs(a); },
     [](double a, double, double) -> Slopes {
       return {a < 0 ? -1. : a > 0 ? 1. : 0., 0};
     }},
    {"step", 1, [](double a, double) -> double { return a < 0 ? 0 : 1; },
     [](double, double, double) -> Slopes {
       return {0, 0};
     }},
    {"atan2", 2, [](double a, double b) -> double { return std::atan2(a, b); },
     [](double a, double b, double) -> Slopes {
       return {b / (a * a + b * b), -a / (a * a + b * b)};
     }},
    {"hypot", 2, [](double a, double b) -> double { return std::hypot(a, b); },
     [](double a, double b, double f) -> Slopes {
       return {f > 0 ? a / f : 0, f > 0 ? b / f : 0};
     }},
    {"min", 2, [](double a, double b) -> double { return std::min(a, b); },
     [](double a, double b, double) -> Slopes {
       return {a <= b ? 1. : 0., a <= b ? 0. : 1.};
     }},
    {"max", 2, [](double a, double b) -> double { return std::max(a, b); },
     [](double a, double b, double) -> Slopes {
       return {a >= b ? 1. : 0., a >= b ? 0. : 1.};
     }},
};

const Expression::Operation* Expression::find(std::string_view name) {
  const auto it = std::find_if(std::begin(operations), std::end(operations),
                               [&](const Operation& operation) { return operation.name == name; });
  return it == std::end(operations) ? nullptr : it;
}

/// Recursive descent; every rule leaves the steps that compute it.
///   sum = product {(+|-) product},  product = signed {(*|/) signed},  signed = {+|-} power,
///   power = operand [^ signed],  operand = number | name | name(sum {, sum}) | (sum).
class ExpressionParser {
 public:
  ExpressionParser(Expression& target, std::string_view text, const SceneParameters& constants,
                   const std::vector<std::string>& variables)
      : target_(target), text_(text), constants_(constants), variables_(variables) {}

  void parse() {
    sum();
    if (at_ < text_.size()) fail(at_, found() + ", needs an operator: + - * / ^");
    target_.text_.append(text_.substr(copied_));
  }

 private:
  void sum() {
    if (++depth_ > deepest) fail(at_, "parentheses too deep within each other, needs 64 at most");
    product();
    while (peek() == '+' || peek() == '-') {
      const char sign = text_[at_++];
      product();
      apply(std::string_view(&sign, 1));
    }
    --depth_;
  }

  void product() {
    factor();
    while (peek() == '*' || peek() == '/') {
      const char sign = text_[at_++];
      factor();
      apply(std::string_view(&sign, 1));
    }
  }

  void factor() {
    bool negative = false;
    while (peek() == '+' || peek() == '-') negative ^= text_[at_++] == '-';
    power();
    if (negative) apply("-x");
  }

  void power() {
    operand();
    if (peek() != '^') return;
    ++at_;
    if (++depth_ > deepest) fail(at_, "powers too deep within each other, needs 64 at most");
    factor();
    --depth_;
    apply("^");
  }

  void operand() {
    const char c = peek();
    if (digit(c) || c == '.') {
      number();
    } else if (letter(c)) {
      name();
    } else {
      if (c != '(') fail(at_, found() + ", needs a number, a name or '('");
      ++at_;
      sum();
      expect(')');
    }
  }

  void number() {
    double value = 0;
    const auto [end, error] = std::from_chars(text_.data() + at_, text_.data() + text_.size(), value);
    if (error != std::errc()) fail(at_, "what double cannot hold, needs a number");
    at_ = static_cast<std::size_t>(end - text_.data());
    push({.number = value});
  }

  /// The longest variable that the text goes on with: their names may have dots and blanks, as BODY.x.
  std::size_t variable_ahead() const {
    std::size_t longest = variables_.size(), length = 0;
    for (std::size_t i = 0; i < variables_.size(); ++i) {
      const std::string& name = variables_[i];
      const std::size_t end = at_ + name.size();
      if (name.size() <= length || !text_.substr(at_).starts_with(name)) continue;
      if (end < text_.size() && (letter(text_[end]) || digit(text_[end]) || text_[end] == '.')) continue;
      longest = i;
      length = name.size();
    }
    return longest;
  }

  void name() {
    if (const std::size_t i = variable_ahead(); i < variables_.size()) {
      at_ += variables_[i].size();
      return push({.variable = static_cast<int>(i)});
    }
    const std::size_t begin = at_;
    while (at_ < text_.size() && (letter(text_[at_]) || digit(text_[at_]))) ++at_;
    const std::string word(text_.substr(begin, at_ - begin));
    if (word == "pi") return push({.number = std::numbers::pi});
    if (Expression::find(word) != nullptr) return call(word);
    const auto constant = constants_.find(word);
    if (constant == constants_.end()) unknown(word, begin);
    const std::string value = shortest(constant->second);
    target_.text_.append(text_.substr(copied_, begin - copied_));
    if (value.front() == '-')
      target_.text_.append("(").append(value).append(")");
    else
      target_.text_.append(value);
    copied_ = at_;
    push({.number = constant->second});
  }

  void call(const std::string& function) {
    if (peek() != '(') fail(at_, found() + ", needs '(' after the function " + function);
    for (std::size_t i = 0; i < Expression::find(function)->arguments; ++i) {
      expect(i == 0 ? '(' : ',');
      sum();
    }
    expect(')');
    apply(function);
  }

  [[noreturn]] void unknown(std::string word, std::size_t begin) {
    std::vector<std::string> known = variables_;
    const bool dots = std::any_of(known.begin(), known.end(), [](const std::string& name) {
      return name.find('.') != std::string::npos;
    });
    for (; dots && at_ < text_.size() && (letter(text_[at_]) || digit(text_[at_]) || text_[at_] == '.');
         ++at_)
      word += text_[at_];
    for (const auto& [constant, value] : constants_) known.push_back(constant);
    known.emplace_back("pi");
    for (const auto& operation : Expression::operations)
      if (Expression::reserved(operation.name)) known.emplace_back(operation.name);
    fail(begin, "the name '" + word + "', needs " + one_of(known, word));
  }

  void push(const Expression::Step& value) {
    if (++height_ > deepest) fail(at_, "too many values that wait for an operator, needs 64 at most");
    target_.steps_.push_back(value);
  }

  void apply(std::string_view name) {
    const Expression::Operation* operation = Expression::find(name);
    height_ -= operation->arguments - 1;
    target_.steps_.push_back({.operation = operation});
  }

  char peek() {
    while (at_ < text_.size() && (text_[at_] == ' ' || text_[at_] == '\t')) ++at_;
    return at_ < text_.size() ? text_[at_] : '\0';
  }

  void expect(char c) {
    if (peek() != c) fail(at_, found() + ", needs '" + c + "'");
    ++at_;
  }

  std::string found() const {
    if (at_ == text_.size()) return "the end of the expression";
    return std::string("'") + text_[at_] + "'";
  }

  [[noreturn]] static void fail(std::size_t at, const std::string& what) { throw ExpressionError(what, at); }

  Expression& target_;
  std::string_view text_;
  const SceneParameters& constants_;
  const std::vector<std::string>& variables_;
  std::size_t at_ = 0, copied_ = 0, depth_ = 0, height_ = 0;
};

Expression::Expression(std::string_view text, const SceneParameters& constants,
                       const std::vector<std::string>& variables) {
  ExpressionParser(*this, text, constants, variables).parse();
}

double Expression::operator()(std::span<const double> at) const {
  std::array<double, deepest> stack{};
  std::size_t top = 0;
  for (const Step& step : steps_) {
    if (step.operation == nullptr) {
      stack[top++] = step.variable < 0 ? step.number : at[static_cast<std::size_t>(step.variable)];
    } else {
      top -= step.operation->arguments - 1;
      stack[top - 1] = step.operation->value(stack[top - 1], stack[top % deepest]);
    }
  }
  return stack[0];
}

double Expression::derivative(std::span<const double> at, std::size_t i) const {
  std::array<Dual, deepest> stack{};
  std::size_t top = 0;
  for (const Step& step : steps_) {
    if (step.operation == nullptr) {
      const auto variable = static_cast<std::size_t>(step.variable);
      stack[top++] = step.variable < 0 ? Dual{step.number, 0} : Dual{at[variable], variable == i ? 1. : 0.};
    } else {
      top -= step.operation->arguments - 1;
      Dual& a = stack[top - 1];
      const Dual b = step.operation->arguments == 2 ? stack[top] : Dual{};
      const double f = step.operation->value(a.x, b.x);
      const auto [by_a, by_b] = step.operation->slopes(a.x, b.x, f);
      a = {f,
           (a.d == 0 ? 0 : by_a * a.d) + (b.d == 0 ? 0 : by_b * b.d)};  // a slope not needed may be infinite
    }
  }
  return stack[0].d;
}

bool Expression::constant() const {
  return std::all_of(steps_.begin(), steps_.end(), [](const Step& step) { return step.variable < 0; });
}

bool Expression::uses(std::size_t variable) const {
  return std::any_of(steps_.begin(), steps_.end(), [&](const Step& s) {
    return s.operation == nullptr && s.variable == static_cast<int>(variable);
  });
}

bool Expression::uses_only(std::size_t variable) const {
  return std::all_of(steps_.begin(), steps_.end(), [&](const Step& s) {
    return s.operation != nullptr || s.variable < 0 || s.variable == static_cast<int>(variable);
  });
}

bool Expression::linear(std::size_t variable) const {
  std::vector<int> degree;  // of what waits on the stack; 2: more than linear
  for (const Step& step : steps_) {
    if (step.operation == nullptr) {
      degree.push_back(step.variable == static_cast<int>(variable) ? 1 : 0);
      continue;
    }
    int a = degree.back(), b = 0;
    if (step.operation->arguments == 2) {
      b = a;
      degree.pop_back();
      a = degree.back();
    }
    const std::string_view name = step.operation->name;
    if (name == "+" || name == "-" || name == "-x")
      degree.back() = std::max(a, b);
    else if (name == "*")
      degree.back() = std::min(2, a + b);
    else if (name == "/")
      degree.back() = b == 0 ? a : 2;
    else
      degree.back() = a + b == 0 ? 0 : 2;
  }
  return degree.back() <= 1;
}

std::vector<Expression> Expression::switches() const {
  std::vector<Expression> found;
  std::vector<std::size_t> begin;  // of what waits on the stack, in steps_
  for (std::size_t k = 0; k < steps_.size(); ++k) {
    const Operation* operation = steps_[k].operation;
    if (operation == nullptr) {
      begin.push_back(k);
      continue;
    }
    if (operation->arguments == 2) begin.pop_back();
    const bool two = operation->name == "min" || operation->name == "max";
    if (!two && operation->name != "step" && operation->name != "abs") continue;
    Expression g;
    g.steps_.assign(steps_.begin() + static_cast<std::ptrdiff_t>(begin.back()),
                    steps_.begin() + static_cast<std::ptrdiff_t>(k));
    if (two) g.steps_.push_back({.operation = find("-")});
    found.push_back(std::move(g));
  }
  return found;
}

bool Expression::may_jump() const {
  const Operation* jumps = find("step");
  return std::any_of(steps_.begin(), steps_.end(), [&](const Step& step) { return step.operation == jumps; });
}

bool Expression::reserved(std::string_view name) {
  return name == "pi" || name == "t" || (find(name) != nullptr && letter(name.front()));
}

}  // namespace perp
