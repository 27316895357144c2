#include "study/fit_unknowns.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "perp/core/errors.hpp"

namespace perp {
namespace {

constexpr const char* where = "fit";

/// What a start's quantity is called for each kind of body, and where in the state it is.
struct StartPart {
  std::string name;
  UnknownKind kind;
  int index = 0;  // of q, nu or an axis
};

std::vector<StartPart> start_parts(const Body& body) {
  using enum UnknownKind;
  std::vector<StartPart> parts;
  const auto coordinates = [&](std::initializer_list<const char*> names, UnknownKind kind, int first) {
    for (const char* name : names) parts.push_back({name, kind, first++});
  };
  switch (body.kind) {
    case BodyKind::Spatial:
      coordinates({"x", "y", "z"}, Coordinate, body.q0);
      coordinates({"rx", "ry", "rz"}, Rotation, 0);
      coordinates({"vx", "vy", "vz"}, Rate, body.v0);
      coordinates({"wx", "wy", "wz"}, Spin, 0);
      break;
    case BodyKind::Planar:
      coordinates({"x", "y", "angle"}, Coordinate, body.q0);
      coordinates({"vx", "vy", "omega"}, Rate, body.v0);
      break;
    case BodyKind::Particle:
      coordinates({"x", "y", "z"}, Coordinate, body.q0);
      coordinates({"vx", "vy", "vz"}, Rate, body.v0);
      break;
    case BodyKind::Generalized:
      for (int i = 0; i < body.nq; ++i)
        parts.push_back({"q" + std::to_string(i + 1), Coordinate, body.q0 + i});
      for (int i = 0; i < body.nv; ++i) parts.push_back({"v" + std::to_string(i + 1), Rate, body.v0 + i});
      break;
    case BodyKind::Prescribed:
    case BodyKind::Ground:
      break;
  }
  return parts;
}

bool is_quaternion(const std::string& part) {
  return part == "qw" || part == "qx" || part == "qy" || part == "qz";
}

/// The data's clock and frame; their natural sizes are set with the data at hand.
struct Instrument {
  const char* name;
  UnknownKind kind;
  int index;
  double neutral;
};
constexpr std::array instruments{Instrument{"clock.offset", UnknownKind::ClockOffset, 0, 0},
                                 Instrument{"clock.rate", UnknownKind::ClockRate, 0, 1},
                                 Instrument{"frame.x", UnknownKind::Shift, 0, 0},
                                 Instrument{"frame.y", UnknownKind::Shift, 1, 0},
                                 Instrument{"frame.z", UnknownKind::Shift, 2, 0},
                                 Instrument{"frame.rx", UnknownKind::Turn, 0, 0},
                                 Instrument{"frame.ry", UnknownKind::Turn, 1, 0},
                                 Instrument{"frame.rz", UnknownKind::Turn, 2, 0},
                                 Instrument{"frame.scale", UnknownKind::Scale, 0, 1}};

std::string all_names(const Scene& scene) {
  std::string names;
  for (const SceneParameter& p : scene.parameters) names += p.name + ", ";
  for (const Instrument& i : instruments) names += std::string(i.name) + ", ";
  for (const Body& body : scene.model.bodies()) {
    const std::vector<StartPart> parts = start_parts(body);
    if (parts.empty()) continue;
    names += body.name + ".start, ";
    for (const StartPart& part : parts) names += body.name + "." + part.name + ", ";
  }
  return names.substr(0, names.size() - 2);
}

}  // namespace

Unknowns::Unknowns(const FitProblem& problem, const Scene& scene, const std::vector<MeasuredMotion>& motions)
    : bases(motions.size()) {
  const int count = static_cast<int>(motions.size());
  const Model& model = scene.model;
  if (problem.free.empty()) refuse(where, "free", "nothing", "needs one name or more of " + all_names(scene));
  for (const FreeQuantity& free : problem.free) {
    if (!(free.low < free.high))
      refuse(where, "free", free.name + "=" + shortest(free.low) + ":" + shortest(free.high),
             "needs a lower bound below the upper one");
    const auto add = [&](UnknownKind kind, int index, double guess, int motion) {
      all_.push_back({.name = free.name,
                      .kind = kind,
                      .motion = motion,
                      .index = index,
                      .low = free.low,
                      .high = free.high,
                      .guess = std::clamp(guess, free.low, free.high)});
    };
    const std::size_t before = all_.size();
    for (const SceneParameter& p : scene.parameters)
      if (p.name == free.name) add(UnknownKind::Parameter, 0, p.value, -1);
    for (const Instrument& i : instruments)
      if (free.name == i.name && all_.size() == before)
        for (int m = 0; m < (i.kind == UnknownKind::ClockOffset ? count : 1); ++m)
          add(i.kind, i.index, i.neutral, i.kind == UnknownKind::ClockOffset ? m : -1);
    const std::size_t dot = free.name.rfind('.');
    for (int b = 1; b < static_cast<int>(model.bodies().size()) && all_.size() == before; ++b)
      if (dot != std::string::npos && model.body({b}).name == free.name.substr(0, dot))
        add_start(free, model, {b}, free.name.substr(dot + 1), count);
    if (all_.size() == before) refuse(where, "free", free.name, "needs to be one of " + all_names(scene));
  }
  for (std::size_t i = 0; i < all_.size(); ++i)
    for (std::size_t k = 0; k < i; ++k)
      if (all_[i].name == all_[k].name && all_[i].motion == all_[k].motion)
        refuse(where, "free", all_[i].name, "needs to be named once");
  const State x = scene.start;
  for (Unknown& u : all_) {
    if (u.kind == UnknownKind::Coordinate) u.guess = std::clamp(x.q[u.index], u.low, u.high);
    if (u.kind == UnknownKind::Rate) u.guess = std::clamp(x.nu[u.index], u.low, u.high);
    if (u.kind == UnknownKind::Spin)
      u.guess = std::clamp(model.angular_velocity(x, u.body)[u.index], u.low, u.high);
  }
  for (const Unknown& u : all_) {
    if (u.kind != UnknownKind::Rotation) continue;
    auto& of_motion = bases[static_cast<std::size_t>(u.motion)].orientations;
    const bool there =
        std::any_of(of_motion.begin(), of_motion.end(), [&](const auto& o) { return o.first == u.body; });
    if (!there) of_motion.emplace_back(u.body, model.pose(x, u.body).q);
  }
}

void Unknowns::add_start(const FreeQuantity& free, const Model& model, BodyId body, const std::string& part,
                         int motions) {
  const bool all = part == "start", rotation = is_quaternion(part);
  if ((all || rotation) && (free.low > -infinity || free.high < infinity))
    refuse(where, "free", free.name, "needs no bounds: it is more than one number");
  for (int m = 0; m < motions; ++m)
    for (const StartPart& p : start_parts(model.body(body))) {
      const bool wanted = all || (rotation && p.kind == UnknownKind::Rotation) || p.name == part;
      const std::string name = model.body(body).name + "." + p.name;
      const bool there = std::any_of(all_.begin(), all_.end(), [&](const Unknown& u) {
        return u.name == name && u.motion == m && (all || rotation);
      });
      if (wanted && !there)
        all_.push_back({.name = name,
                        .kind = p.kind,
                        .motion = m,
                        .body = body,
                        .index = p.index,
                        .low = free.low,
                        .high = free.high});
    }
}

std::vector<int> Unknowns::of(int motion) const {
  std::vector<int> mine;
  for (int i = 0; i < size(); ++i)
    if ((*this)[i].shared() || (*this)[i].motion == motion) mine.push_back(i);
  return mine;
}

bool Unknowns::whole_rotation(int motion, BodyId body) const {
  return 3 == std::count_if(all_.begin(), all_.end(), [&](const Unknown& u) {
           return u.kind == UnknownKind::Rotation && u.motion == motion && u.body == body;
         });
}

SceneParameters Unknowns::parameters(const SceneParameters& set, const Vector& theta) const {
  SceneParameters values = set;
  for (int i = 0; i < size(); ++i)
    if ((*this)[i].kind == UnknownKind::Parameter) values[(*this)[i].name] = theta[i];
  return values;
}

Recording Unknowns::recording(int motion, const Vector& theta) const {
  Recording r;
  for (const int i : of(motion)) {
    const Unknown& u = (*this)[i];
    if (u.kind == UnknownKind::ClockOffset) r.offset = theta[i];
    if (u.kind == UnknownKind::ClockRate) r.rate = theta[i];
    if (u.kind == UnknownKind::Shift) r.shift[u.index] = theta[i];
    if (u.kind == UnknownKind::Turn) r.turn[u.index] = theta[i];
    if (u.kind == UnknownKind::Scale) r.scale = theta[i];
  }
  return r;
}

State Unknowns::start(const Scene& scene, int motion, const Vector& theta) const {
  const Model& model = scene.model;
  State x = scene.start;
  const std::vector<int> mine = of(motion);
  for (const auto& [body, orientation] : bases[static_cast<std::size_t>(motion)].orientations) {
    Vector3 r = Vector3::Zero();
    for (const int i : mine)
      if ((*this)[i].kind == UnknownKind::Rotation && (*this)[i].body == body) r[(*this)[i].index] = theta[i];
    const Vector3 w = model.angular_velocity(x, body);
    model.set_orientation(x, body, rotation(r) * orientation);
    model.set_velocity(x, body, model.velocity(x, body), w);
  }
  for (const int i : mine) {
    const Unknown& u = (*this)[i];
    if (u.kind == UnknownKind::Coordinate) x.q[u.index] = theta[i];
    if (u.kind == UnknownKind::Rate) x.nu[u.index] = theta[i];
    if (u.kind != UnknownKind::Spin) continue;
    Vector3 w = model.angular_velocity(x, u.body);
    w[u.index] = theta[i];
    model.set_velocity(x, u.body, model.velocity(x, u.body), w);
  }
  return x;
}

}  // namespace perp
