#include "model/shapes/hull.hpp"

#include <algorithm>
#include <cmath>
#include <map>

#include "core/index.hpp"
#include "perp/core/errors.hpp"

#ifdef PERP_HAS_QHULL
#include <libqhull_r/libqhull_r.h>
#include <cstdio>
#endif

namespace perp {
namespace {

#ifdef PERP_HAS_QHULL
/// Qhull's memory.
struct Qhull {
  qhT state{};
  Qhull() { qh_zero(&state, nullptr); }
  ~Qhull() {
    int current = 0, total = 0;
    state.NOerrexit = True;
    qh_freeqhull(&state, !qh_ALL);
    qh_memfreeshort(&state, &current, &total);
  }
  Qhull(const Qhull&) = delete;
  Qhull& operator=(const Qhull&) = delete;
};

/// Counter-clockwise about the normal.
std::vector<int> loop_of(std::vector<int> corners, const std::vector<Vector3>& points,
                         const Vector3& normal) {
  Vector3 centre = Vector3::Zero();
  for (const int i : corners) centre += points[at(i)] / static_cast<double>(corners.size());
  const Vector3 x = (points[at(corners[0])] - centre).normalized(), y = normal.cross(x);
  std::sort(corners.begin(), corners.end(), [&](int i, int j) {
    const Vector3 p = points[at(i)] - centre, q = points[at(j)] - centre;
    return std::atan2(p.dot(y), p.dot(x)) < std::atan2(q.dot(y), q.dot(x));
  });
  return corners;
}

Hull by_qhull(const char* where, const std::vector<Vector3>& points) {
  std::vector<double> numbers;
  for (const Vector3& x : points) numbers.insert(numbers.end(), x.begin(), x.end());
  Qhull qhull;
  qhT* qh = &qhull.state;
  char command[] = "qhull";
  std::FILE* nowhere = std::fopen("/dev/null", "w");
  const int status =
      qh_new_qhull(qh, 3, static_cast<int>(points.size()), numbers.data(), False, command, nowhere, nowhere);
  if (nowhere != nullptr) std::fclose(nowhere);
  if (status != 0) refuse(where, "vertices", "flat", "need to span a solid");
  std::vector<std::vector<int>> loops;
  std::map<int, int> number;  // of a point that is a corner
  for (const facetT* facet = qh->facet_list; facet != nullptr && facet->next != nullptr;
       facet = facet->next) {
    std::vector<int> corners;
    vertexT *vertex = nullptr, **vertexp = nullptr;
    FOREACHvertex_(facet->vertices) corners.push_back(qh_pointid(qh, vertex->point));
    loops.push_back(loop_of(corners, points, Vector3(facet->normal[0], facet->normal[1], facet->normal[2])));
    for (const int i : loops.back()) number.emplace(i, 0);
  }
  // in the order of the points given, each face from its first corner on: the hull of a hull is itself, number by number
  Hull hull;
  for (auto& [point, place] : number) {
    place = static_cast<int>(hull.vertices.size());
    hull.vertices.push_back(points[at(point)]);
  }
  for (std::vector<int>& loop : loops) {
    for (int& i : loop) i = number.at(i);
    std::rotate(loop.begin(), std::min_element(loop.begin(), loop.end()), loop.end());
  }
  std::sort(loops.begin(), loops.end());
  hull.faces = std::move(loops);
  return hull;
}
#endif

}  // namespace

Hull convex_hull(const char* where, const std::vector<Vector3>& points) {
  if (points.size() < 4)
    refuse(where, "vertices", std::to_string(points.size()) + " points", "need at least four");
  for (const Vector3& x : points)
    if (!x.allFinite()) refuse(where, "vertices", "not finite", "need finite coordinates [m]");
#ifdef PERP_HAS_QHULL
  return by_qhull(where, points);
#else
  refuse(where, "vertices", std::to_string(points.size()) + " points",
         "their hull needs Qhull, which this build lacks");
#endif
}

}  // namespace perp
