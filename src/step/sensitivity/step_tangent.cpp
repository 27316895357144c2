#include "step/sensitivity/step_tangent.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "core/index.hpp"
#include "step/certificate/certificate.hpp"

namespace perp {

std::string StepTangent::name_of(const Reaction& r) const {
  if (r.of == Reaction::Of::Contact) return (*model_.point_names())[at(r.source)];
  const Instant& s = here_.start();
  const JointRowInstant& row =
      r.of == Reaction::Of::JointRow ? s.joint_rows[at(r.source)] : s.joint_frictions[at(r.source)];
  return model_.joint({row.joint}).name;
}

void StepTangent::miss(const Reaction* r, const std::string& what, std::vector<NoDerivative>& missing) const {
  missing.push_back({t_, r == nullptr ? "" : name_of(*r), what});
}

void StepTangent::take_reactions(const std::vector<Acting>& from, std::vector<Reaction>& to) const {
  to.clear();
  for (const Acting& a : from) {
    Reaction& r = to.emplace_back();
    r.of = a.of;
    r.source = a.source;
    r.p = a.p;
    r.w = a.w;
    if (a.of == Reaction::Of::JointRow) r.law = Law::Equality;
    if (a.of != Reaction::Of::JointFriction) continue;
    r.law = Law::Interval;
    r.p = {0, a.p.x(), 0};
  }
}

/// The largest speed that enters the step's equations.
double StepTangent::speed_of(const std::vector<Reaction>& all) const {
  double speed = 0;
  for (const Reaction& r : all)
    speed = std::max(
        {speed, r.w * r.p.cwiseAbs().maxCoeff(), r.W.velocity(modes_.answer.nu_q).cwiseAbs().maxCoeff()});
  return speed;
}

namespace {

/// Adds M of the instant where a stage has nothing else.
void mass_alone(const Model& model, const Instant& s, std::vector<Coupling>& K) {
  K.clear();
  add_mass(model, s, K);
}

/// Whether r, which may have slid in the first stage, keeps that stage's friction in the second.
bool keeps_friction(const Reaction& r, const Vector3& d, double speed) {
  constexpr double same = 1e-7;  // of the step's speeds: both laws are solved to 1e-10
  const double bound = r.law == Law::Interval ? r.mu : r.mu * r.p.x();
  const Vector3 miss = r.p + bound * d;
  return r.w * std::max(std::abs(miss.y()), std::abs(miss.z())) <= same * speed;
}

}  // namespace

/// The first stage at the answer: its reactions, their modes and its matrix.
bool StepTangent::take_modes(const State& before, const State& after, std::vector<NoDerivative>& missing) {
  const StepAnswer& answer = modes_.answer;
  const Instant& start = start_.at(model_, before, modes_.request.h);
  take_reactions(answer.first, here_.first);
  if (!here_.begin(model_, before, modes_, start) || !here_.evaluate_first(answer.nu_q)) {
    miss(nullptr, "a contact point came into being, or went, within the step", missing);
    return false;
  }
  for (Reaction& r : here_.first)
    if (!(r.w > 0)) r.w = inverse_mass(model_, here_.start(), r.W, r.law);
  speed_ = speed_of(here_.first);
  modes_.first.clear();
  modes_.whole.clear();
  std::string border;
  for (const Reaction& r : here_.first) {
    modes_.first.push_back(mode_of(r, speed_, border));
    modes_.whole.push_back(modes_.strikes(r.W) ? 1 : 0);
    if (!border.empty()) miss(&r, border, missing);
  }
  for (const ContactInstant& c : here_.end.contacts) {  // those that the step left out
    const auto listed = [&](const Reaction& r) {
      return r.of == Reaction::Of::Contact && r.source == c.point;
    };
    if (std::none_of(here_.first.begin(), here_.first.end(), listed) &&
        std::abs(c.psi_n) <= 1e-9 * modes_.request.h * speed_)
      missing.push_back({t_, (*model_.point_names())[at(c.point)],
                         "touches without a load, so that it may be closed or open"});
  }
  here_.differentiate_first(K_);
  const std::string fault = first_.factor(model_, K_, here_.first, modes_.first);
  if (!fault.empty()) miss(nullptr, "the step " + fault, missing);
  return !modes_.two_stages() || take_second_modes(after, missing);
}

/// The same of the second stage.
bool StepTangent::take_second_modes(const State& after, std::vector<NoDerivative>& missing) {
  const StepAnswer& answer = modes_.answer;
  take_reactions(answer.second, here_.second);
  modes_.source.clear();
  std::erase_if(here_.second, [&](const Reaction& r) {
    const auto same = std::find_if(here_.first.begin(), here_.first.end(),
                                   [&](const Reaction& f) { return f.of == r.of && f.source == r.source; });
    const bool taken =
        same != here_.first.end() && (answer.scheme == Scheme::Halves || modes_.strikes(same->W));
    if (taken) modes_.source.push_back(static_cast<int>(same - here_.first.begin()));
    return !taken;
  });
  for (std::size_t i = 0; i < here_.second.size(); ++i)
    here_.second[i].w = here_.first[at(modes_.source[i])].w;
  for (const Rebound law : rebounds) {  // that which the answer obeys
    modes_.rebound = law;
    if (!here_.evaluate_second(after.nu)) {
      miss(nullptr, "a contact point came into being, or went, within the step", missing);
      return false;
    }
    double off = 0;
    for (const Reaction& r : here_.second)
      if (r.of == Reaction::Of::Contact && r.w * r.p.x() > 1e-9 * speed_)
        off = std::max(off, std::abs(r.u.x()));
    if (off <= 1e-7 * speed_) break;
  }
  modes_.second.clear();
  std::string border;
  for (std::size_t i = 0; i < here_.second.size(); ++i) {
    const Reaction& r = here_.second[i];
    HeldMode mode = mode_of(r, speed_, border);
    const std::size_t source = at(modes_.source[i]);
    if (answer.scheme == Scheme::Halves && modes_.whole[source] == 0 && mode.held != Held::Open &&
        modes_.first[source].held == Held::Slides && keeps_friction(r, modes_.first[source].d, speed_)) {
      mode = {.held = Held::Tied, .d = modes_.first[source].d};
      border.clear();
    }
    modes_.second.push_back(mode);
    if (!border.empty()) miss(&r, border, missing);
  }
  mass_alone(model_, here_.end, K_);
  const std::string fault = second_.factor(model_, K_, here_.second, modes_.second);
  if (!fault.empty()) miss(nullptr, "the step " + fault, missing);
  return true;
}

/// The neighbours at the start of the step, and their first stage's R at the run's nu_q.
bool StepTangent::set_out(const State& before, const ParameterSides& sides, const StateTangent& old,
                          Eigen::Index j, Pair& pair) {
  constexpr int again = 64;   // steps after which they are set to either side of the run anew
  constexpr double near = 5;  // how far the half-width of a direction of the start may be from the best
  const std::array<const Model*, 2> models{sides.plus, sides.minus};
  const double wanted = sides.eps > 0 ? sides.eps : half_width(model_, before, old, j);
  const bool same = sides.eps > 0 ? pair.eps == wanted : pair.eps < near * wanted && wanted < near * pair.eps;
  // a run that looks at chosen contacts alone begins each step with other axes
  const bool goes_on = same && pair.models == models && pair.steps > 0 && pair.steps < again &&
                       pair.x[0].t == before.t && start_.near() == nullptr;
  if (!goes_on) pair.eps = wanted;
  pair.models = models;
  pair.steps = goes_on ? pair.steps + 1 : 1;
  for (std::size_t s = 0; s < 2; ++s) {
    StepSide& side = pair.sides[s];
    side.first = here_.first;
    side.second = here_.second;
    if (!goes_on)
      pair.x[s] = displaced(model_, before, old.xi.col(j), old.nu.col(j), s == 0 ? pair.eps : -pair.eps);
    const bool set = goes_on ? side.go_on(*models[s], pair.x[s], modes_)
                             : side.begin_like(*models[s], pair.x[s], modes_, here_.start());
    if (!set || !side.evaluate_first(modes_.answer.nu_q)) return false;
  }
  return true;
}

/// The tangent's column j at the end. Returns what is wrong with it.
std::string StepTangent::column(const State& before, const State& after, const ParameterSides& sides,
                                Eigen::Index j, const StateTangent& old, StateTangent& tangent) {
  constexpr double agree = 1e-5;  // of the right-hand side: differences are good to 1e-9
  const char* const gone = "a contact point is not there on one side";
  const char* const odd = "the constraints contradict each other on one side";
  Pair& pair = pairs_[at(j)];
  if (!set_out(before, sides, old, j, pair)) return pair.steps = 0, gone;
  const double eps = pair.eps;
  std::array<Vector, 2> F;
  for (std::size_t s = 0; s < 2; ++s)
    held_equations(pair.sides[s].first, modes_.first, pair.sides[s].R, F[s]);
  Vector rhs = -(F[0] - F[1]) / (2 * eps), dz = first_.solve(rhs);
  if (!(first_.miss(dz, rhs) < agree)) return odd;
  const Vector dnu_q = dz.head(model_.nv());
  std::vector<HeldMode> modes = modes_.second;
  for (std::size_t s = 0; s < 2; ++s) {
    StepSide& side = pair.sides[s];
    const double t = s == 0 ? eps : -eps;
    const Vector nu_q = modes_.answer.nu_q + t * dnu_q;
    add_impulses(modes_.first, dz, t, side.first);
    if (!side.evaluate_first(nu_q)) return gone;
    pair.x[s].q = side.moved().q;
    pair.x[s].t = after.t;
    if (!modes_.two_stages()) continue;
    if (!side.evaluate_second(after.nu)) return gone;
    for (std::size_t i = 0; i < modes.size(); ++i)
      if (modes[i].held == Held::Tied && modes_.first[at(modes_.source[i])].held == Held::Slides)
        modes[i].d = sliding_direction(side.first[at(modes_.source[i])]);
    held_equations(side.second, modes, side.R, F[s]);
  }
  Vector dnu = dnu_q;
  if (modes_.two_stages()) {
    rhs = -(F[0] - F[1]) / (2 * eps);
    dz = second_.solve(rhs);
    if (!(second_.miss(dz, rhs) < agree)) return odd;
    dnu = dz.head(model_.nv());
  }
  for (std::size_t s = 0; s < 2; ++s) {
    pair.x[s].nu = after.nu + (s == 0 ? eps : -eps) * dnu;
    pair.x[s].winding = after.winding;
  }
  tangent.xi.col(j) =
      (displacement(model_, after, pair.x[0]) - displacement(model_, after, pair.x[1])) / (2 * eps);
  tangent.nu.col(j) = dnu;
  return "";
}

bool StepTangent::step(const State& before, const State& after, const StepFigures& figures,
                       const StepAnswer& answer, double max_correction_speed,
                       std::span<const ParameterSides> sides, StateTangent& tangent,
                       std::vector<NoDerivative>& missing) {
  t_ = after.t;
  modes_.answer = answer;
  modes_.request = {.h = figures.h, .t_end = after.t, .max_correction_speed = max_correction_speed};
  if (!take_modes(before, after, missing)) return false;
  const StateTangent old = tangent;
  pairs_.resize(sides.size());
  for (Eigen::Index j = 0; j < old.xi.cols(); ++j) {
    const std::string fault = column(before, after, sides[at(j)], j, old, tangent);
    if (fault.empty()) continue;
    miss(nullptr, fault, missing);
    return false;
  }
  evaluate(model_, after, here_.end, &here_.start());
  start_.go_on_from(model_, after, figures.energy, here_.end);
  return true;
}

}  // namespace perp
