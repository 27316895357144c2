#include "perp/step/polygonal_lcp.hpp"

#include <algorithm>
#include <cmath>

#include "core/index.hpp"

namespace perp {
namespace {

/// The part of x along a column.
double along_column(const PolygonalLcp::Column& c, const Vector& x) {
  double sum = c.c0 * x[c.row];
  if (c.rows > 1) sum += c.c1 * x[c.row + 1];
  if (c.rows > 2) sum += c.c2 * x[c.row + 2];
  return sum;
}

/// a^T W b.
double between(const PolygonalLcp::Column& a, const Matrix& W, const PolygonalLcp::Column& b) {
  const double of_a[] = {a.c0, a.c1, a.c2}, of_b[] = {b.c0, b.c1, b.c2};
  double sum = 0;
  for (int i = 0; i < a.rows; ++i)
    for (int j = 0; j < b.rows; ++j) sum += of_a[i] * of_b[j] * W(a.row + i, b.row + j);
  return sum;
}

}  // namespace

void PolygonalLcp::assemble(const ReducedSystem& reduced, const Instant& instant, const Island& island,
                            const PolygonalTerms& terms, bool scaled) {
  list_unknowns(reduced, instant, island, terms, scaled);
  fill(reduced, island, terms);
}

void PolygonalLcp::list_unknowns(const ReducedSystem& reduced, const Instant& instant, const Island& island,
                                 const PolygonalTerms& terms, bool scaled) {
  const int contacts = static_cast<int>(island.contacts.size());
  const int frictions = static_cast<int>(island.joint_frictions.size());
  const auto contact = [&](int i) -> const ContactInstant& {
    return instant.contacts[at(island.contacts[at(i)])];
  };
  const auto unit = [&](int row) { return scaled ? 1 / std::sqrt(reduced.diagonal[row]) : 1.0; };
  columns_.clear();
  groups_.clear();

  // the unknowns, in the seed's order: p_n, beta_u, beta_b, sigma_u, sigma_b
  for (int i = 0; i < contacts; ++i) {
    const int row = reduced.rows_of(i);
    columns_.push_back({.row = row, .scale = unit(row)});
  }
  group_of_contact_.assign(at(contacts), -1);
  for (int i = 0; i < contacts; ++i) {
    const int row = reduced.rows_of(i), group = static_cast<int>(groups_.size());
    const double s = unit(row);
    if (const MomentInstant* m = instant.moments_of(contact(i)); m != nullptr) {
      if (m->has_sliding(contact(i).mu)) group_of_contact_[at(i)] = group;
      add_moments(contact(i), *m, i, row, reduced.diagonal[row], terms);
      for (std::size_t g = at(group); g < groups_.size(); ++g) groups_[g].scale = 1 / s;
      for (Column& column : columns_)
        if (column.group >= group) column.scale = s;
      continue;
    }
    if (contact(i).tangents == 0) continue;
    group_of_contact_[at(i)] = group;
    groups_.push_back({.normal = i, .mu = contact(i).mu, .diagonal = reduced.diagonal[row], .scale = 1 / s});
    if (contact(i).tangents == 1) {
      for (const double d : {1.0, -1.0})
        columns_.push_back({.row = row + 1, .c0 = d, .group = group, .scale = s});
    } else {
      for (const Vector2& d : terms.polygon)
        columns_.push_back({.row = row + 1, .rows = 2, .c0 = d.x(), .c1 = d.y(), .group = group, .scale = s});
    }
  }
  for (int i = 0; i < frictions; ++i) {
    const JointRowInstant& joint = instant.joint_frictions[at(island.joint_frictions[at(i)])];
    const int row = reduced.friction_row(i), group = static_cast<int>(groups_.size());
    const double s = unit(row);
    groups_.push_back({.bound = terms.h * joint.friction, .diagonal = reduced.diagonal[row], .scale = 1 / s});
    for (const double d : {1.0, -1.0}) columns_.push_back({.row = row, .c0 = d, .group = group, .scale = s});
  }
}

/// The groups of a contact with moments: what slides and twists, what rolls; rows from `row` on: n, t, o, torsion, rolling.
void PolygonalLcp::add_moments(const ContactInstant& c, const MomentInstant& m, int normal, int row,
                               double diagonal, const PolygonalTerms& terms) {
  const auto begin_group = [&] {
    groups_.push_back({.normal = normal, .mu = 1, .diagonal = diagonal});
    return static_cast<int>(groups_.size()) - 1;
  };
  const int torsion_row = row + 1 + c.tangents;
  const bool twists = m.torsion > 0, in_plane = c.tangents == 2 && (c.mu > 0 || m.mu_o > 0);
  if (twists && in_plane) {
    const int group = begin_group();
    for (const Vector3& d : terms.polytope)
      columns_.push_back({.row = row + 1,
                          .rows = 3,
                          .c0 = c.mu * d.x(),
                          .c1 = m.mu_o * d.y(),
                          .c2 = m.torsion * d.z(),
                          .group = group});
  } else if (twists) {
    const int group = begin_group();
    for (const double d : {m.torsion, -m.torsion})
      columns_.push_back({.row = torsion_row, .c0 = d, .group = group});
  } else if (in_plane) {
    const int group = begin_group();
    for (const Vector2& d : terms.polygon)
      columns_.push_back(
          {.row = row + 1, .rows = 2, .c0 = c.mu * d.x(), .c1 = m.mu_o * d.y(), .group = group});
  } else if (c.tangents == 1 && c.mu > 0) {
    const int group = begin_group();
    for (const double d : {c.mu, -c.mu}) columns_.push_back({.row = row + 1, .c0 = d, .group = group});
  }
  if (!(m.rolling > 0)) return;
  const int rolling_row = torsion_row + (twists ? 1 : 0), group = begin_group();
  if (c.tangents == 1) {
    for (const double d : {m.rolling, -m.rolling})
      columns_.push_back({.row = rolling_row, .c0 = d, .group = group});
    return;
  }
  for (const Vector2& d : terms.polygon)
    columns_.push_back(
        {.row = rolling_row, .rows = 2, .c0 = m.rolling * d.x(), .c1 = m.rolling * d.y(), .group = group});
}

void PolygonalLcp::fill(const ReducedSystem& reduced, const Island& island, const PolygonalTerms& terms) {
  const int n = static_cast<int>(columns_.size()), m = static_cast<int>(groups_.size());
  Matrix& F = lcp_.A;
  Vector& f = lcp_.b;
  F.setZero(n + m, n + m);
  f.setZero(n + m);
  const Matrix& W = reduced.W;
  for (int j = 0; j < n; ++j) {
    const Column& b = columns_[at(j)];
    for (int i = 0; i <= j; ++i) {
      const Column& a = columns_[at(i)];
      F(i, j) = F(j, i) = a.scale * b.scale * between(a, W, b);
    }
    double q = along_column(b, reduced.q);
    if (b.group < 0) q += terms.gap_term[island.contacts[at(j)]];
    f[j] = b.scale * q;
    if (b.group >= 0) {
      F(j, n + b.group) = b.scale * groups_[at(b.group)].scale;  // E
      F(n + b.group, j) = -F(j, n + b.group);                    // -E^T
    }
  }
  for (int g = 0; g < m; ++g) {
    const Group& group = groups_[at(g)];
    if (group.normal >= 0)
      F(n + g, group.normal) = group.mu * group.scale * columns_[at(group.normal)].scale;  // U
    f[n + g] = group.scale * group.bound;
  }
}

void PolygonalLcp::read_impulses(const Vector& z, Vector& r) const {
  r.setZero();
  for (std::size_t j = 0; j < columns_.size(); ++j) {
    const Column& c = columns_[j];
    const double p = c.scale * z[static_cast<int>(j)];
    r[c.row] += c.c0 * p;
    if (c.rows > 1) r[c.row + 1] += c.c1 * p;
    if (c.rows > 2) r[c.row + 2] += c.c2 * p;
  }
}

void PolygonalLcp::read_solution(const Vector& r, const Vector& u, Vector& z) const {
  const int n = static_cast<int>(columns_.size());
  z.setZero(n + static_cast<int>(groups_.size()));
  for (int j = 0, end; j < n; j = end) {
    const int group = columns_[at(j)].group;
    end = j + 1;
    if (group < 0) {
      z[j] = r[columns_[at(j)].row] / columns_[at(j)].scale;
      continue;
    }
    while (end < n && columns_[at(end)].group == group) ++end;
    double sigma = 0, inside = -infinity;
    for (int i = j; i < end; ++i) {
      const Column &d = columns_[at(i)], &e = columns_[at(i + 1 < end ? i + 1 : j)];
      if (d.rows == 1) {
        z[i] = std::max(0.0, d.c0 * r[d.row]) / d.scale;
        sigma = std::max(sigma, -d.c0 * u[d.row]);
        continue;
      }
      sigma = std::max(sigma, -(d.c0 * u[d.row] + d.c1 * u[d.row + 1]));
      // r = a d + b e: both are positive, but for rounding, for the vertices that it lies between
      const double across = d.c0 * e.c1 - d.c1 * e.c0;
      const double a = (r[d.row] * e.c1 - r[d.row + 1] * e.c0) / across;
      const double b = (d.c0 * r[d.row + 1] - d.c1 * r[d.row]) / across;
      if (!(std::min(a, b) > inside)) continue;
      inside = std::min(a, b);
      z.segment(j, end - j).setZero();
      z[i] = std::max(0.0, a) / d.scale;
      z[i + 1 < end ? i + 1 : j] = std::max(0.0, b) / e.scale;
    }
    z[n + group] = sigma / groups_[at(group)].scale;
  }
}

double PolygonalLcp::friction_residual(const Vector& z, const Vector& u, const Vector& length) const {
  const int n = static_cast<int>(columns_.size());
  double worst = 0;
  for (std::size_t g = 0; g < groups_.size(); ++g) {
    const Group& group = groups_[g];
    const double sigma = group.scale * z[n + static_cast<int>(g)];
    double room = group.bound, miss = 0, unit = 1;
    if (group.normal >= 0) room = group.mu * columns_[at(group.normal)].scale * z[group.normal];
    for (std::size_t j = 0; j < columns_.size(); ++j) {
      const Column& c = columns_[j];
      if (c.group != static_cast<int>(g)) continue;
      const double beta = c.scale * z[static_cast<int>(j)];
      const double speed = sigma + along_column(c, u);
      miss = std::max(miss, std::abs(std::min(speed, group.diagonal * beta)));
      unit = length[c.row];
      room -= beta;
    }
    worst = std::max(worst, unit * std::max(miss, std::abs(std::min(sigma, group.diagonal * room))));
  }
  return worst;
}

bool PolygonalLcp::slips(int i, const Vector& z, double speed_scale) const {
  const int group = group_of_contact_[at(i)];
  if (group < 0) return true;
  const double sigma = groups_[at(group)].scale * z[static_cast<int>(columns_.size()) + group];
  return sigma > 1e-10 * speed_scale;
}

}  // namespace perp
