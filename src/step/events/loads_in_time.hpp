// What a run must look at between the states that its integrator chooses: loads and motions that depend on time.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "perp/model/model.hpp"
#include "perp/model/timing.hpp"

namespace perp {

/// The loads of a model that may change with time by themselves: forces, motors, motions of bodies and joints, generalized forces.
/// Those that are steady are not in it, so that a model without loads in t costs nothing. It refers to the model.
class LoadsInTime {
 public:
  explicit LoadsInTime(const Model& model);

  bool empty() const { return loads_.empty(); }
  bool all_named() const;  ///< all say when they jump

  struct Jump {
    double t = infinity;
    std::string name;  ///< of the body or joint
  };
  /// The first named time in (t, until).
  Jump next(double t, double until, double look) const;

  /// The latest time up to which what the loads do between a and b is what a polynomial through nine of their values there says;
  /// b.t, or the last time looked at, every `look` or more closely, before they do what would change velocities by `small` [m/s]
  /// and rates by `small_rate` [rad/s]. `at` gives the state at a time between.
  double seen_until(const Model& model, double from, double to, double look, double small, double small_rate,
                    const std::function<State(double t)>& at) const;

  struct Switch {
    std::function<double(const Model&, const State&)> value;
    std::string name;
  };
  const std::vector<Switch>& switches() const { return switches_; }

 private:
  /// What a load is at a state, as accelerations, or of motions as velocities.
  using Value = std::function<void(const Model&, const State&, std::vector<double>&)>;
  struct Load {
    std::string name;
    const Timing* timing = nullptr;  // the model's; null: it says nothing of its times
    Value value;
    std::vector<char> turns, is_rate;  // of each entry of value: in rad; a velocity already
  };
  void add(Load load);
  void add_motions(const Model& model);
  void add_efforts(const Model& model);

  std::vector<Load> loads_;
  std::vector<Switch> switches_;
};

}  // namespace perp
