// Random scenes under every method, judged from their files alone; and the judge itself, by lies.
#include <catch2/catch.hpp>

#include <unistd.h>
#include <algorithm>
#include <filesystem>
#include <functional>
#include <stdexcept>

#include "known_wrong.hpp"
#include "tally.hpp"

using namespace checker;

namespace {

std::string folder() {
  const auto path = std::filesystem::temp_directory_path() / ("perp-checker-" + std::to_string(getpid()));
  std::filesystem::create_directories(path);
  return path.string();
}

TrialOptions options() {
  TrialOptions options;
  options.folder = folder();
#ifdef __SANITIZE_ADDRESS__
  options.patience = 20;
#endif
  return options;
}

const std::vector<std::string> methods = {"lcp", "ncp", "ncp2", "event"};
constexpr std::uint64_t per_shard = 100, shards = 10;
constexpr std::size_t most_known_wrong = 12;  // may only fall

const KnownWrong& known_wrong() {
  static const KnownWrong known = read_known_wrong(PERP_TEST_FOLDER "/known_wrong.txt");
  return known;
}

/// Nothing of a shard of a hundred seeds is wrong but what is known to be, and that is.
void check_shard(std::uint64_t shard) {
  std::size_t judged = 0, unjudged = 0;
  for (std::uint64_t seed = per_shard * shard + 1; seed <= per_shard * (shard + 1); ++seed) {
    const RandomScene random = random_scene(seed);
    for (const std::string& method : methods) {
      const Trial trial = try_scene(random, method, options());
      const auto known = known_wrong().runs.find({seed, method});
      CAPTURE(seed, method, trial.reason);
      CHECK(trial.ending != Ending::Mistake);
      unjudged += trial.ending == Ending::Unjudged ? 1 : 0;  // boxes that come to hang over
      judged += trial.judgement.steps;
      if (known != known_wrong().runs.end()) {
        if (trial.reason.starts_with("takes longer")) continue;  // nothing was judged
        INFO("known as '" << known->second << "', and right now: take it off known_wrong.txt");
        CHECK_FALSE(trial.judgement.faults.empty());
        continue;
      }
      for (const Fault& f : trial.judgement.faults)
        UNSCOPED_INFO("step " << f.step + 1 << ", " << f.part << " " << f.of << ": " << f.value << " > "
                              << f.allowed);
      CHECK(trial.judgement.faults.empty());
    }
  }
  CHECK(judged > 3 * per_shard * methods.size());  // several steps a run
  CHECK(unjudged <= 2);
  std::filesystem::remove_all(folder());
}

const char* const slider = R"(
[[body]]
name = "ball"
kind = "spatial"
mass = 2
inertia = { shape = "solid_sphere", radius = 0.5 }
position = [0, 0, 0.5]
velocity = [1, 0.5, 0]
angular_velocity = [0, 1, 2]

[[body]]
name = "link"
kind = "spatial"
mass = 1
inertia = { shape = "box", size = [0.2, 0.3, 0.4] }
position = [5, 0, 1]
angular_velocity = [0, 1.5, 0]
velocity = [0, 0, -1.5]

[[joint]]
name = "hinge"
kind = "revolute"
a = "ground"
b = "link"
point = [4, 0.3, 1]
axis = [0, 1, 0]

[[contact]]
name = "floor"
a = "ground"
b = "ball"
gap = { kind = "sphere_on_plane", radius = 0.5 }
mu = 0.3
)";

/// A change of the second step, and the part of the judgement that has to see it.
struct Lie {
  std::string what, part;
  std::function<void(Run&)> tell;
};

constexpr double part = 1e-6;  // of its scale

ContactRow& row(Run& r, int half = 0) {
  for (ContactRow& c : r.contacts[1])
    if (c.half == half) return c;
  throw std::logic_error("the run has no such row");
}

/// One number changed.
std::vector<Lie> lies(const std::string& method) {
  const auto ball = [](Run& r) -> BodyState& { return r.states[2].bodies[1]; };
  const auto link = [](Run& r) -> BodyState& { return r.states[2].bodies[2]; };
  const auto joint = [](Run& r) -> JointReport& { return r.joints[1][0]; };
  return {
      {"velocity", "momentum", [=](Run& r) { ball(r).v.y() += part; }},
      {"velocity along the normal", "momentum", [=](Run& r) { ball(r).v.z() += part; }},
      {"angular velocity", "momentum", [=](Run& r) { ball(r).w.x() += part; }},
      {"position", method == "ncp2" ? "momentum" : "kinematic", [=](Run& r) { ball(r).at.p.x() += part; }},
      {"height", "normal", [=](Run& r) { ball(r).at.p.z() -= part; }},
      {"position of the link", "joints", [=](Run& r) { link(r).at.p.x() += part; }},
      {"orientation", "joints",
       [=](Run& r) {
         link(r).at.q = Quaterniond(Eigen::AngleAxisd(part, Vector3d::UnitX())) * link(r).at.q;
       }},
      {"normal impulse", "momentum",
       [=](Run& r) {
         for (ContactRow& c : r.contacts[1]) c.p.z() *= 1 + part, c.p_n *= 1 + part, c.f.z() *= 1 + 20 * part;
       }},
      {"friction impulse", "momentum",
       [=](Run& r) {
         for (ContactRow& c : r.contacts[1]) c.p.x() += part * c.p.z(), c.f.x() += 20 * part * c.f.z();
       }},
      {"impulse without its normal part", "normal", [=](Run& r) { row(r).p_n *= 1 + part; }},
      {"normal", "normal", [=](Run& r) { row(r).normal.x() += part; }},
      {"gap", "normal", [=](Run& r) { row(r).gap += part; }},
      {"joint force", "momentum", [=](Run& r) { joint(r).force.x() += part * joint(r).force.norm(); }},
      {"joint moment", "momentum", [=](Run& r) { joint(r).moment.x() += part * joint(r).force.norm(); }},
      {"coordinate", "coordinate", [=](Run& r) { joint(r).coordinate += part; }},
      {"energy", "says-energy", [=](Run& r) { r.steps[1].of["energy"] *= 1 + part; }},
      {"work of friction", "says-energies", [=](Run& r) { r.steps[1].of["energy_friction"] += part * 10; }},
      {"work of impacts", "says-energies", [=](Run& r) { r.steps[1].of["energy_impact"] += part * 10; }},
      {"work of loads", "says-energies", [=](Run& r) { r.steps[1].of["energy_load"] += part * 10; }},
      {"work of motors", "says-energies", [=](Run& r) { r.steps[1].of["energy_motor"] += part * 10; }},
      {"work of surfaces", "says-energies", [=](Run& r) { r.steps[1].of["energy_surface"] += part * 10; }},
      {"what is left", "says-energies", [=](Run& r) { r.steps[1].of["energy_left"] += part * 10; }},
      {"gap_min", "says-gap_min", [=](Run& r) { r.steps[1].of["gap_min"] += part; }},
      {"not a number", "not-a-number", [=](Run& r) { ball(r).v.x() = not_given; }},
      {"impulse that is none", "not-a-number", [=](Run& r) { row(r).p.x() = not_given; }},
      {"energy that is none", "not-a-number", [=](Run& r) { r.steps[1].of["energy"] = not_given; }}};
}

/// Another impulse at the contact, with the motion that goes with it, so that momentum and places hold and one law alone does not.
void push(Run& r, const std::string& method, const Vector3d& impulse) {
  BodyState &x = r.states[1].bodies[1], &y = r.states[2].bodies[1];
  const double m = 2, J = 0.4 * m * 0.25, h = 0.01, moved = method == "ncp2" ? 0.5 : 1;
  const Vector3d v = impulse / m, w = (-0.5 * Vector3d::UnitZ()).cross(impulse) / J;
  const Vector3d turned = 2 * std::acos(std::min(1.0, std::abs((y.at.q * x.at.q.conjugate()).w()))) *
                          (y.at.q * x.at.q.conjugate()).vec().normalized();
  const Vector3d turn = turned + moved * h * w;
  y.v += v;
  y.w += w;
  y.at.p += moved * h * v;
  y.at.q = Quaterniond(Eigen::AngleAxisd(turn.norm(), turn.normalized())) * x.at.q;
  for (ContactRow& c : r.contacts[1]) {
    const double share = c.half == 0 ? 1 : 0.5;
    c.p += share * impulse;
    c.p_n += share * impulse.z();
    c.gap += moved * h * v.z();
  }
}

/// Lies that only a law of contacts sees.
std::vector<Lie> consistent_lies(const std::string& method) {
  const double p = 2 * 9.81 * 0.01;  // weight's impulse [N s]
  std::vector<Lie> all = {
      {"a push that lifts", "normal", [=](Run& r) { push(r, method, 10 * part * p * Vector3d::UnitZ()); }},
      {"a push that lets sink", "normal",
       [=](Run& r) { push(r, method, -10 * part * p * Vector3d::UnitZ()); }},
      {"friction across the slip", method == "lcp" ? "cone" : "friction",
       [=](Run& r) { push(r, method, 100 * part * p * row(r).p.cross(Vector3d::UnitZ()).normalized()); }},
      {"less friction", "friction",
       [=](Run& r) {
         const Vector3d f(row(r).p.x(), row(r).p.y(), 0);
         push(r, method, -10 * part * f);
       }},
      {"more friction", "cone", [=](Run& r) {
         const Vector3d f(row(r).p.x(), row(r).p.y(), 0);
         push(r, method, 10 * part * f);
       }}};
  if (method == "ncp2")
    all.push_back({"more of an impulse in its first half", "momentum", [=](Run& r) {
                     row(r, 1).p *= 1 + part, row(r, 1).p_n *= 1 + part;
                     row(r, 2).p = row(r).p - row(r, 1).p, row(r, 2).p_n = row(r).p_n - row(r, 1).p_n;
                   }});
  return all;
}

/// Of `event`, whose impulses of joints are means over a row, and whose rows tie no place along a surface and no spin.
bool untied(const Lie& lie) {
  return lie.what.starts_with("joint") || lie.what == "angular velocity" || lie.what == "position" ||
         lie.what == "work of loads" || lie.what == "impulse without its normal part";
}

}  // namespace

TEST_CASE("The checker finds every number that is changed by a millionth of its scale", "[checker]") {
  const std::string method = GENERATE("lcp", "ncp", "ncp2", "event");
  const TrialOptions options = ::options();
  REQUIRE(run_scene(slider, method, 0.01, 0.05, options).empty());
  const Scene scene = read_scene(options.folder + "/scene.toml");
  const Run truth = read_run(scene, options.folder + "/out");
  CAPTURE(method);
  const Judgement right = judge(scene, truth, method);
  for (const Fault& f : right.faults)
    UNSCOPED_INFO(f.part << " " << f.of << ": " << f.value << " > " << f.allowed);
  REQUIRE(right.faults.empty());
  REQUIRE(truth.steps.size() >= 3);
  std::vector<Lie> all = lies(method);
  if (method == "event")
    std::erase_if(all, untied);
  else
    for (const Lie& lie : consistent_lies(method)) all.push_back(lie);
  CHECK(all.size() >= (method == "event" ? 20 : 30));
  for (const Lie& lie : all) {
    Run run = truth;
    lie.tell(run);
    const Judgement judgement = judge(scene, run, method);
    CAPTURE(lie.what, lie.part);
    std::string seen;
    for (const Fault& f : judgement.faults)
      if (f.step == 1) seen += f.part + " " + f.of + "; ";
    CAPTURE(seen);
    CHECK_FALSE(seen.empty());
    // of `event` accelerations, energies and speeds see what momentum sees in steps
    if (method != "event") CHECK(seen.find(lie.part) != std::string::npos);
  }
  std::filesystem::remove_all(options.folder);
}

TEST_CASE("A scene's text reads back to the same text", "[checker]") {
  const std::string file = folder() + "/scene.toml";
  for (std::uint64_t seed = 1; seed <= 200; ++seed) {
    const std::string text = text_of(random_scene(seed).scene);
    std::FILE* out = std::fopen(file.c_str(), "w");
    std::fputs(text.c_str(), out);
    std::fclose(out);
    CAPTURE(seed);
    CHECK(text_of(read_scene(file)) == text);
  }
  std::filesystem::remove_all(folder());
}

TEST_CASE("A failure is shrunk to a scene that still fails and has less", "[checker]") {
  const RandomScene random = random_scene(4);
  const auto fails = [](const RandomScene& r) { return r.scene.joints.size() >= 2; };
  const RandomScene least = shrink(random, fails);
  CHECK(least.scene.joints.size() == 2);
  CHECK(least.scene.contacts.empty());
  CHECK(least.steps == 1);
}

TEST_CASE("What is known to be wrong is of the shards, has a reason, and grows no more", "[checker]") {
  const KnownWrong& known = known_wrong();
  for (const auto& [run, reason] : known.runs) {
    CAPTURE(run.first, run.second, reason);
    CHECK(run.first >= 1);
    CHECK(run.first <= per_shard * shards);
    CHECK(std::count(methods.begin(), methods.end(), run.second) == 1);
    CHECK(known.reasons.at(reason).size() > 40);
  }
  for (const auto& [word, reason] : known.reasons) {
    CAPTURE(word);
    CHECK(std::any_of(known.runs.begin(), known.runs.end(),
                      [&](const auto& run) { return run.second == word; }));
  }
  CHECK(known.runs.size() == most_known_wrong);
}

#define SHARD(n)                                                                                          \
  TEST_CASE("No step of a hundred random scenes is worse than it says: shard " #n, "[checker][random]") { \
    check_shard(n);                                                                                       \
  }
SHARD(0)
SHARD(1)
SHARD(2)
SHARD(3)
SHARD(4)
SHARD(5)
SHARD(6)
SHARD(7)
SHARD(8)
SHARD(9)
