#include <array>
#include <cmath>

#include "perp/core/errors.hpp"
#include "perp/step/methods.hpp"
#include "study/scene_grip.hpp"
#include "study/scene_parts.hpp"

namespace perp {

void apply_method_settings(const Scene& scene, std::string_view method, MethodOptions& options) {
  const auto own = scene.method_settings.find(std::string(method));
  if (own == scene.method_settings.end()) return;
  for (const auto& [key, value] : own->second) options.set(method, key, value);
}

double Parameters::number(std::string_view name, double otherwise, std::string_view what, Allowed allowed) {
  const auto found = set_.find(name);
  const double value = found == set_.end() ? otherwise : found->second;
  const bool above = allowed.open ? value > allowed.low : value >= allowed.low;
  if (!std::isfinite(value) || !above || !(value <= allowed.high)) {
    std::string need = "needs to be finite";
    if (allowed.low > -infinity) need += (allowed.open ? " and > " : " and >= ") + shortest(allowed.low);
    if (allowed.high < infinity) need += " and <= " + shortest(allowed.high);
    refuse(scene_, name, value, need);
  }
  read_.push_back({std::string(name), value, std::string(what)});
  return value;
}

int Parameters::count(std::string_view name, int otherwise, std::string_view what, int low, int high) {
  const double value = number(name, otherwise, what, {double(low), double(high)});
  if (value != std::floor(value)) refuse(scene_, name, value, "needs to be a whole number");
  return static_cast<int>(value);
}

std::vector<SceneParameter> Parameters::all() const {
  for (const auto& [name, value] : set_) {
    std::string known;
    bool has = false;
    for (const SceneParameter& parameter : read_) {
      has = has || parameter.name == name;
      known += (known.empty() ? "" : ", ") + parameter.name;
    }
    if (!has)
      refuse(scene_, "parameter", name,
             known.empty() ? "it has no parameters" : "needs to be one of: " + known);
  }
  return read_;
}

void ParticleMotion::put(const Model& model, State& state, BodyId particle) const {
  model.set_position(state, particle, x.cast<double>());
  model.set_velocity(state, particle, v.cast<double>());
}

void PlanarMotion::put(const Model& model, State& state, BodyId body) const {
  const Real half = angle / 2;
  model.set_position(state, body, {double(x), double(y), 0});
  if (model.body(body).kind == BodyKind::Planar)
    state.q[model.body(body).q0 + 2] = double(angle);  // whole turns count
  else
    model.set_orientation(state, body, Quaternion(double(std::cos(half)), 0, 0, double(std::sin(half))));
  model.set_velocity(state, body, {double(vx), double(vy), 0}, {0, 0, double(omega)});
}

void stays(Scene& s) {
  s.exact = [start = s.start](double t) {
    State state = start;
    state.t = t;
    return state;
  };
}

PlanarMotion hanging(Real x, Real y, Real vx, Real vy, Real c, Real angle, Real omega) {
  const Real s = std::sin(angle), k = std::cos(angle);
  return {x + c * s, y - c * k, angle, vx + c * omega * k, vy + c * omega * s, omega};
}

namespace {

struct BuiltIn {
  const char* name;
  SceneMaker make;
};

constexpr BuiltIn built_in[] = {
    {"seed-sphere", seed_sphere},
    {"oblique-sphere", oblique_sphere},
    {"incline-block", incline_block},
    {"cross-incline", cross_incline},
    {"bouncing-ball", bouncing_ball},
    {"shaker", shaker},
    {"turntable", turntable},
    {"roller-in-cylinder", roller_in_cylinder},
    {"ball-on-sphere", ball_on_sphere},
    {"friction-pendulum", friction_pendulum},
    {"spring-block", spring_block},
    {"spun-sphere", spun_sphere},
    {"coasting-wheel", coasting_wheel},
    {"three-balls", three_balls},
    {"dzhanibekov", dzhanibekov},
    {"heavy-top", heavy_top},
    {"double-pendulum", double_pendulum},
    {"slider-crank", slider_crank},
    {"rolling-ellipse", rolling_ellipse},
    {"bead-in-ring", bead_in_ring},
    {"rocking-block", rocking_block},
    {"bowl", bowl},
    {"rattleback", rattleback},
    {"painleve-rod", painleve_rod},
    {"table", table},
    {"four-bar", four_bar},
    {"parallelogram", parallelogram},
    {"bennett", bennett},
    {"stack", stack},
    {"pile", pile},
    {"tower", tower},
    {"overhang", overhang},
    {"card", card},
    {"arch", arch},
    {"euler-disk", euler_disk},
    {"woodpecker", woodpecker},
    {"free-spin", free_spin},
    {"wedge", wedge},
    {"peg", peg},
    {"grip", grip},
    {"sunk-box", sunk_box},
    {"creep", creep},
    {"sliding-cube", sliding_cube},
    {"dominoes", dominoes},
    {"stairs", stairs},
    {"card-house", card_house},
    {"coin", coin},
    {"cone", cone},
    {"tetrahedra", tetrahedra},
    {"chute", chute},
    {"feeder", feeder},
    {"fixture", fixture},
};

}  // namespace

Scene scene(std::string_view name, const SceneParameters& set) {
  std::string known;
  for (const BuiltIn& candidate : built_in) {
    if (name == candidate.name) {
      Parameters parameters(name, set);
      Scene made = candidate.make(parameters);
      made.name = name;
      made.parameters = parameters.all();
      return made;
    }
    known += (known.empty() ? "" : ", ") + std::string(candidate.name);
  }
  refuse("scene", "name", name, "needs to be one of: " + known);
}

const std::vector<std::string>& scene_names() {
  static const std::vector<std::string> names = [] {
    std::vector<std::string> list;
    for (const BuiltIn& scene : built_in) list.emplace_back(scene.name);
    return list;
  }();
  return names;
}

}  // namespace perp
