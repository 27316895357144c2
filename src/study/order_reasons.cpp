// Why a method shows another order than theory gives it, in words.
#include <algorithm>
#include <cmath>
#include <cstdio>

#include "perp/study/convergence.hpp"

namespace perp {
namespace {

constexpr double agrees = 0.1;  // an observed order this close to the expected one
constexpr double jumps = 0.5;   // local slopes further apart than this do not come of smooth errors
constexpr double flat = 0.5;    // of the expected order: a local slope below that is no longer falling

std::string text(const char* pattern, double a, double b = 0) {
  char result[160];
  std::snprintf(result, sizeof result, pattern, a, b);
  return result;
}

bool has(const std::string& note, const char* words) { return note.find(words) != std::string::npos; }

}  // namespace

std::string why_not_expected(const OrderRow& row, const std::vector<const StudyRun*>& runs) {
  const ObservedOrder& q = row.q;
  std::string why;
  const auto add = [&](const std::string& more) { why += (why.empty() ? "" : "; ") + more; };
  if (std::isnan(row.expected)) {
    if (row.reference != OrderReference::Limit && !row.parameter.empty())
      add("friction turns, and a polygon (" + row.parameter +
          ") has a motion of its own: its order is that against its limit");
    return why;
  }
  if (q.known() && std::abs(q.order - row.expected) <= agrees) return why;

  int switches = 0;
  for (const StudyRun* run : runs) switches = std::max(switches, run->switches);
  const auto range = std::minmax_element(q.local.begin(), q.local.end());
  const bool jump = q.local.size() > 1 && *range.second - *range.first > jumps;
  if (has(q.note, "exact to round-off")) add("the method makes no error here");
  if (q.floor == q.floor) add(text("floor: smaller steps do not help below %.2g", q.floor));
  if (has(q.note, "at round-off"))
    add("round-off: the smallest errors are what the steps' rounding adds up to");
  if (has(q.note, "reference's bar")) add("reference's bar: smaller errors than that are not known");
  if (has(q.note, "without an answer")) add("runs that failed leave fewer points");
  if (has(q.note, "too few points") && why.empty())
    add("too few steps: three over a factor of 4 show an order");
  if (!q.known()) return why;

  if (jump && switches > 0)
    add(text("events within h: modes change up to %.0f times in a run, and the error goes with the fraction "
             "of a step "
             "at which they do",
             switches) +
        text(" (local slopes %.2f to %.2f): --envelope 16 evens that out", *range.first, *range.second));
  else if (!q.local.empty() && std::abs(q.local.back() - row.expected) <= agrees)
    add(text("the largest steps are too large: the slope of the smallest is %.2f", q.local.back()));
  else if (!q.local.empty() && q.local.back() < flat * row.expected && q.local.front() > q.local.back())
    add(text("a floor comes near: local slopes fall from %.2f to %.2f", q.local.front(), q.local.back()));
  else if (switches > 0)
    add(text("events within h: modes change up to %.0f times in a run", switches) +
        (q.order > row.expected ? ", and the motion after the last forgets part of the error" : ""));
  else if (why.empty())
    add(q.order > row.expected ? "the leading term of the error is small on this motion"
                               : "no event, floor, polygon, round-off or bar explains it");
  return why;
}

}  // namespace perp
