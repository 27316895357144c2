#include "io/scene_motions.hpp"

#include <algorithm>
#include <array>

#include "io/expression_timing.hpp"
#include "io/scene_text.hpp"

namespace perp {
namespace {

using Columns = Eigen::Matrix<double, Eigen::Dynamic, 6>;

/// Displacement and rotation angles about the world's x, then y, then z, and their rates.
struct Excursion {
  Vector3 p, angles, p_t, angles_t;
};
using Path = std::function<Excursion(double t)>;

/// The motion that displaces and turns `about`: with R = Rz Ry Rx the angular velocity is c' z + Rz (b' y + Ry a' x).
PrescribedMotion along(Path path, const Pose& about, Timing timing) {
  const auto turn = [](int axis, double angle) { return rotation(angle * Vector3::Unit(axis)); };
  PrescribedMotion motion;
  motion.pose = [=](double t) {
    const Excursion e = path(t);
    return Pose{about.p + e.p,
                turn(2, e.angles.z()) * turn(1, e.angles.y()) * turn(0, e.angles.x()) * about.q};
  };
  const auto twist = [=](double t) {
    const Excursion e = path(t);
    const Vector3 inner =
        e.angles_t.y() * Vector3::UnitY() + turn(1, e.angles.y()) * Vector3(e.angles_t.x(), 0, 0);
    return Twist{e.p_t, e.angles_t.z() * Vector3::UnitZ() + turn(2, e.angles.z()) * inner};
  };
  motion.twist = Timed<Twist(double)>(twist, std::move(timing));
  return motion;
}

Vector3 values(const std::vector<Expression>& f, double t) {
  const std::array at{t};
  return {f[0](at), f[1](at), f[2](at)};
}

Vector3 rates(const std::vector<Expression>& f, double t) {
  const std::array at{t};
  return {f[0].derivative(at, 0), f[1].derivative(at, 0), f[2].derivative(at, 0)};
}

/// The natural cubic spline through the rows of y at the times t: two continuous derivatives, and beyond its ends straight on.
/// Its second derivatives m solve, at each inner time with the steps h,
///   h_i m_i-1 + 2 (h_i + h_i+1) m_i + h_i+1 m_i+1 = 6 (slope_i+1 - slope_i),   m = 0 at the ends.
class Spline {
 public:
  Spline(std::vector<double> t, Columns y)
      : t_(std::move(t)), y_(std::move(y)), m_(Columns::Zero(y_.rows(), 6)) {
    const Eigen::Index n = y_.rows();
    Vector above = Vector::Zero(n);  // of the eliminated rows
    for (Eigen::Index i = 1; i + 1 < n; ++i) {
      const double pivot = 2 * (h(i) + h(i + 1)) - h(i) * above[i - 1];
      above[i] = h(i + 1) / pivot;
      m_.row(i) = (6 * (slope(i + 1) - slope(i)) - h(i) * m_.row(i - 1)) / pivot;
    }
    for (Eigen::Index i = n - 2; i > 0; --i) m_.row(i) -= above[i] * m_.row(i + 1);
  }

  Excursion operator()(double t) const {
    const auto next = std::upper_bound(t_.begin() + 1, t_.end() - 1, t);
    const Eigen::Index i = next - t_.begin();
    const double inside = std::clamp(t, t_.front(), t_.back());
    const double b = (inside - t_[static_cast<std::size_t>(i) - 1]) / h(i), a = 1 - b, s = h(i) * h(i) / 6;
    const Eigen::Matrix<double, 1, 6> rate =
        slope(i) + h(i) / 6 * ((1 - 3 * a * a) * m_.row(i - 1) + (3 * b * b - 1) * m_.row(i));
    const Eigen::Matrix<double, 1, 6> y =
        a * y_.row(i - 1) + b * y_.row(i) +
        s * ((a * a * a - a) * m_.row(i - 1) + (b * b * b - b) * m_.row(i)) + (t - inside) * rate;
    return {y.head<3>(), y.tail<3>(), rate.head<3>(), rate.tail<3>()};
  }

 private:
  double h(Eigen::Index i) const {
    return t_[static_cast<std::size_t>(i)] - t_[static_cast<std::size_t>(i) - 1];
  }
  Eigen::Matrix<double, 1, 6> slope(Eigen::Index i) const { return (y_.row(i) - y_.row(i - 1)) / h(i); }

  std::vector<double> t_;
  Columns y_, m_;
};

void append(std::vector<double>& numbers, const Vector3& v) {
  numbers.insert(numbers.end(), v.begin(), v.end());
}

std::vector<double> numbers_of(const Pose& pose) {
  return {pose.p.x(), pose.p.y(), pose.p.z(), pose.q.w(), pose.q.x(), pose.q.y(), pose.q.z()};
}

std::vector<std::string> texts_of(const std::vector<Expression>& expressions) {
  std::vector<std::string> texts;
  for (const Expression& e : expressions) texts.push_back(e.text());
  return texts;
}

PrescribedMotion read_function(const SceneTable& table, const Pose& pose) {
  table.allow({"kind", "position", "rotation", "surface"});
  const std::vector<std::string> time{"t"};
  const auto position = table.expressions("position", time, Dimension::Length);
  const auto angles = table.expressions("rotation", time, Dimension::Angle);
  for (const auto& [key, list] : {std::pair("position", &position), std::pair("rotation", &angles)})
    for (const Expression& e : *list)
      if (e.may_jump())
        table.refuse(key, "the expression \"" + e.text() + "\" with a step",
                     "a motion needs to be continuous");
  std::vector<Expression> parts = position, surface;
  parts.insert(parts.end(), angles.begin(), angles.end());
  if (table.has("surface")) surface = table.expressions("surface", time, Dimension::Velocity);
  parts.insert(parts.end(), surface.begin(), surface.end());
  PrescribedMotion motion = along(
      [=](double t) {
        return Excursion{values(position, t), values(angles, t), rates(position, t), rates(angles, t)};
      },
      pose, timing_of(parts, {}));
  motion.recipe = {"function", numbers_of(pose), texts_of(position)};
  const auto add = [&](const std::vector<Expression>& more) {
    const auto texts = texts_of(more);
    motion.recipe.texts.insert(motion.recipe.texts.end(), texts.begin(), texts.end());
  };
  add(angles);
  if (!surface.empty()) {
    motion.surface = [=](double t, const Vector3&) { return values(surface, t); };
    add(surface);
  }
  return motion;
}

PrescribedMotion read_samples(const SceneTable& table, const Pose& pose) {
  table.allow({"kind", "t", "position", "rotation"});
  const std::vector<double> t = table.numbers("t", 2, SceneTable::many, Dimension::Time);
  for (std::size_t i = 1; i < t.size(); ++i)
    if (!(t[i] > t[i - 1]))
      table.refuse("t",
                   "the time " + written(std::span(&t[i], 1)) + " after " + written(std::span(&t[i - 1], 1)),
                   "needs times that increase");
  const std::vector<Vector3> still(t.size(), Vector3::Zero());
  const auto position =
      table.has("position") ? table.vectors("position", t.size(), Dimension::Length) : still;
  const auto angles = table.has("rotation") ? table.vectors("rotation", t.size(), Dimension::Angle) : still;
  Columns y(static_cast<Eigen::Index>(t.size()), 6);
  std::vector<double> numbers = numbers_of(pose);
  for (std::size_t i = 0; i < t.size(); ++i) {
    y.row(static_cast<Eigen::Index>(i)) << position[i].transpose(), angles[i].transpose();
    numbers.push_back(t[i]);
    append(numbers, position[i]);
    append(numbers, angles[i]);
  }
  PrescribedMotion motion = along(Spline(t, y), pose, {.times = t});  // where its third derivative jumps
  motion.recipe = {"table", numbers, {}};
  return motion;
}

const std::vector<std::string> kinds{"shaker", "turntable", "belt", "function", "table"};

/// What a force may depend on, and its values now.
std::vector<std::string> coordinates_of(BodyKind kind) {
  if (kind == BodyKind::Planar) return {"t", "x", "y", "angle", "vx", "vy", "omega"};
  std::vector<std::string> names{"t", "x", "y", "z", "vx", "vy", "vz"};
  if (kind == BodyKind::Spatial) names.insert(names.end(), {"wx", "wy", "wz"});
  return names;
}

std::array<double, 10> coordinates_now(const Model& model, const State& x, BodyId body) {
  const Vector3 p = model.position(x, body);
  const Twist V = model.twist(x, body);
  if (model.body(body).kind == BodyKind::Planar)
    return {x.t, p.x(), p.y(), model.angle(x, body), V.v.x(), V.v.y(), V.w.z()};
  return {x.t, p.x(), p.y(), p.z(), V.v.x(), V.v.y(), V.v.z(), V.w.x(), V.w.y(), V.w.z()};
}

}  // namespace

PrescribedMotion read_motion(const SceneTable& table, const Pose& pose) {
  switch (table.word("kind", kinds)) {
    case 0: {
      table.allow({"kind", "amplitude", "rate", "phase"});
      const Vector3 amplitude = table.vector("amplitude", Dimension::Length);
      const double rate = table.number("rate", Dimension::Rate);
      return PrescribedMotion::shaker(amplitude, rate, table.number("phase", Dimension::Angle, 0), pose);
    }
    case 1: {
      table.allow({"kind", "axis", "rate"});
      const Vector3 axis = table.vector("axis", Dimension::None, Vector3::UnitZ());
      const double rate = table.number("rate", Dimension::Rate);
      return table.placed([&] { return PrescribedMotion::turntable(axis, rate, pose); });
    }
    case 2:
      table.allow({"kind", "velocity"});
      return PrescribedMotion::belt(table.vector("velocity", Dimension::Velocity), pose);
    case 3:
      return read_function(table, pose);
    default:
      return read_samples(table, pose);
  }
}

Pose pose_of_motion(const Recipe& recipe) {
  const bool last = recipe.maker != "function" && recipe.maker != "table";
  const double* x = recipe.numbers.data() + (last ? recipe.numbers.size() - 7 : 0);
  return {{x[0], x[1], x[2]}, {x[3], x[4], x[5], x[6]}};
}

std::string write_motion(const Recipe& recipe) {
  const std::span<const double> x(recipe.numbers);
  const std::span<const std::string> texts(recipe.texts);
  InlineTable table;
  table.add("kind", in_quotes(recipe.maker));
  if (recipe.maker == "shaker") {
    table.add("amplitude", written(x.first(3)));
    table.add("rate", written(x.subspan(3, 1)));
    table.add("phase", written(x.subspan(4, 1)));
  } else if (recipe.maker == "turntable") {
    table.add("axis", written(x.first(3)));
    table.add("rate", written(x.subspan(3, 1)));
  } else if (recipe.maker == "belt") {
    if (std::all_of(x.begin(), x.begin() + 3, [](double v) { return same_bits(v, 0); })) return {};
    table.add("velocity", written(x.first(3)));
  } else if (recipe.maker == "function") {
    table.add("position", written(texts.first(3)));
    table.add("rotation", written(texts.subspan(3, 3)));
    if (texts.size() == 9) table.add("surface", written(texts.subspan(6, 3)));
  } else {
    std::vector<double> t;
    std::string position, angles;
    for (std::size_t i = 7; i < x.size(); i += 7) {
      t.push_back(x[i]);
      position.append(position.empty() ? "[" : ", ").append(written(x.subspan(i + 1, 3)));
      angles.append(angles.empty() ? "[" : ", ").append(written(x.subspan(i + 4, 3)));
    }
    table.add("t", written(t));
    table.add("position", position + "]");
    table.add("rotation", angles + "]");
  }
  return table.text();
}

void read_force(const SceneTable& table, Model& model) {
  const BodyId body = table.body("body");
  const BodyKind kind = model.body(body).kind;
  if (kind == BodyKind::Ground || kind == BodyKind::Prescribed)
    table.refuse("body", "the body '" + model.body(body).name + "', which nothing can move",
                 "needs a body that can");
  const bool particle = kind == BodyKind::Particle, planar = kind == BodyKind::Planar;
  table.allow(particle ? std::vector<std::string>{"body", "force"}
                       : std::vector<std::string>{"body", "force", "moment", "at"});
  const std::vector<std::string> variables = coordinates_of(kind);
  for (const std::string& name : variables)
    if (table.source().parameters.contains(name))
      table.refuse("force", "the parameter '" + name + "'",
                   "needs another name: in forces this is a coordinate of the body");

  std::vector<Expression> load = table.expressions("force", variables, Dimension::Force);
  std::vector<Expression> moment(3, Expression("0", {}));
  if (planar && table.has("moment"))
    moment[2] = table.expression("moment", variables, Dimension::Moment);
  else
    moment = table.expressions("moment", variables, Dimension::Moment);
  load.insert(load.end(), moment.begin(), moment.end());
  const Vector3 at = table.vector("at", Dimension::Length, Vector3::Zero());
  const auto values_now = [body](const Model& m, const State& x) {
    const std::array now = coordinates_now(m, x, body);
    return std::vector(now.begin(), now.end());
  };
  const auto wrench = [=](const Model& m, const State& x) {
    const std::array now = coordinates_now(m, x, body);
    const auto three = [&](std::size_t i) {
      return Vector3(load[i](now), load[i + 1](now), load[i + 2](now));
    };
    const Vector3 force = three(0);
    return Wrench{force, three(3) + (m.pose(x, body).q * at).cross(force)};
  };
  model.add_force(body, Timed<Wrench(const Model&, const State&)>(wrench, timing_of(load, values_now)),
                  {"expressions", {at.x(), at.y(), at.z()}, texts_of(load)});
}

std::string write_force(const Model& model, const BodyForce& force) {
  const std::span<const std::string> texts(force.recipe.texts);
  const Body& body = model.body(force.body);
  std::string text = "body = " + in_quotes(body.name) + "\nforce = " + written(texts.first(3)) + "\n";
  if (body.kind == BodyKind::Planar) text += "moment = " + in_quotes(texts[5]) + "\n";
  if (body.kind == BodyKind::Spatial) text += "moment = " + written(texts.subspan(3, 3)) + "\n";
  if (body.kind != BodyKind::Particle) text += "at = " + written(force.recipe.numbers) + "\n";
  return text;
}

}  // namespace perp
