#include "step/impacts/impact_sequence.hpp"

#include <algorithm>
#include <cmath>

#include "core/index.hpp"
#include "perp/core/errors.hpp"
#include "perp/instant/instant.hpp"
#include "step/modes/modes.hpp"

namespace perp {
namespace {

/// One pair of bodies after the other.
class Sequence {
 public:
  /// Which of the pairs that approach alike come first.
  enum class Ties { Together, First, Last };

  Sequence(const Model& model, const State& x, const ImpactOptions& options)
      : model_(model), x_(x), stage_(options) {
    evaluate(model, x, s_);
    if (!s_.fault.empty()) refuse("solve_impact", "x", "a state", s_.fault);
    const Scales scales = scales_of(model, x, s_);
    stage_.order = ImpactOrder::Simultaneous;
    if (std::isnan(stage_.small_gap)) stage_.small_gap = scales.small_gap();
    speed_ = scales.small_speed();
  }

  Impact solve(Ties ties) {
    Impact whole = at_rest();
    State x = x_;
    for (; whole.stages < most_; ++whole.stages) {
      stage_.only = next(x.nu, ties);
      if (stage_.only.empty()) return finish(std::move(whole));
      if (!add(solve_impact(model_, x, stage_), x, whole)) return whole;
    }
    stage_.only.clear();  // no end in sight: what is left comes to rest at once
    for (const ContactInstant& c : s_.contacts) stage_.inelastic.push_back(c.point);
    if (!add(solve_impact(model_, x, stage_), x, whole)) return whole;
    return finish(std::move(whole));
  }

  bool tied() const { return tied_; }

 private:
  struct Pair {
    int a, b;
    double approach;  // the fastest of its points [m/s]
    std::vector<int> points;
  };

  /// Before the first stage: all that touches, without impulses.
  Impact at_rest() const {
    Impact whole;
    whole.nu = x_.nu;
    whole.stages = 0;
    whole.residual = 0;
    whole.joint_reactions.setZero(static_cast<Eigen::Index>(s_.joint_rows.size()));
    for (const ContactInstant& c : s_.contacts)
      if (c.psi_n <= stage_.small_gap)
        whole.contacts.push_back({.contact = c.contact, .point = c.point, .approach = c.velocity(x_.nu).x()});
    return whole;
  }

  /// The points of the pair, or the pairs, that approach fastest at nu; none if nothing approaches.
  std::vector<int> next(const Vector& nu, Ties ties) {
    constexpr double alike = 1e-9;  // of the approach: what two computations of one speed may differ by
    std::vector<Pair> pairs;
    for (const ContactInstant& c : s_.contacts) {
      if (c.psi_n > stage_.small_gap) continue;
      const double approach = -c.velocity(nu).x();
      auto pair = std::find_if(pairs.begin(), pairs.end(),
                               [&](const Pair& p) { return p.a == c.W.a && p.b == c.W.b; });
      if (pair == pairs.end()) pair = pairs.insert(pairs.end(), Pair{c.W.a, c.W.b, approach, {}});
      pair->approach = std::max(pair->approach, approach);
      pair->points.push_back(c.point);
    }
    double fastest = speed_;
    for (const Pair& p : pairs) fastest = std::max(fastest, p.approach);
    std::erase_if(pairs,
                  [&](const Pair& p) { return p.approach <= speed_ || p.approach < fastest * (1 - alike); });
    if (pairs.size() > 1) tied_ = true;
    if (ties == Ties::First && pairs.size() > 1) pairs.resize(1);
    if (ties == Ties::Last && pairs.size() > 1) pairs.erase(pairs.begin(), pairs.end() - 1);
    std::vector<int> points;
    for (const Pair& p : pairs) points.insert(points.end(), p.points.begin(), p.points.end());
    return points;
  }

  /// Adds a stage; false, and `whole` is as before the impact, if it has no answer.
  bool add(const Impact& stage, State& x, Impact& whole) const {
    if (!stage.solved) {
      whole.solved = false;
      whole.nu = x_.nu;
      return false;
    }
    x.nu = stage.nu;
    whole.energy += stage.energy;
    whole.residual = std::max(whole.residual, stage.residual);
    whole.joint_reactions += stage.joint_reactions;
    for (const ImpactContact& c : stage.contacts) {
      if (!(c.p_n > 0)) continue;
      ImpactContact& sum = *std::find_if(whole.contacts.begin(), whole.contacts.end(),
                                         [&](const ImpactContact& one) { return one.point == c.point; });
      sum.impulse += c.impulse;
      sum.moment += c.moment;
      sum.p_n += c.p_n;
      sum.friction += c.friction;
      sum.mode = c.mode;
    }
    whole.nu = stage.nu;
    return true;
  }

  Impact finish(Impact whole) const {
    whole.solved = true;
    for (ImpactContact& c : whole.contacts)
      c.rebound = s_.contacts[at(s_.contact_of_point[at(c.point)])].velocity(whole.nu).x();
    return whole;
  }

  static constexpr int most_ = 10'000;  // stages
  const Model& model_;
  const State& x_;
  ImpactOptions stage_;  // of one stage
  Instant s_;
  double speed_ = 0;  // below which nothing approaches [m/s]
  bool tied_ = false;
};

}  // namespace

Impact solve_in_sequence(const Model& model, const State& x, const ImpactOptions& options) {
  Sequence sequence(model, x, options);
  Impact impact = sequence.solve(Sequence::Ties::Together);
  // what only a joint jerks has no contact to begin with
  if (impact.solved && impact.stages == 0) {
    ImpactOptions once = options;
    once.order = ImpactOrder::Simultaneous;
    return solve_impact(model, x, once);
  }
  if (!impact.solved || !sequence.tied()) return impact;
  constexpr double same = 1e-8;  // of the largest speed: above what stages of rounding add up to
  for (const Sequence::Ties ties : {Sequence::Ties::First, Sequence::Ties::Last}) {
    const Impact other = Sequence(model, x, options).solve(ties);
    const double largest = std::max(x.nu.lpNorm<Eigen::Infinity>(), impact.nu.lpNorm<Eigen::Infinity>());
    if (!other.solved || (other.nu - impact.nu).lpNorm<Eigen::Infinity>() > same * largest)
      impact.ambiguous = true;
  }
  return impact;
}

}  // namespace perp
