#include <catch2/catch.hpp>
#include <cmath>

#include "perp/study/scene.hpp"

namespace perp {
namespace {

/// A scene, and a body of it by name, at exact(t).
struct At {
  Scene s;
  State x;
  At(std::string_view name, double t, const SceneParameters& set = {}) : s(scene(name, set)), x(s.exact(t)) {}
  Vector3 p(const char* body) const { return s.model.position(x, s.model.find_body(body)); }
  Vector3 v(const char* body) const { return s.model.velocity(x, s.model.find_body(body)); }
  Vector3 w(const char* body) const { return s.model.angular_velocity(x, s.model.find_body(body)); }
  Quaternion q(const char* body) const { return s.model.pose(x, s.model.find_body(body)).q; }
  double angle(const char* body) const { return s.model.angle(x, s.model.find_body(body)); }
};

/// Numbers from a computation of their own, with as many digits as are known.
auto near(double value, double digits = 1e-14) {
  return Catch::Detail::Approx(value).epsilon(digits).margin(digits);
}

}  // namespace

TEST_CASE("every scene begins as its exact motion does, at the time zero", "[scenes]") {
  for (const std::string& name : scene_names()) {
    CAPTURE(name);
    const Scene s = scene(name);
    CHECK(s.name == name);
    CHECK_FALSE(s.id.empty());
    CHECK_FALSE(s.what.empty());
    CHECK(s.t_end > 0);
    REQUIRE_NOTHROW(s.model.check("start", s.start));
    CHECK(s.start.t == 0);
    if (!s.exact) continue;
    const State x = s.exact(0);
    REQUIRE_NOTHROW(s.model.check("exact", x));
    CHECK(x.t == 0);
    CHECK((x.q - s.start.q).lpNorm<Eigen::Infinity>() < 1e-15);
    CHECK((x.nu - s.start.nu).lpNorm<Eigen::Infinity>() < 1e-15);
  }
}

TEST_CASE("an exact motion does not depend on which times were asked for before", "[scenes]") {
  for (const std::string& name : scene_names()) {
    if (name == "free-spin") continue;  // too many nodes for a quick test
    const Scene once = scene(name), often = scene(name);
    if (!once.exact) continue;
    CAPTURE(name);
    for (int i = 0; i < 10; ++i) static_cast<void>(often.exact(0.13 * i * once.t_end));
    REQUIRE(once.exact(once.t_end).q.allFinite());
    CHECK(once.exact(once.t_end).q == often.exact(once.t_end).q);
    CHECK(once.exact(once.t_end).nu == often.exact(once.t_end).nu);
  }
}

TEST_CASE("a scene refuses a name, a parameter or a value that it does not have, naming it", "[scenes]") {
  using Catch::Matchers::Contains;
  CHECK_THROWS_WITH(scene("seed-spere"), Contains("seed-spere") && Contains("seed-sphere"));
  CHECK_THROWS_WITH(scene("seed-sphere", {{"nu", 1}}), Contains("nu") && Contains("mu, v0"));
  CHECK_THROWS_WITH(scene("seed-sphere", {{"mu", -0.1}}), Contains("mu is -0.1") && Contains(">= 0"));
  CHECK_THROWS_WITH(scene("seed-sphere", {{"mu", not_set}}), Contains("mu is nan"));
  CHECK_THROWS_WITH(scene("bead-in-ring", {{"radius", 0}}), Contains("radius is 0") && Contains("> 0"));
  CHECK_THROWS_WITH(scene("stack", {{"count", 2.5}}), Contains("count is 2.5") && Contains("whole"));
  CHECK_THROWS_WITH(scene("stack", {{"count", 0}}), Contains("count is 0") && Contains(">= 1"));
  CHECK_THROWS_AS(scene("seed-sphere").exact(-1), std::invalid_argument);
  CHECK(scene("seed-sphere", {{"mu", 0.4}}).parameters.front().value == 0.4);
}

TEST_CASE("B1: the seed's sphere slides, then rolls at 5/7 of its speed", "[scenes]") {
  const double switches = 0.291247997670016019;
  CHECK(At("seed-sphere", switches).p("ball").x() == near(0.499282281720027461));
  CHECK(At("seed-sphere", switches / 2).v("ball").x() == near(2 - 0.2 * 9.81 * switches / 2));
  const At end("seed-sphere", 0.6);
  CHECK(end.p("ball").x() == near(0.94035657076286172));
  CHECK(end.p("ball").z() == 1);
  CHECK(end.v("ball").x() == near(10.0 / 7));
  CHECK(end.w("ball").y() == near(10.0 / 7));
  CHECK(2 * std::atan2(end.q("ball").y(), end.q("ball").w()) == near(0.649108573092845701));
  CHECK(end.s.model.energy(end.s.start) - end.s.model.energy(end.x) == near(2 * 2.0 / 7));
}

TEST_CASE("B2: the oblique sphere slides along a parabola and then rolls straight, under any heading",
          "[scenes]") {
  const At turn("oblique-sphere", 0.651250321100856181), end("oblique-sphere", 2);
  CHECK(turn.p("ball").x() == near(1.39553640235897753));
  CHECK(turn.p("ball").y() == near(0.372143040629060675));
  CHECK(end.p("ball").x() == near(3.12964313237216244));
  CHECK(end.p("ball").y() == near(0.56482156618608122));
  CHECK(end.v("ball").x() == near(9.0 / 7));
  CHECK(end.v("ball").y() == near(1.0 / 7));
  CHECK(end.w("ball").z() == near(5));
  const Quaternion half_pi(Eigen::AngleAxisd(std::acos(0.0), Vector3::UnitZ()));
  const At turned("oblique-sphere", 2, {{"heading", std::acos(0.0)}});
  CHECK((turned.v("ball") - half_pi * end.v("ball")).norm() < 1e-14);
  CHECK((turned.w("ball") - half_pi * end.w("ball")).norm() < 1e-13);
}

TEST_CASE("B3: the block slides down, and thrown uphill stops and comes back", "[scenes]") {
  CHECK(At("incline-block", 1).p("block").x() == near(0.328572697218664219));
  CHECK(At("incline-block", 1).v("block").x() == near(0.657145394437328438));
  const At stop("incline-block", 0.21851106416401444, {{"v0", -2}}), back("incline-block", 1, {{"v0", -2}});
  CHECK(stop.p("block").x() == near(-0.21851106416401444));
  CHECK(std::abs(stop.v("block").x()) < 1e-14);
  CHECK(back.v("block").x() == near(0.657145394437328438 * (1 - 0.21851106416401444)));
  // held where mu >= tan(theta), from either side
  CHECK(At("incline-block", 1, {{"v0", -2}, {"mu", 0.6}}).v("block").x() == 0);
  CHECK(At("incline-block", 2, {{"v0", 2}, {"mu", 0.8}}).v("block").x() == 0);
  CHECK(At("incline-block", 5, {{"mu", 0.6}}).p("block").x() == 0);
}

TEST_CASE("B3b: across a slope the block's velocity turns downhill", "[scenes]") {
  const At half("cross-incline", 0.4), one("cross-incline", 0.4, {{"k", 1}}),
      more("cross-incline", 0.4, {{"k", 1.5}}), stopped("cross-incline", 0.5, {{"k", 1.5}});
  CHECK(half.p("block").x() == near(0.619599950012687137));
  CHECK(half.p("block").y() == near(0.329704340194999844));
  CHECK(half.v("block").x() == near(1.16694358167522645));
  CHECK(half.v("block").y() == near(1.51524216936201028));
  CHECK(std::atan2(half.v("block").x(), half.v("block").y()) == near(0.656264521385715167));
  CHECK(one.p("block").x() == near(0.449972437078063249));
  CHECK(one.p("block").y() == near(0.252430981950438333));
  CHECK(one.v("block").x() == near(0.451863387636479429));
  CHECK(one.v("block").y() == near(0.948954869728421182));
  CHECK(more.p("block").x() == near(0.305341758801412698));
  CHECK(more.p("block").y() == near(0.153329881405739901));
  CHECK(std::atan2(more.v("block").x(), more.v("block").y()) == near(0.095760719215417859));
  CHECK(stopped.p("block").x() == near(0.30581039755351682));
  CHECK(stopped.p("block").y() == near(0.16309887869520897));
  CHECK(stopped.v("block").norm() == 0);
}

TEST_CASE("B5a: the plate throws the particle off and catches it without a bounce", "[scenes]") {
  const double off = 0.0624557343869608896, on = 0.351693536744083536, again = 0.586054509985259763;
  const At leaves("shaker", off);
  CHECK(leaves.p("particle").z() == near(0.068125));
  CHECK(leaves.v("particle").z() == near(0.878461012225357671));
  const double flight = 0.3 - off;
  CHECK(At("shaker", 0.3).p("particle").z() ==
        near(0.068125 + 0.878461012225357671 * flight - 4.905 * flight * flight));
  const auto plate = [](double t) { return 0.1 * std::sin(12 * t); };
  const auto plate_speed = [](double t) { return 1.2 * std::cos(12 * t); };
  CHECK(At("shaker", on - 1e-12).v("particle").z() - plate_speed(on) == near(-1.39202391975993796, 1e-10));
  CHECK(At("shaker", on + 1e-12).v("particle").z() == near(plate_speed(on + 1e-12)));
  CHECK(At("shaker", again - 1e-3).p("particle").z() == plate(again - 1e-3));
  CHECK(At("shaker", again + 1e-2).p("particle").z() > plate(again + 1e-2));
  const double period = 4 * std::acos(0.0) / 6;  // 2 pi / 12, twice: the second flight repeats the first
  CHECK(At("shaker", 0.2 + period).p("particle").z() == near(At("shaker", 0.2).p("particle").z(), 1e-13));
}

TEST_CASE("B5c: the sphere on a turntable rolls in a circle", "[scenes]") {
  CHECK(At("turntable", 1).p("ball").x() == near(0.2721976123476663));
  CHECK(At("turntable", 1).p("ball").y() == near(0.09464598733779552));
  CHECK(At("turntable", 5).p("ball").x() == near(-0.04296783521384824));
  CHECK(At("turntable", 5).p("ball").y() == near(0.04911014491501246));
  CHECK(At("turntable", 0).w("ball").x() == near(5));
  CHECK((At("turntable", 3).p("ball") - Vector3(0.125, 0, 0.1)).norm() == near(0.175));
  CHECK(scene("turntable", {{"mu", 0.00583}}).exact);
  CHECK_FALSE(scene("turntable", {{"mu", 0.00582}}).exact);
}

TEST_CASE("B6: rollers swing in a cylinder with the period that their inertia gives", "[scenes]") {
  // theta from the roller's place; full period: back at the start, at rest
  const auto theta = [](const At& at) { return std::atan2(at.p("roller").x(), -at.p("roller").y()); };
  const auto check = [&](double lambda, double period, double theta_1, double mu_min) {
    CAPTURE(lambda);
    CHECK(theta(At("roller-in-cylinder", 1, {{"lambda", lambda}})) == near(theta_1));
    const At back("roller-in-cylinder", period, {{"lambda", lambda}});
    CHECK(theta(back) == near(std::acos(0.5)));
    CHECK(std::abs(back.w("roller").z()) < 1e-13);
    CHECK(scene("roller-in-cylinder", {{"lambda", lambda}, {"mu", mu_min + 1e-10}}).exact);
    CHECK_FALSE(scene("roller-in-cylinder", {{"lambda", lambda}, {"mu", mu_min - 1e-10}}).exact);
  };
  check(0.5, 2.358356037063757, -0.9348356190919447, 0.57735026919);
  check(0.4, 2.278388388982747, -0.9742445146007995, 0.49487165931);
  check(1, 2.723194985687479, -0.7127842490219592, 0.86602540378);
}

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

TEST_CASE("B17: the bead on a circular wall slows down as 1/(1 + mu v0 t/R)", "[scenes]") {
  const At at("bead-in-ring", 1);
  CHECK(at.v("bead").norm() == near(1.25));
  CHECK(std::atan2(at.p("bead").y(), at.p("bead").x()) == near(1.56667876415245));
  CHECK(at.p("bead").norm() == near(1));
  CHECK(At("bead-in-ring", 1, {{"mu", 0}}).v("bead").norm() == near(2));
}

TEST_CASE("B4: the ball bounces to the Zeno time and lies still after it", "[scenes]") {
  const auto check = [](double e, double z, double speed, double tenth, double zeno) {
    CAPTURE(e);
    const SceneParameters set{{"e", e}};
    CHECK(At("bouncing-ball", 1, set).p("ball").z() == near(z));
    CHECK(std::abs(At("bouncing-ball", 1, set).v("ball").z()) == near(speed));
    CHECK(At("bouncing-ball", tenth - 1e-6, set).v("ball").z() < 0);
    CHECK(At("bouncing-ball", tenth + 1e-6, set).v("ball").z() > 0);
    CHECK(At("bouncing-ball", zeno * (1 - 1e-12), set).p("ball").z() < 1e-12);
    CHECK(At("bouncing-ball", zeno + 1e-12, set).p("ball").z() == 0);
    CHECK(At("bouncing-ball", 10 * zeno, set).v("ball").z() == 0);
  };
  check(0.5, 0.06125556565754539, 0.1562555656575454, 1.352807158734592, 1.354570922957193);
  check(0.8, 0.4680044525260363, 1.836995547473964, 3.578892951020438, 4.063712768871578);
  check(0.9, 0.7109491443330383, 1.394050855666962, 5.430218002585346, 8.578949178728887);
}

TEST_CASE("B7: the ball on a sphere rolls, slips and leaves it", "[scenes]") {
  const auto theta = [](const At& at) { return std::atan2(at.p("ball").x(), at.p("ball").y()); };
  const auto distance = [](const At& at) { return at.p("ball").norm(); };
  const double slips = 1.16953241866, leaves = 1.21841190252;
  const auto slip = [&](double t) {  // of the ball's lowest point
    const At at("ball-on-sphere", t);
    return at.v("ball").norm() + 0.2 * at.w("ball").z();
  };
  CHECK(theta(At("ball-on-sphere", slips)) == near(0.83337733018, 1e-10));
  CHECK(std::abs(slip(slips - 1e-4)) < 1e-14);
  CHECK(slip(slips + 1e-4) > 1e-10);
  const At end("ball-on-sphere", leaves);
  CHECK(theta(end) == near(0.93424499307, 1e-10));
  CHECK(end.v("ball").norm() == near(1.2 * 2.20441157300, 1e-10));
  CHECK(end.w("ball").z() == near(-12.3246954408, 1e-10));
  CHECK(distance(At("ball-on-sphere", leaves - 1e-3)) == near(1.2));
  CHECK(distance(At("ball-on-sphere", leaves + 0.1)) > 1.201);
  // without friction as a point mass, whose time scales with the root of the length
  const At smooth("ball-on-sphere", 0.9071101110462694 * std::sqrt(1.2), {{"mu", 0}});
  CHECK(theta(smooth) == near(0.8455282018568607));
  CHECK(smooth.v("ball").norm() == near(2.550946342226408 * std::sqrt(1.2)));
  const At rough("ball-on-sphere", 1.22392262888018, {{"mu", 1e9}});
  CHECK(theta(rough) == near(0.9455505541592282, 1e-8));
}

TEST_CASE("B11: Newton's law at both contacts at once throws the three balls apart", "[scenes]") {
  const At at("three-balls", 0.5);
  CHECK(at.v("first").x() == near(-1.0 / 3));
  CHECK(at.v("second").x() == near(2.0 / 3));
  CHECK(at.v("third").x() == near(2.0 / 3));
  CHECK(at.p("third").x() == near(1 + 1.0 / 3));
  CHECK(At("three-balls", 0.5, {{"e", 0}}).v("first").x() == near(1.0 / 3));
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

TEST_CASE("B16: the ellipse rocks with the period and rate of its quadrature", "[scenes]") {
  CHECK(At("rolling-ellipse", 0.3).angle("ellipse") == near(0.3790900963453028));
  CHECK(At("rolling-ellipse", 0.5).angle("ellipse") == near(-0.06481332802093094));
  const double period = 1.901062981579163;
  CHECK(At("rolling-ellipse", period).angle("ellipse") == near(0.6, 1e-13));
  CHECK(At("rolling-ellipse", period / 2).angle("ellipse") == near(-0.6, 1e-13));
  CHECK(At("rolling-ellipse", period / 4).w("ellipse").z() == near(-2.637036573664679));
  CHECK(At("rolling-ellipse", period).p("ellipse").x() == near(0, 1e-13));
  CHECK_FALSE(scene("rolling-ellipse", {{"mu", 0.1}}).exact);
  CHECK(std::isnan(At("rolling-ellipse", 1.9, {{"mu", 0.3}, {"angle", 1.5}}).angle("ellipse")));
}

TEST_CASE("B23: the rattleback turns back one way and not the other", "[scenes]") {
  const auto upright_rate = [](double t, double spin) {
    const At now("rattleback", t, {{"spin", spin}});
    CHECK(now.s.model.energy(now.x) == near(0.1252398495052734, 1e-13));
    return now.w("stone").z();
  };
  CHECK(upright_rate(0.5, -5) == near(-4.49072160949, 1e-11));
  CHECK(upright_rate(1, -5) == near(-2.86575629421, 1e-11));
  CHECK(upright_rate(2, -5) == near(-1.31292559588, 1e-11));
  CHECK(std::abs(upright_rate(2.747880658295, -5)) < 1e-9);
  CHECK(upright_rate(5, -5) == near(4.475203749163, 1e-10));
  CHECK(upright_rate(0.5, 5) == near(5.34907801195, 1e-11));
  CHECK(upright_rate(5, 5) == near(4.16817238438, 1e-10));
}

TEST_CASE("C10: the coin's centre stays where it is, with the energy of steady rolling", "[scenes]") {
  const At now("euler-disk", 0.3);
  const double alpha = 0.1, a = 0.0375, rate = 102.3790035512293;
  CHECK(now.p("disc").z() == near(a * std::sin(alpha)));
  CHECK(now.w("disc").norm() == near(rate * std::sin(alpha), 1e-13));
  CHECK(now.s.model.energy(now.x) == near(1.5 * 9.81 * a * std::sin(alpha), 1e-13));
  const Vector3 axis = now.q("disc") * Vector3::UnitZ();
  CHECK(std::atan2(-axis.y(), axis.x()) ==
        near(std::remainder(std::acos(0.0) - rate * 0.3, 4 * std::acos(0.0)), 1e-11));
}

TEST_CASE("C6: the overhang of ten blocks is that of the harmonic series", "[scenes]") {
  CHECK(At("overhang", 0, {{"scale", 1}}).p("block-10").x() == near(1.464484126984127));
  CHECK_FALSE(scene("overhang", {{"scale", 1.001}}).exact);
}

TEST_CASE("C6: Jenga's planks touch all planks of the layer below", "[scenes]") {
  const Scene s = scene("tower", {{"count", 4}, {"planks", 3}});
  CHECK(s.model.bodies().size() == 1 + 12);
  CHECK(s.model.contacts().size() == 3 + 3 * 9);
  CHECK((s.model.pose(s.start, s.model.find_body("block-2-1")).p - Vector3(1.0 / 3, 0, 0.3)).norm() < 1e-15);
}

TEST_CASE("C7: a card stands if its floor is rough enough, C13: a V holds what its friction angle spans",
          "[scenes]") {
  CHECK(scene("card", {{"mu", 0.2888}}).exact);
  CHECK_FALSE(scene("card", {{"mu", 0.2885}}).exact);
  CHECK(scene("wedge", {{"mu", std::tan(0.3) - 1e-6}}).exact);
  CHECK_FALSE(scene("wedge", {{"mu", std::tan(0.3) + 1e-6}}).exact);
}

TEST_CASE("B19: each impact takes the same share of the rocking block's rate", "[scenes]") {
  const double impact = 0.4938032150788319;
  CHECK(At("rocking-block", impact - 1e-12).w("block").z() == near(-0.5650448210515408, 1e-11));
  CHECK(At("rocking-block", impact + 1e-12).w("block").z() == near(-0.5151879250764048, 1e-11));
  double amplitude = 0;
  for (int i = 0; i < 1000; ++i)
    amplitude = std::max(amplitude, -At("rocking-block", impact + 0.001 * i).angle("block"));
  CHECK(amplitude == near(0.09473679312081673, 1e-6));
  CHECK(At("rocking-block", 100).angle("block") == 0);
  CHECK(At("rocking-block", 100).p("block").y() == 1);
}

TEST_CASE("B21: the marble in a bowl is a spherical pendulum", "[scenes]") {
  const double period = 1.07769903228076;
  const At lowest("bowl", period / 2), back("bowl", period);
  CHECK(lowest.p("marble").z() == near(-0.962020354443054));
  CHECK(std::abs(lowest.v("marble").z()) < 1e-13);
  CHECK(back.p("marble").z() == near(-0.5));
  CHECK(std::abs(back.v("marble").z()) < 1e-13);
  const double azimuth = std::atan2(back.p("marble").y(), back.p("marble").x());
  CHECK(azimuth + 2 * std::acos(-1.0) == near(3.5351502888235));
  CHECK(back.p("marble").norm() == near(1));
}

TEST_CASE("C1: the rod that jams jumps to a motion about its tip", "[scenes]") {
  const At jump("painleve-rod", 1e-14);
  CHECK(jump.v("rod").x() == near(0.6, 1e-12));
  CHECK(jump.v("rod").y() == near(0.3, 1e-12));
  CHECK(jump.w("rod").z() == near(-0.670820393249937, 1e-12));
  const At sixty("painleve-rod", 1e-14, {{"theta", std::acos(0.5)}});
  CHECK(sixty.v("rod").x() == near(0.5625, 1e-12));
  CHECK(sixty.v("rod").y() == near(0.324759526419164, 1e-12));
  CHECK(sixty.w("rod").z() == near(-0.649519052838329, 1e-12));
  CHECK(scene("painleve-rod").exact(0).nu[0] == 1);
  CHECK_FALSE(scene("painleve-rod", {{"mu", 1.3}}).exact);  // below 4/3 no rod jams
  CHECK(std::isnan(scene("painleve-rod").exact(2).q[0]));   // after it has slipped
}

TEST_CASE("C4: the four-bar keeps its energy through full turns of the crank", "[scenes]") {
  const Scene s = scene("four-bar");
  const auto [first, last] = std::pair{s.exact(0), s.exact(10)};
  CHECK(s.model.energy(last) == near(s.model.energy(first), 1e-13));
  CHECK(s.model.joints().size() == 4);
}

TEST_CASE("C20: the cube slides v^2/(2 mu g) far", "[scenes]") {
  CHECK(At("sliding-cube", 1.5).p("cube").x() == near(3.669724770642202));
  CHECK(At("sliding-cube", 1.5).v("cube").x() == 0);
}

TEST_CASE("the balls of a pile start apart from each other and from the walls", "[scenes]") {
  for (const double count : {1., 7., 50., 130.}) {
    const Scene s = scene("pile", {{"count", count}});
    CHECK(s.model.bodies().size() == static_cast<std::size_t>(count) + 1);
    for (const Contact& contact : s.model.contacts()) {
      ContactPoint point;
      contact.gap(s.model.pose(s.start, contact.a), s.model.pose(s.start, contact.b), 0, {&point, 1});
      CAPTURE(count, contact.name);
      REQUIRE(point.gap > 0);
    }
  }
}

}  // namespace perp
