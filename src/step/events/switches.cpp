#include "step/events/switches.hpp"

#include <algorithm>
#include <cmath>

#include "step/events/event_watch.hpp"

namespace perp {

Switches::Switches(const LoadsInTime& loads, const std::vector<UserEvent>& events) : events_(events) {
  for (const LoadsInTime::Switch& s : loads.switches()) all_.push_back({.when = s.value, .name = s.name});
  for (std::size_t i = 0; i < events.size(); ++i)
    all_.push_back({.when = events[i].when, .name = events[i].name, .event = i});
}

void Switches::measure(const Model& model, const State& x, const Scales& scales, double vague) {
  for (Switch& s : all_) {
    const double now = s.when(model, x);
    if (s.scale == 0 && s.event != none) s.scale = variation(events_[s.event], model, x, scales);
    if (std::isfinite(now)) s.scale = std::max(s.scale, std::abs(now));
    if (s.sign != 0) continue;
    if (s.event == none || std::abs(now) > vague * s.scale) s.sign = now < 0 ? -1 : 1;
  }
}

}  // namespace perp
