#include <cmath>
#include <cstdlib>
#include <stdexcept>

#include "mechanics.hpp"

namespace checker {
namespace {

class Parser {
 public:
  Parser(const std::string& text, const std::map<std::string, double>& names, const std::string& by)
      : at_(text.c_str()), names_(names), by_(by) {}
  Dual all() {
    const Dual x = sum();
    if (next() != 0) fail();
    return x;
  }

 private:
  [[noreturn]] void fail() const {
    throw std::runtime_error(std::string("the checker cannot read the expression at ") + at_);
  }
  char next() {
    while (*at_ == ' ') ++at_;
    return *at_;
  }
  bool eat(char c) {
    if (next() != c) return false;
    ++at_;
    return true;
  }
  Dual sum() {
    Dual x = product();
    for (;;) {
      const bool plus = eat('+');
      if (!plus && !eat('-')) return x;
      const Dual y = product();
      x = plus ? Dual{x.value + y.value, x.slope + y.slope} : Dual{x.value - y.value, x.slope - y.slope};
    }
  }
  Dual product() {
    Dual x = factor();
    for (;;) {
      const bool times = eat('*');
      if (!times && !eat('/')) return x;
      const Dual y = factor();
      x = times ? Dual{x.value * y.value, x.slope * y.value + x.value * y.slope}
                : Dual{x.value / y.value, (x.slope - x.value / y.value * y.slope) / y.value};
    }
  }
  Dual factor() {
    if (eat('-')) {
      const Dual x = factor();
      return {-x.value, -x.slope};
    }
    if (eat('(')) {
      const Dual x = sum();
      if (!eat(')')) fail();
      return x;
    }
    if (std::isalpha(static_cast<unsigned char>(next())) != 0) return name();
    char* end = nullptr;
    const double value = std::strtod(at_, &end);
    if (end == at_) fail();
    at_ = end;
    return {value, 0};
  }
  Dual name() {
    std::string word;
    while (std::isalnum(static_cast<unsigned char>(*at_)) != 0) word += *at_++;
    if (word == "sin" || word == "cos") {
      const Dual x = factor();
      if (word == "sin") return {std::sin(x.value), std::cos(x.value) * x.slope};
      return {std::cos(x.value), -std::sin(x.value) * x.slope};
    }
    const auto known = names_.find(word);
    if (known == names_.end()) fail();
    return {known->second, word == by_ ? 1.0 : 0.0};
  }

  const char* at_;
  const std::map<std::string, double>& names_;
  const std::string& by_;
};

}  // namespace

Dual evaluate(const std::string& text, const std::map<std::string, double>& names, const std::string& by) {
  return Parser(text, names, by).all();
}

}  // namespace checker
