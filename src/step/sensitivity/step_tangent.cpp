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

/// The tangent's column j at the end. Returns what is wrong with it.
std::string StepTangent::column(const State& before, const State& after, const ParameterSides& sides,
                                Eigen::Index j, const StateTangent& old, StateTangent& tangent) {
  constexpr double agree = 1e-5;  // of the right-hand side: differences are good to 1e-9
  const char* const gone = "a contact point is not there on one side";
  const double eps = sides.eps > 0 ? sides.eps : half_width(model_, before, old, j);
  const std::array<StepSide*, 2> both{&plus_, &minus_};
  std::array<State, 2> from, to;
  std::array<Vector, 2> F;
  for (std::size_t s = 0; s < 2; ++s) {
    const double t = s == 0 ? eps : -eps;
    const Model& model = s == 0 ? *sides.plus : *sides.minus;
    from[s] = displaced(model, before, old.xi.col(j), old.nu.col(j), t);
    both[s]->first = here_.first;
    both[s]->second = here_.second;
    if (!both[s]->begin_like(model, from[s], modes_, here_.start()) ||
        !both[s]->evaluate_first(modes_.answer.nu_q))
      return gone;
    held_equations(both[s]->first, modes_.first, both[s]->R, F[s]);
  }
  const Vector rhs = -(F[0] - F[1]) / (2 * eps), dz = first_.solve(rhs);
  if (!(first_.miss(dz, rhs) < agree)) return "the constraints contradict each other on one side";
  Vector dnu = dz.head(model_.nv());
  for (std::size_t s = 0; s < 2; ++s) {
    const double t = s == 0 ? eps : -eps;
    const Model& model = s == 0 ? *sides.plus : *sides.minus;
    const Vector nu_q = modes_.answer.nu_q + t * dnu;
    to[s] = from[s];
    move(model, nu_q, modes_.request.h, to[s].q);
    if (!modes_.two_stages()) continue;
    add_impulses(modes_.first, dz, t, both[s]->first);
    if (!both[s]->evaluate_first(nu_q) || !both[s]->evaluate_second(after.nu)) return gone;
    std::vector<HeldMode> modes = modes_.second;
    for (std::size_t i = 0; i < modes.size(); ++i)
      if (modes[i].held == Held::Tied && modes_.first[at(modes_.source[i])].held == Held::Slides)
        modes[i].d = sliding_direction(both[s]->first[at(modes_.source[i])]);
    held_equations(both[s]->second, modes, both[s]->R, F[s]);
  }
  if (modes_.two_stages()) {
    const Vector rhs2 = -(F[0] - F[1]) / (2 * eps), dz2 = second_.solve(rhs2);
    if (!(second_.miss(dz2, rhs2) < agree)) return "the constraints contradict each other on one side";
    dnu = dz2.head(model_.nv());
  }
  tangent.xi.col(j) = (displacement(model_, after, to[0]) - displacement(model_, after, to[1])) / (2 * eps);
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
