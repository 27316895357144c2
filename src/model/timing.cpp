#include "perp/model/timing.hpp"

namespace perp {

double Timing::first(double t, double until, double look) const {
  double soonest = next ? next(t, until, look) : infinity;
  for (const double time : times)
    if (time > t && time < until && time < soonest) soonest = time;
  return soonest;
}

}  // namespace perp
