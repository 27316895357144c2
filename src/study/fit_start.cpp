#include "study/fit_start.hpp"

#include <algorithm>
#include <cmath>
#include <Eigen/QR>
#include <optional>

namespace perp {
namespace {

/// A parabola's value and slope at t0, and how far the points are from it.
struct Parabola {
  double value = 0, slope = 0, rms = 0;
};

Parabola parabola(const std::vector<double>& t, const std::vector<double>& y, std::size_t n, double t0) {
  const double T = std::max(t[n - 1] - t[0], 1e-300);
  Matrix A(n, 3);
  Vector b(n);
  for (std::size_t i = 0; i < n; ++i) {
    const auto I = static_cast<Eigen::Index>(i);
    const double s = (t[i] - t0) / T;
    A.row(I) << 1, s, s * s;
    b[I] = y[i];
  }
  const Vector c = A.colPivHouseholderQr().solve(b);
  const double freedom = std::max(1.0, static_cast<double>(n) - 3);
  return {c[0], c[1] / T, std::sqrt((A * c - b).squaredNorm() / freedom)};
}

/// Through the longest beginning that one parabola fits as well as it does a short one.
std::optional<Parabola> beginning(const std::vector<double>& t, const std::vector<double>& y, double t0) {
  constexpr std::size_t shortest_one = 6;
  constexpr double worse = 1.4;  // of the scatter about the shorter one
  if (t.size() < 2) return std::nullopt;
  if (t.size() < shortest_one) {
    const double slope = (y[1] - y[0]) / (t[1] - t[0]);
    return Parabola{y[0] + slope * (t0 - t[0]), slope, 0};
  }
  std::size_t n = std::min<std::size_t>(t.size(), 8);
  Parabola best = parabola(t, y, n, t0);
  while (n < t.size()) {
    n = std::min(t.size(), n + n / 2);
    const Parabola longer = parabola(t, y, n, t0);
    if (longer.rms > worse * best.rms) break;
    best = longer;
  }
  return best;
}

/// A column's measured values and their times by the model's clock as far as it is known before the fit.
struct Series {
  std::vector<double> t, y;
};

Series series(const FitRuns& runs, int motion, const std::string& column, double offset) {
  Series s;
  for (const MeasuredCell& cell : runs.cells(motion))
    if (runs.columns()[static_cast<std::size_t>(cell.column)] == column) {
      s.t.push_back(runs.motion(motion).t[static_cast<std::size_t>(cell.row)] + offset);
      s.y.push_back(cell.value);
    }
  return s;
}

/// A rotation wholly free, wholly measured: base and spin from the first rows.
void guess_rotation(const FitRuns& runs, Unknowns& unknowns, int motion, BodyId body, const std::string& name,
                    double offset, double t0) {
  std::array<Series, 4> q;
  const char* parts[] = {".qw", ".qx", ".qy", ".qz"};
  for (std::size_t i = 0; i < 4; ++i) q[i] = series(runs, motion, name + parts[i], offset);
  for (const Series& s : q)
    if (s.t.size() != q[0].t.size() || s.t.size() < 2) return;
  const auto at = [&](std::size_t k) {
    return Quaternion(q[0].y[k], q[1].y[k], q[2].y[k], q[3].y[k]).normalized();
  };
  const Quaternion first = at(0);
  std::array<Series, 3> turn;
  Vector3 last = Vector3::Zero();
  for (std::size_t k = 0; k < q[0].t.size(); ++k) {
    const Vector3 r = rotation_vector(at(k) * first.conjugate());
    if ((r - last).norm() > 1) break;  // rad: past half a turn the vector jumps
    last = r;
    for (int i = 0; i < 3; ++i) {
      turn[static_cast<std::size_t>(i)].t.push_back(q[0].t[k]);
      turn[static_cast<std::size_t>(i)].y.push_back(r[i]);
    }
  }
  Vector3 r0 = Vector3::Zero(), w = Vector3::Zero();
  for (int i = 0; i < 3; ++i)
    if (const auto p =
            beginning(turn[static_cast<std::size_t>(i)].t, turn[static_cast<std::size_t>(i)].y, t0))
      r0[i] = p->value, w[i] = p->slope;
  for (auto& [b, orientation] : unknowns.bases[static_cast<std::size_t>(motion)].orientations)
    if (b == body) orientation = rotation(r0) * first;
  for (int i = 0; i < unknowns.size(); ++i) {
    Unknown& u = unknowns[i];
    if (u.motion == motion && u.body == body && u.kind == UnknownKind::Spin && w.allFinite())
      u.guess = std::clamp(w[u.index], u.low, u.high);
  }
}

}  // namespace

void guess_from_data(const FitRuns& runs, const Scene& scene, Unknowns& unknowns) {
  double length = 0, duration = 0;
  for (std::size_t c = 0; c < runs.columns().size(); ++c) {
    const std::string& name = runs.columns()[c];
    if (name.ends_with(".x") || name.ends_with(".y") || name.ends_with(".z"))
      length = std::max(length, runs.spread(static_cast<int>(c)));
  }
  if (!(length > 0))
    length = std::max(1e-3, scene.start.q.size() > 0 ? scene.start.q.cwiseAbs().maxCoeff() : 1);
  for (int m = 0; m < runs.motions(); ++m)
    duration = std::max(duration, runs.motion(m).t.back() - runs.motion(m).t.front());
  if (!(duration > 0)) duration = scene.t_end;
  const double t0 = scene.start.t;
  std::vector<double> offsets(static_cast<std::size_t>(runs.motions()), 0.0);
  for (int i = 0; i < unknowns.size(); ++i) {
    Unknown& u = unknowns[i];
    if (u.kind != UnknownKind::ClockOffset) continue;
    // a clock of its own: the first row is near the start, unless it is within the record already
    const double first = runs.motion(u.motion).t.front();
    if (std::abs(first - t0) > 0.5 * duration) u.guess = std::clamp(t0 - first, u.low, u.high);
    offsets[static_cast<std::size_t>(u.motion)] = u.guess;
  }
  for (int i = 0; i < unknowns.size(); ++i) {
    Unknown& u = unknowns[i];
    using enum UnknownKind;
    const double bounded = u.high - u.low;
    switch (u.kind) {
      case Parameter:
        u.scale = u.guess != 0 ? std::abs(u.guess) : std::isfinite(bounded) ? bounded / 2 : 1;
        continue;
      case ClockOffset:
        u.scale = 0.2 * duration;
        continue;
      case ClockRate:
      case Scale:
        u.scale = 0.2;
        continue;
      case Shift:
        u.scale = length;
        continue;
      case Turn:
        u.scale = 0.5;
        continue;
      default:
        break;
    }
    const double offset = offsets[static_cast<std::size_t>(u.motion)];
    if (u.kind == Rotation) {
      u.scale = 1;
      u.guess = 0;
      if (u.index == 0 && unknowns.whole_rotation(u.motion, u.body))
        guess_rotation(runs, unknowns, u.motion, u.body, scene.model.body(u.body).name, offset, t0);
      continue;
    }
    const bool angle = u.name.ends_with("angle") || u.kind == Spin || u.name.ends_with("omega");
    const double size = angle ? 1 : length;
    u.scale = u.kind == Coordinate ? size : size / std::min(duration, 1.0);
    std::string position = u.name;
    if (u.kind == Rate) {
      const std::size_t dot = u.name.rfind('.');
      std::string part = u.name.substr(dot + 1);
      position = u.name.substr(0, dot + 1) + (part == "omega"                      ? "angle"
                                              : part.size() == 2 && part[1] >= 'x' ? part.substr(1)
                                                                                   : "q" + part.substr(1));
    }
    const Series direct = series(runs, u.motion, u.name, offset),
                 through = series(runs, u.motion, position, offset);
    if (u.kind != Spin || direct.t.size() > 1) {
      if (const auto p = beginning(direct.t, direct.y, t0))
        u.guess = std::clamp(p->value, u.low, u.high);
      else if (const auto q = beginning(through.t, through.y, t0); q && u.kind == Rate)
        u.guess = std::clamp(q->slope, u.low, u.high);
    }
  }
}

}  // namespace perp
