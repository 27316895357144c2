#include "view/keyframes.hpp"

#include <algorithm>
#include <cmath>

#include "core/index.hpp"

namespace perp {
namespace {

using Vector4 = Eigen::Vector4d;

template <class V>
V hermite(const V& y_0, const V& d_0, const V& y_1, const V& d_1, double s, double h) {
  const double s2 = s * s, s3 = s2 * s;
  return (2 * s3 - 3 * s2 + 1) * y_0 + (s3 - 2 * s2 + s) * h * d_0 + (3 * s2 - 2 * s3) * y_1 +
         (s3 - s2) * h * d_1;
}

/// q' = (0, w) q/2, w in world axes.
Vector4 rate(const Quaternion& q, const Vector3& w) {
  return 0.5 * (Quaternion(0, w.x(), w.y(), w.z()) * q).coeffs();
}

struct Miss {
  double position = 0, turning = 0;
};

Miss miss_at(const std::vector<double>& t, const std::vector<Moment>& m, int i, int j, int row) {
  const Pose X = between(t[at(i)], m[at(i)], t[at(j)], m[at(j)], t[at(row)]);
  return {(X.p - m[at(row)].X.p).norm(), rotation_vector(X.q.conjugate() * m[at(row)].X.q).norm()};
}

}  // namespace

Pose between(double t_0, const Moment& m_0, double t_1, const Moment& m_1, double t) {
  const double h = t_1 - t_0;
  if (!(h > 0)) return t < t_1 ? m_0.X : m_1.X;
  const double s = (t - t_0) / h;
  Quaternion q_1 = m_1.X.q;
  if (m_0.X.q.dot(q_1) < 0) q_1.coeffs() = -q_1.coeffs();
  Quaternion q;
  q.coeffs() =
      hermite<Vector4>(m_0.X.q.coeffs(), rate(m_0.X.q, m_0.V.w), q_1.coeffs(), rate(q_1, m_1.V.w), s, h);
  return {hermite(m_0.X.p, m_0.V.v, m_1.X.p, m_1.V.v, s, h), q.normalized()};
}

Keyframes thinned(const std::vector<double>& t, const std::vector<Moment>& moments, double position,
                  double turning) {
  Keyframes keys;
  const int n = static_cast<int>(t.size());
  keys.rows.push_back(0);
  // whether all rows between i and j are met; `worst` is what they miss by
  const auto good = [&](int i, int j, Miss& worst) {
    worst = {};
    if (t[at(i)] == t[at(j)]) return j == i + 1;
    for (int row = i + 1; row < j; ++row) {
      if (t[at(row)] == t[at(i)] || t[at(row)] == t[at(j)]) return false;
      const Miss miss = miss_at(t, moments, i, j, row);
      if (!(miss.position <= position && miss.turning <= turning)) return false;
      worst = {std::max(worst.position, miss.position), std::max(worst.turning, miss.turning)};
    }
    return true;
  };
  for (int i = 0; i < n - 1;) {
    int reached = i + 1, reach = 1;
    Miss worst, miss;
    for (; i + 2 * reach < n && good(i, i + 2 * reach, miss); reach *= 2)
      reached = i + 2 * reach, worst = miss;
    for (int step = reach / 2; step >= 1; step /= 2)
      if (reached + step < n && good(i, reached + step, miss)) reached += step, worst = miss;
    keys.rows.push_back(reached);
    keys.position_error = std::max(keys.position_error, worst.position);
    keys.turning_error = std::max(keys.turning_error, worst.turning);
    i = reached;
  }
  return keys;
}

}  // namespace perp
