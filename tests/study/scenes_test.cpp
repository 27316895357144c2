#include <cmath>

#include "scene_at.hpp"

namespace perp {

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

TEST_CASE("B17: the bead on a circular wall slows down as 1/(1 + mu v0 t/R)", "[scenes]") {
  const At at("bead-in-ring", 1);
  CHECK(at.v("bead").norm() == near(1.25));
  CHECK(std::atan2(at.p("bead").y(), at.p("bead").x()) == near(1.56667876415245));
  CHECK(at.p("bead").norm() == near(1));
  CHECK(At("bead-in-ring", 1, {{"mu", 0}}).v("bead").norm() == near(2));
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

}  // namespace perp
