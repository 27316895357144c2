#include "step/polygonal_sharing.hpp"

#include <algorithm>
#include <cmath>

namespace perp {
namespace {

std::size_t at(int i) { return static_cast<std::size_t>(i); }

constexpr double at_rest =
    1e-9;  // of the velocities that enter: less is rounding of impulses as large as they need be [-]
constexpr double misfit = 1e-11;  // of them, by which a limit may miss the complementarity of its modes [-]
constexpr double slight = 1e-6;  // of what impulses do to their own rows: the compliance that tells modes [-]

}  // namespace

double PolygonalSharing::gap(std::size_t contact) const {
  return terms_->gap_term[island_->contacts[contact]];
}

PolygonalSharing::Place& PolygonalSharing::place_of(std::size_t group) {
  const int normal = lcp_->groups_[group].normal;
  return normal >= 0 ? contacts_[at(normal)] : frictions_[group - (lcp_->groups_.size() - frictions_.size())];
}

/// Component of x, over the rows of ReducedSystem, along a vertex of friction.
double PolygonalSharing::along(int column, const Vector& x) const {
  const PolygonalLcp::Column& d = lcp_->columns_[at(column)];
  return d.c0 * x[d.row] + (d.rows == 2 ? d.c1 * x[d.row + 1] : 0);
}

bool PolygonalSharing::share(const Model& model, const ReducedSystem& reduced, const Instant& instant,
                             const Island& island, const PolygonalTerms& terms, const PolygonalLcp& polygonal,
                             Vector& z, Vector& r) {
  reduced_ = &reduced, instant_ = &instant, island_ = &island, terms_ = &terms, lcp_ = &polygonal;
  contacts_.resize(island.contacts.size());
  frictions_.resize(island.joint_frictions.size());
  q_ = reduced.q;
  for (std::size_t i = 0; i < contacts_.size(); ++i) q_[reduced.rows_of(static_cast<int>(i))] += gap(i);
  u_.noalias() = reduced.W * r;
  u_ += q_;
  r_ = r;
  small_ = q_.cwiseAbs().maxCoeff();
  reduced.compliance(model, instant, island, C_, k_);

  modes_by_velocity();
  if (solve() && fits()) {
    if (limit_.redundancy() == 0) return false;  // the vertex is the only answer in these modes
  } else {
    // what is closed at rest; friction that this asks too much of gives way
    for (Place& place : contacts_)
      if (place.mode != Mode::Open) place = {.mode = Mode::Rest};
    for (Place& place : frictions_) place = {.mode = Mode::Rest};
    if (!settle() && !(soften() && settle())) return false;
  }
  r = r_;
  polygonal.read_solution(r, u_, z);
  return true;
}

/// Solves, and mends modes that the limit does not fit.
bool PolygonalSharing::settle() {
  constexpr int most_rounds = 12;
  for (int round = 0; round < most_rounds; ++round) {
    if (!solve()) return false;
    if (fits()) return true;
    mend();
  }
  return false;
}

/// Modes of the LCP whose rows give.
bool PolygonalSharing::soften() {
  const double give = slight * std::exp((reduced_->diagonal.array() / C_.diagonal().array()).log().mean());
  soft_ = *reduced_;
  soft_.W += give * C_;
  soft_.q += give * k_;
  soft_lcp_.assemble(soft_, *instant_, *island_, *terms_, true);
  lemke_.solve(soft_lcp_.lcp().A, soft_lcp_.lcp().b, solution_);
  if (!solution_.solved() && solution_.status != LcpStatus::Inaccurate) return false;  // near to singular
  modes_by_solution(solution_.z);
  return true;
}

/// What is closed, slides and rests by the velocities u_.
void PolygonalSharing::modes_by_velocity() {
  const double small = at_rest * small_;
  const int columns = static_cast<int>(lcp_->columns_.size());
  int j = static_cast<int>(contacts_.size());
  for (std::size_t i = 0; i < contacts_.size(); ++i)
    contacts_[i] = {.mode = u_[lcp_->columns_[i].row] <= small ? Mode::Rest : Mode::Open};
  for (Place& f : frictions_) f = {.mode = Mode::Rest};
  for (std::size_t g = 0; g < lcp_->groups_.size(); ++g) {
    const int first = j;
    double sigma = 0;
    for (; j < columns && lcp_->columns_[at(j)].group == static_cast<int>(g); ++j)
      sigma = std::max(sigma, -along(j, u_));
    Place& place = place_of(g);
    if (place.mode == Mode::Open || sigma <= small) continue;
    place.mode = Mode::Slide;
    for (int i = first; i < j; ++i)
      if (sigma + along(i, u_) <= small) (place.first < 0 ? place.first : place.second) = i;
  }
}

/// The same by what is positive in the solution z of the LCP whose rows give.
void PolygonalSharing::modes_by_solution(const Vector& z) {
  const double zero = 1e-3 * slight * z.cwiseAbs().maxCoeff();
  const int columns = static_cast<int>(lcp_->columns_.size());
  int j = static_cast<int>(contacts_.size());
  for (std::size_t i = 0; i < contacts_.size(); ++i)
    contacts_[i] = {.mode = z[static_cast<int>(i)] > zero ? Mode::Rest : Mode::Open};
  for (Place& f : frictions_) f = {.mode = Mode::Rest};
  for (std::size_t g = 0; g < lcp_->groups_.size(); ++g) {
    Place& place = place_of(g);
    const bool slides = place.mode != Mode::Open && z[columns + static_cast<int>(g)] > zero;
    if (slides) place.mode = Mode::Slide;
    for (; j < columns && lcp_->columns_[at(j)].group == static_cast<int>(g); ++j)
      if (slides && z[j] > zero) (place.first < 0 ? place.first : place.second) = j;
    if (slides && place.first < 0) place.mode = Mode::Rest;
  }
}

/// The unknowns of the modes, and the rows that they tie.
void PolygonalSharing::tie() {
  tied_.clear();
  known_.setZero(reduced_->size());
  const auto vector = [&](int column) {
    const PolygonalLcp::Column& d = lcp_->columns_[at(column)];
    return d.rows == 2 ? Vector3(0, d.c0, d.c1) : Vector3(0, d.c0, 0);
  };
  for (std::size_t i = 0; i < contacts_.size(); ++i) {
    const Place& place = contacts_[i];
    const ContactInstant& c = instant_->contacts[at(island_->contacts[i])];
    if (place.mode == Mode::Open) continue;
    Tied normal{.row = reduced_->rows_of(static_cast<int>(i)), .rows = 1 + c.tangents};
    normal.acts = normal.on = Vector3::UnitX();
    if (place.mode == Mode::Slide) normal.acts += c.mu * vector(place.first);
    tied_.push_back(normal);
    Tied friction = normal;
    if (place.mode == Mode::Rest)
      for (int t = 1; t <= c.tangents; ++t) {
        friction.acts = friction.on = Vector3::Unit(t);
        tied_.push_back(friction);
      }
    if (place.second >= 0) {
      friction.acts = friction.on = vector(place.second) - vector(place.first);
      tied_.push_back(friction);
    }
  }
  for (std::size_t i = 0; i < frictions_.size(); ++i) {
    const int row = reduced_->friction_row(static_cast<int>(i));
    if (frictions_[i].mode == Mode::Slide) {
      const PolygonalLcp::Column& d = lcp_->columns_[at(frictions_[i].first)];
      known_[row] = d.c0 * lcp_->groups_[at(d.group)].bound;
    } else {
      Tied one{.row = row, .rows = 1};
      one.acts = one.on = Vector3::UnitX();
      tied_.push_back(one);
    }
  }
}

/// r_ and u_ of the limit in the modes; false if there is none, or more than one.
bool PolygonalSharing::solve() {
  tie();
  const auto n = static_cast<Eigen::Index>(tied_.size());
  const Matrix& W = reduced_->W;
  A_.resize(n, n);
  C_tied_.resize(n, n);
  b_.resize(n), k_tied_.resize(n), scale_.resize(n);
  for (Eigen::Index i = 0; i < n; ++i) {
    const Tied& row = tied_[static_cast<std::size_t>(i)];
    const auto on = row.on.head(row.rows);
    for (Eigen::Index j = 0; j < n; ++j) {
      const Tied& column = tied_[static_cast<std::size_t>(j)];
      const auto acts = column.acts.head(column.rows);
      double w = 0, c = 0;
      for (int s = 0; s < column.rows; ++s) {
        if (acts[s] == 0) continue;
        for (int t = 0; t < row.rows; ++t) {
          w += on[t] * acts[s] * W(row.row + t, column.row + s);
          c += on[t] * acts[s] * C_(row.row + t, column.row + s);
        }
      }
      A_(i, j) = w;
      C_tied_(i, j) = c;
    }
    b_[i] = on.dot(q_.segment(row.row, row.rows));
    k_tied_[i] = on.dot(k_.segment(row.row, row.rows));
    for (std::size_t f = 0; f < frictions_.size(); ++f) {
      const int known = reduced_->friction_row(static_cast<int>(f));
      if (known_[known] == 0) continue;
      b_[i] += known_[known] * on.dot(W.col(known).segment(row.row, row.rows));
      k_tied_[i] += known_[known] * on.dot(C_.col(known).segment(row.row, row.rows));
    }
    scale_[i] = std::sqrt(reduced_->diagonal[row.row]);
  }
  using Outcome = VanishingCompliance::Outcome;
  const Outcome outcome = limit_.solve(A_, b_, C_tied_, k_tied_, scale_, y_);
  if (outcome == Outcome::None || outcome == Outcome::Several) return false;
  r_ = known_;
  for (Eigen::Index i = 0; i < n; ++i) {
    const Tied& t = tied_[static_cast<std::size_t>(i)];
    r_.segment(t.row, t.rows) += y_[i] * t.acts.head(t.rows);
  }
  u_.noalias() = W * r_;
  u_ += q_;
  // of rows that give, to first order in what they give: tells where velocities are zero
  limit_.first_order(C_tied_, k_tied_, scale_, y_, y_1_);
  r_1_.setZero(r_.size());
  for (Eigen::Index i = 0; i < n; ++i) {
    const Tied& t = tied_[static_cast<std::size_t>(i)];
    r_1_.segment(t.row, t.rows) += y_1_[i] * t.acts.head(t.rows);
  }
  u_1_.noalias() = C_ * r_;
  u_1_ += k_;
  small_1_ = u_1_.cwiseAbs().maxCoeff();
  u_1_.noalias() += W * r_1_;
  return true;
}

/// Whether a velocity v is negative, or zero and negative to first order.
bool PolygonalSharing::negative(double v, double v_1) const {
  constexpr double first = 1e-8;  // of what rows give
  const double zero = misfit * small_;
  return v < -zero || (v <= zero && v_1 < -first * small_1_);
}

/// The vertex of a group that opposes the velocity most.
int PolygonalSharing::fastest(int first, int end) const {
  int best = first;
  for (int i = first; i < end; ++i)
    if (negative(along(i, u_) - along(best, u_), along(i, u_1_) - along(best, u_1_))) best = i;
  return best;
}

/// Modes as the limit in them says.
void PolygonalSharing::mend() {
  const int columns = static_cast<int>(lcp_->columns_.size());
  int j = static_cast<int>(contacts_.size());
  for (std::size_t g = 0; g < lcp_->groups_.size(); ++g) {
    const PolygonalLcp::Group& group = lcp_->groups_[g];
    const int first = j;
    int pushed = j;  // the vertex nearest to the impulse
    for (; j < columns && lcp_->columns_[at(j)].group == static_cast<int>(g); ++j)
      if (along(j, r_) > along(pushed, r_)) pushed = j;
    Place& place = place_of(g);
    const double bound =
        group.normal >= 0 ? group.mu * r_[lcp_->columns_[at(group.normal)].row] : group.bound;
    if (place.mode == Mode::Rest && bound >= 0 && along(pushed, r_) > bound) {
      place = {.mode = Mode::Slide, .first = pushed};
    } else if (place.mode == Mode::Slide) {
      const int now = fastest(first, j);
      if (negative(-along(place.first, u_), -along(place.first, u_1_)))  // it would go with its friction
        place = {.mode = Mode::Rest};
      else if (place.second >= 0)
        place = {.mode = Mode::Slide, .first = pushed};
      else if (now != place.first)
        place = {.mode = Mode::Slide,
                 .first = now,
                 .second = now == place.last ? place.first : -1,
                 .last = place.first};
    }
  }
  for (std::size_t i = 0; i < contacts_.size(); ++i) {
    const int row = lcp_->columns_[i].row;
    if (contacts_[i].mode != Mode::Open && reduced_->diagonal[row] * r_[row] < -misfit * small_)
      contacts_[i] = {};
    else if (contacts_[i].mode == Mode::Open && negative(u_[row], u_1_[row]))
      contacts_[i] = {.mode = Mode::Rest};
  }
}

/// Whether the limit keeps to the complementarity of its modes; what it misses by rounding is cut off.
bool PolygonalSharing::fits() {
  const double velocity = misfit * small_;
  const int columns = static_cast<int>(lcp_->columns_.size());
  for (std::size_t i = 0; i < contacts_.size(); ++i) {
    const int row = lcp_->columns_[i].row;
    if (contacts_[i].mode == Mode::Open ? negative(u_[row], u_1_[row])
                                        : reduced_->diagonal[row] * r_[row] < -velocity)
      return false;
  }
  int j = static_cast<int>(contacts_.size());
  for (std::size_t g = 0; g < lcp_->groups_.size(); ++g) {
    const PolygonalLcp::Group& group = lcp_->groups_[g];
    const int first = j;
    while (j < columns && lcp_->columns_[at(j)].group == static_cast<int>(g)) ++j;
    const Place& place = place_of(g);
    if (place.mode == Mode::Open) continue;
    if (place.mode == Mode::Slide) {  // against the vertex that opposes it most
      if (negative(-along(place.first, u_), -along(place.first, u_1_))) return false;
      const int now = fastest(first, j);
      if (now != place.first && now != place.second) return false;
      if (place.second < 0) continue;
    }
    // inside the polygon
    const double bound =
        group.normal >= 0 ? group.mu * r_[lcp_->columns_[at(group.normal)].row] : group.bound;
    const bool plane = lcp_->columns_[at(first)].rows == 2;
    const double wide = plane ? std::cos(std::acos(-1.0) / (j - first)) : 1;  // of an edge from the middle
    for (int i = first; i < j; ++i) {
      const double p =
          plane ? (along(i, r_) + along(i + 1 < j ? i + 1 : first, r_)) / (2 * wide) : along(i, r_);
      if (p > bound * wide + velocity / group.diagonal) return false;
    }
  }
  for (std::size_t i = 0; i < contacts_.size(); ++i) {
    const int row = lcp_->columns_[i].row;
    if (r_[row] < 0) r_.segment(row, 1 + instant_->contacts[at(island_->contacts[i])].tangents).setZero();
  }
  return true;
}

}  // namespace perp
