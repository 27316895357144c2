#include <cmath>

#include "scene_at.hpp"

namespace perp {

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

TEST_CASE("B11: Newton's law at both contacts at once throws the three balls apart", "[scenes]") {
  const At at("three-balls", 0.5);
  CHECK(at.v("first").x() == near(-1.0 / 3));
  CHECK(at.v("second").x() == near(2.0 / 3));
  CHECK(at.v("third").x() == near(2.0 / 3));
  CHECK(at.p("third").x() == near(1 + 1.0 / 3));
  CHECK(At("three-balls", 0.5, {{"e", 0}}).v("first").x() == near(1.0 / 3));
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

TEST_CASE("C20: the cube slides v^2/(2 mu g) far", "[scenes]") {
  CHECK(At("sliding-cube", 1.5).p("cube").x() == near(3.669724770642202));
  CHECK(At("sliding-cube", 1.5).v("cube").x() == 0);
}

TEST_CASE("the balls of a pile start apart from each other and from the walls", "[scenes]") {
  for (const double count : {1., 7., 50., 130.}) {
    const Scene s = scene("pile", {{"count", count}});
    CHECK(s.model.bodies().size() == static_cast<std::size_t>(count) + 1);
    int contacts = 0;
    s.model.each_contact([&](int number) {
      const ContactView contact = s.model.contact(number);
      ContactPoint point;
      contact.gap(s.model.pose(s.start, contact.a), s.model.pose(s.start, contact.b), 0, {&point, 1});
      CAPTURE(count, s.model.contact_name(number));
      REQUIRE(point.gap > 0);
      ++contacts;
    });
    CHECK(contacts == 5 * count + count * (count - 1) / 2);
  }
}

}  // namespace perp
