#include "perp/io/expression.hpp"

#include <array>
#include <catch2/catch.hpp>
#include <clocale>
#include <cmath>
#include <random>

using namespace perp;

namespace {

double value(const std::string& text) { return Expression(text, {})(); }

std::size_t offset_of_mistake(const std::string& text) {
  try {
    Expression(text, {{"radius", 2}}, {"t"});
  } catch (const ExpressionError& error) {
    return error.offset;
  }
  return std::string::npos;
}

}  // namespace

TEST_CASE("an expression follows the precedence of arithmetic", "[expression]") {
  CHECK(value("1 + 2*3") == 7);
  CHECK(value("(1 + 2)*3") == 9);
  CHECK(value("8/4/2") == 1);
  CHECK(value("5 - 3 - 1") == 1);
  CHECK(value("-2^2") == -4);
  CHECK(value("2^-1") == 0.5);
  CHECK(value("2^3^2") == 512);
  CHECK(value("2*-3") == -6);
  CHECK(value("--3") == 3);
  CHECK(value(" 1e-3 * 1.5E2") == 1e-3 * 1.5e2);
  CHECK(value("pi") == M_PI);
}

TEST_CASE("functions are those of the standard library", "[expression]") {
  CHECK(value("sin(0.3)") == std::sin(0.3));
  CHECK(value("atan2(-1, -2)") == std::atan2(-1, -2));
  CHECK(value("hypot(3, 4)") == 5);
  CHECK(value("min(2, max(1, 3))") == 2);
  CHECK(value("abs(-2) + sqrt(9) + log(exp(1))") == 6);
  CHECK(value("step(-1e-9)") == 0);
  CHECK(value("step(0)") == 1);
}

TEST_CASE("constants are taken at their values and variables at each call", "[expression]") {
  const Expression f("A*sin(omega*t) + x", {{"A", 0.1}, {"omega", 12}}, {"t", "x"});
  CHECK(f(std::array{0.3, 2.0}) == 0.1 * std::sin(12 * 0.3) + 2);
  CHECK(f(std::array{0.0, -1.0}) == -1);
  CHECK_FALSE(f.constant());
  CHECK(Expression("A*omega", {{"A", 0.1}, {"omega", 12}}, {"t"}).constant());
}

TEST_CASE("the text of an expression has numbers for its constants and means the same", "[expression]") {
  const Expression f("A*sin(omega*t)^2 - A", {{"A", -0.1}, {"omega", 1e-5}}, {"t"});
  CHECK(f.text() == "(-0.1)*sin(1e-05*t)^2 - (-0.1)");
  const Expression again(f.text(), {}, {"t"});
  CHECK(again.text() == f.text());
  for (const double t : {-1.0, 0.0, 0.7}) CHECK(again(std::array{t}) == f(std::array{t}));
}

TEST_CASE("derivatives agree with central differences to the error of these", "[expression]") {
  const std::string text = GENERATE(
      "sin(x)*cos(y)", "tan(x*y/8)", "asin(x/4) + acos(y/4)", "atan(x) + atan2(y, x)", "sinh(x)*cosh(y)",
      "tanh(x - y)", "exp(-x*y)", "log(x + 3)*sqrt(y)", "abs(x - 3) + abs(y)", "hypot(x, y)",
      "min(x, y)*max(x, y)", "x^y", "x^3 - 2^y", "x/y - y/x", "-x*-y", "(x + y)^2/(1 + x^2)", "(-x)^2");
  const Expression f(text, {}, {"x", "y"});
  std::mt19937 random(1);
  std::uniform_real_distribution<double> uniform(0.3, 2.5);
  for (int sample = 0; sample < 20; ++sample) {
    const std::array at{uniform(random), uniform(random)};
    for (std::size_t i = 0; i < 2; ++i) {
      const double h = 1e-5;
      std::array before = at, after = at;
      before[i] -= h;
      after[i] += h;
      const double difference = (f(after) - f(before)) / (2 * h);
      CAPTURE(text, at[0], at[1], i);
      CHECK(f.derivative(at, i) == Approx(difference).epsilon(1e-7).margin(1e-7));
    }
  }
}

TEST_CASE("a slope that is infinite does not spoil a derivative that does not need it", "[expression]") {
  const Expression f("sqrt(x) + y^2", {}, {"x", "y"});
  CHECK(f.derivative(std::array{0.0, 3.0}, 1) == 6);
  CHECK(Expression("x^0", {}, {"x"}).derivative(std::array{0.0}, 0) == 0);
}

TEST_CASE("a mistake in an expression is found where it stands", "[expression]") {
  CHECK(offset_of_mistake("2*radius + t") == std::string::npos);
  CHECK(offset_of_mistake("2*radus") == 2);
  CHECK(offset_of_mistake("sin t") == 4);
  CHECK(offset_of_mistake("(1 + 2") == 6);
  CHECK(offset_of_mistake("1 + ") == 4);
  CHECK(offset_of_mistake("1 2") == 2);
  CHECK(offset_of_mistake("atan2(1)") == 7);
  CHECK(offset_of_mistake("sin(1, 2)") == 5);
  CHECK(offset_of_mistake("2 $ 3") == 2);
  CHECK(offset_of_mistake("") == 0);
  CHECK(offset_of_mistake("1e999") == 0);
  CHECK_THROWS_WITH(Expression("2*radus", {{"radius", 2}}),
                    "the name 'radus', needs one of radius, pi, sin, cos, tan, asin, acos, atan, sinh, cosh, "
                    "tanh, exp, log, "
                    "sqrt, abs, step, atan2, hypot, min, max (did you mean radius?)");
}

TEST_CASE("an expression that nests without end is refused, not followed", "[expression]") {
  CHECK_THROWS_AS(Expression(std::string(100000, '(') + "1", {}), ExpressionError);
  CHECK_THROWS_AS(Expression("2" + std::string(100000, '^'), {}), ExpressionError);
  std::string powers = "2", open = "1";
  for (int i = 0; i < 100000; ++i) powers += "^2";
  for (int i = 0; i < 100; ++i) open += "+(2*(3";
  CHECK_THROWS_AS(Expression(powers, {}), ExpressionError);
  CHECK_THROWS_AS(Expression(open, {}), ExpressionError);
  CHECK(Expression(std::string(100001, '-') + "1", {})() == -1);
}

TEST_CASE("an expression with a step may jump and no other does", "[expression]") {
  CHECK(Expression("2*step(t - 1)", {}, {"t"}).may_jump());
  CHECK_FALSE(Expression("2*abs(t - 1)", {}, {"t"}).may_jump());
  CHECK(Expression::reserved("step"));
  CHECK(Expression::reserved("pi"));
  CHECK(Expression::reserved("t"));
  CHECK_FALSE(Expression::reserved("mu"));
}
