#include <cmath>

#include "scene_at.hpp"

namespace perp {

TEST_CASE("B8: the pendulum with dry friction turns ten times and sticks", "[scenes]") {
  const double turns[][2] = {{1.09175148829423, -1.07222698530919},  {2.16402878121614, 0.950513443535228},
                             {3.22031877399045, -0.833620298574127}, {4.26345249925988, 0.720591601633223},
                             {5.29579763390132, -0.610663969850226}, {6.31938732151865, 0.503208580553414},
                             {7.33601038924429, -0.397692194067467}, {8.34727727028209, 0.293649769445069},
                             {9.35467026893212, -0.190664344158262}, {10.3595836662653, 0.0883515165336378}};
  for (const auto& [t, phi] : turns) {
    const At turn("friction-pendulum", t);
    CHECK(turn.angle("arm") == near(phi, 2e-14));
    CHECK(std::abs(turn.w("arm").z()) < 1e-13);
    CHECK(turn.p("arm").x() == near(0.5 * std::sin(phi)));
    CHECK(turn.p("arm").y() == near(-0.5 * std::cos(phi)));
  }
  CHECK(At("friction-pendulum", 12).angle("arm") == near(0.0136532035133473, 1e-15));
  CHECK(At("friction-pendulum", 12).w("arm").z() == 0);
  CHECK(At("friction-pendulum", 11.363).w("arm").z() < 0);
  CHECK(At("friction-pendulum", 11.364).w("arm").z() == 0);
  CHECK(At("friction-pendulum", 3, {{"angle", 0.05}}).angle("arm") == near(0.05));
}

TEST_CASE("B9: the block on a spring sticks after six half cycles", "[scenes]") {
  const double half = std::acos(-1.0) / 5;
  for (int i = 1; i <= 6; ++i) {
    const double side = i % 2 == 0 ? 1 : -1;
    CHECK(At("spring-block", i * half).p("block").x() == near(side * (0.5 - 0.08 * i)));
  }
  CHECK(At("spring-block", 3.769911184307752).p("block").x() == near(0.02));
  CHECK(At("spring-block", 5).v("block").x() == 0);
  CHECK(At("spring-block", half / 2).v("block").x() == near(-(0.5 - 0.04) * 5));
  CHECK(At("spring-block", half / 2, {{"x0", -0.5}}).v("block").x() == near((0.5 - 0.04) * 5));
  CHECK(At("spring-block", 9, {{"x0", 0.07}}).p("block").x() ==
        near(0.01));  // stops before the spring's rest
}

TEST_CASE("B12: the free body flips about its middle axis", "[scenes]") {
  const auto check = [](double t, const Vector3& w, double digits) {
    const At at("dzhanibekov", t);
    const Vector3 body = at.q("body").conjugate() * at.w("body");
    for (int i = 0; i < 3; ++i) CHECK(body[i] == near(w[i], digits));
  };
  check(1, {-0.0648826095396103, 4.99958900780647, 0.038339505390087}, 1e-14);
  check(2, {-1.16125005963604, 4.8632908918751, 0.670497750680964}, 1e-14);
  check(5, {-0.0113256939009495, -4.99999717286497, 0.0104605822390216}, 1e-14);
  check(10.05185827631494, {0.01, 5, 0.01}, 1e-13);  // the period
  const At begin("dzhanibekov", 0), end("dzhanibekov", 7);
  const Vector3 change = end.s.model.momentum(end.x).angular - begin.s.model.momentum(begin.x).angular;
  CHECK(change.norm() < 1e-13);
}

TEST_CASE("B14: the double pendulum is where independent integrations find it", "[scenes]") {
  const auto check = [](const At& at, double a, double b, double wa, double wb, double digits) {
    CHECK(at.angle("upper") == near(a, digits));
    CHECK(at.angle("lower") == near(b, digits));
    CHECK(at.w("upper").z() == near(wa, digits));
    CHECK(at.w("lower").z() == near(wb, digits));
  };
  check(At("double-pendulum", 1), -0.62508769980639, -1.034585085680012, -3.922279572888, -1.303099248696,
        1e-12);
  check(At("double-pendulum", 3), 1.785795522077417, 1.1181074612052, 0.327980619514457, -0.50445510394531,
        3e-13);
  check(At("double-pendulum", 10, {{"angle1", 0.5}, {"angle2", -0.3}}), -0.1075423326223, 0.3879371483853,
        1.8000472748246, -1.7342369971033, 2e-13);
}

TEST_CASE("C12: a free body keeps its energy and its momentum, however fast it spins", "[scenes]") {
  const At begin("free-spin", 0), end("free-spin", 1);
  CHECK(end.s.model.energy(end.x) == near(begin.s.model.energy(begin.x), 1e-14));
  const Vector3 L = begin.s.model.momentum(begin.x).angular;
  CHECK((end.s.model.momentum(end.x).angular - L).norm() < 3e-12 * L.norm());
  CHECK(begin.w("body").norm() == near(1e4));
}

TEST_CASE("B13: the heavy top nods and precesses", "[scenes]") {
  const auto axis = [](const At& at) -> Vector3 { return at.p("top") / 0.1; };
  const double period = 0.326850017499159;
  const At lowest("heavy-top", period / 2), back("heavy-top", period);
  CHECK(std::acos(axis(lowest).z()) == near(0.718801090169476));
  CHECK(std::abs(lowest.v("top").z()) < 1e-14);
  CHECK(std::acos(axis(back).z()) == near(std::acos(0.5) / 2));
  CHECK(back.v("top").norm() < 1e-13);
  CHECK(std::atan2(axis(back).y(), axis(back).x()) == near(1.20265470935738));
}

TEST_CASE("B15: the slider-crank's friction stops it after ten radians", "[scenes]") {
  const double pi = std::acos(-1.0);
  CHECK(At("slider-crank", 0.486172086669506).angle("crank") == near(2 * pi));
  const At stopped("slider-crank", 1.18674812085397);
  CHECK(stopped.angle("crank") == near(10, 1e-12));
  CHECK(stopped.w("crank").z() == 0);
  CHECK(At("slider-crank", 1.1867).w("crank").z() > 0);
  CHECK(At("slider-crank", 5).angle("crank") == near(10, 1e-14));
  CHECK(At("slider-crank", 5, {{"guide", 0.5}}).angle("crank") == near(7.99930823872758));
  double before = 0, after = 0.2;  // of a quarter turn
  for (int i = 0; i < 60; ++i) {
    const double middle = (before + after) / 2;
    (At("slider-crank", middle).angle("crank") < pi / 2 ? before : after) = middle;
  }
  CHECK(At("slider-crank", after).w("crank").z() == near(12.5963234024985));
}

TEST_CASE("C4: the four-bar keeps its energy through full turns of the crank", "[scenes]") {
  const Scene s = scene("four-bar");
  const auto [first, last] = std::pair{s.exact(0), s.exact(10)};
  CHECK(s.model.energy(last) == near(s.model.energy(first), 1e-13));
  CHECK(s.model.joints().size() == 4);
}

}  // namespace perp
