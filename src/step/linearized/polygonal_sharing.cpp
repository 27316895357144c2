#include "step/linearized/polygonal_sharing.hpp"

#include <algorithm>
#include <cmath>

#include "core/index.hpp"

namespace perp {
namespace {

constexpr double at_rest =
    1e-9;  // of the velocities that enter: less is rounding of impulses as large as they need be [-]
constexpr double misfit = 1e-11;  // of them, by which a limit may miss the complementarity of its modes [-]
constexpr double slight = 1e-6;  // of what impulses do to their own rows: the compliance that tells modes [-]

}  // namespace

PolygonalMode& PolygonalSharing::mode_of(std::size_t group) {
  const int normal = problem_->lcp.groups()[group].normal;
  const std::size_t others = problem_->lcp.groups().size() - frictions_.size();
  return normal >= 0 ? contacts_[at(normal)] : frictions_[group - others];
}

const PolygonalMode& PolygonalSharing::mode_of(std::size_t group) const {
  return const_cast<PolygonalSharing*>(this)->mode_of(group);
}

/// Component of x, over the rows of ReducedSystem, along a vertex of friction.
double PolygonalSharing::along(int column, const Vector& x) const {
  const PolygonalLcp::Column& d = problem_->lcp.columns()[at(column)];
  return d.c0 * x[d.row] + (d.rows == 2 ? d.c1 * x[d.row + 1] : 0);
}

double PolygonalSharing::bound_of(std::size_t group) const {
  const PolygonalLcp::Group& g = problem_->lcp.groups()[group];
  return g.normal >= 0 ? g.mu * r_[problem_->lcp.columns()[at(g.normal)].row] : g.bound;
}

void PolygonalSharing::begin(const Problem& problem) {
  problem_ = &problem;
  const ReducedSystem& reduced = problem.reduced;
  q_ = reduced.q;
  for (std::size_t i = 0; i < problem.island.contacts.size(); ++i)
    q_[reduced.rows_of(static_cast<int>(i))] += problem.terms.gap_term[problem.island.contacts[i]];
  small_ = q_.cwiseAbs().maxCoeff();
  reduced.compliance(problem.model, problem.instant, problem.island, C_, k_);
}

bool PolygonalSharing::again(const Problem& problem, const KeptModes& kept, Vector& z, Vector& r) {
  if (kept.points != problem.points || kept.contacts.size() != problem.island.contacts.size() ||
      kept.frictions.size() != problem.island.joint_frictions.size())
    return false;
  begin(problem);
  contacts_ = kept.contacts;
  frictions_ = kept.frictions;
  if (!solve() || !fits()) return false;
  r = r_;
  problem.lcp.read_solution(r, u_, z);
  return true;
}

void PolygonalSharing::share(const Problem& problem, KeptModes& kept, Vector& z, Vector& r) {
  constexpr Eigen::Index few_rows = 120;  // for which a path of Lemke's over softened rows is affordable
  begin(problem);
  make_room();
  kept.points.clear();
  contacts_.resize(problem.island.contacts.size());
  frictions_.resize(problem.island.joint_frictions.size());
  r_ = r;
  u_ = q_;
  u_.noalias() += problem.reduced.W * r;
  modes_by_velocity();
  if (!solve() || !fits()) {
    // what is closed at rest; friction that this asks too much of gives way
    for (PolygonalMode& mode : contacts_)
      if (mode.kind != Kind::Open) mode = {.kind = Kind::Rest};
    for (PolygonalMode& mode : frictions_) mode = {.kind = Kind::Rest};
    if (!settle() && !(q_.size() <= few_rows && soften() && settle())) return;
  }
  r = r_;
  problem.lcp.read_solution(r, u_, z);
  kept.points = problem.points;
  kept.contacts = contacts_;
  kept.frictions = frictions_;
}

/// What softened rows need, at the first step that may: no later one allocates.
void PolygonalSharing::make_room() {
  const Problem& p = *problem_;
  if (soft_.size() == p.reduced.size()) return;
  soft_ = p.reduced;
  soft_lcp_.assemble(soft_, p.instant, p.island, p.terms, true);
  solution_.z.setZero(soft_lcp_.lcp().b.size());
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
  const Problem& p = *problem_;
  const double give = slight * std::exp((p.reduced.diagonal.array() / C_.diagonal().array()).log().mean());
  soft_ = p.reduced;
  soft_.W += give * C_;
  soft_.q += give * k_;
  soft_lcp_.assemble(soft_, p.instant, p.island, p.terms, true);
  p.lemke.solve(soft_lcp_.lcp().A, soft_lcp_.lcp().b, solution_);
  if (!solution_.solved() && solution_.status != LcpStatus::Inaccurate) return false;  // near to singular
  modes_by_solution(solution_.z);
  return true;
}

/// What is closed, slides and rests by the velocities u_.
void PolygonalSharing::modes_by_velocity() {
  const double small = at_rest * small_;
  const auto& columns = problem_->lcp.columns();
  for (std::size_t i = 0; i < contacts_.size(); ++i)
    contacts_[i] = {.kind = u_[columns[i].row] <= small ? Kind::Rest : Kind::Open};
  for (PolygonalMode& friction : frictions_) friction = {.kind = Kind::Rest};
  std::size_t j = contacts_.size();
  for (std::size_t g = 0; g < problem_->lcp.groups().size(); ++g) {
    const auto first = static_cast<int>(j);
    double sigma = 0;
    for (; j < columns.size() && columns[j].group == static_cast<int>(g); ++j)
      sigma = std::max(sigma, -along(static_cast<int>(j), u_));
    PolygonalMode& mode = mode_of(g);
    if (mode.kind == Kind::Open || sigma <= small) continue;
    mode.kind = Kind::Slide;
    for (int i = first; i < static_cast<int>(j); ++i)
      if (sigma + along(i, u_) <= small) (mode.first < 0 ? mode.first : mode.second) = i;
  }
}

/// The same by what is positive in the solution z of the LCP whose rows give.
void PolygonalSharing::modes_by_solution(const Vector& z) {
  const double zero = 1e-3 * slight * z.cwiseAbs().maxCoeff();
  const auto& columns = problem_->lcp.columns();
  const int n = static_cast<int>(columns.size());
  for (std::size_t i = 0; i < contacts_.size(); ++i)
    contacts_[i] = {.kind = z[static_cast<int>(i)] > zero ? Kind::Rest : Kind::Open};
  for (PolygonalMode& friction : frictions_) friction = {.kind = Kind::Rest};
  int j = static_cast<int>(contacts_.size());
  for (std::size_t g = 0; g < problem_->lcp.groups().size(); ++g) {
    PolygonalMode& mode = mode_of(g);
    const bool slides = mode.kind != Kind::Open && z[n + static_cast<int>(g)] > zero;
    if (slides) mode.kind = Kind::Slide;
    for (; j < n && columns[at(j)].group == static_cast<int>(g); ++j)
      if (slides && z[j] > zero) (mode.first < 0 ? mode.first : mode.second) = j;
    if (slides && mode.first < 0) mode.kind = Kind::Rest;
  }
}

/// The equations of contact i in its mode: open, r = 0; closed, u_n = 0, and of friction, at rest u_f = 0, at a vertex d of the
/// polygon r_f = mu r_n d, and on the edge from d to e, (e - d) · u_f = 0 with m · (r_f - mu r_n d) = 0, m across it.
void PolygonalSharing::tie(std::size_t i) {
  const Problem& p = *problem_;
  const ContactInstant& c = p.instant.contacts[at(p.island.contacts[i])];
  const int row = p.reduced.rows_of(static_cast<int>(i)), tangents = c.tangents;
  const PolygonalMode& mode = contacts_[i];
  const auto known = [&](int k) {
    A_.row(k).setZero();
    A_C_.row(k).setZero();
    b_[k] = b_k_[k] = 0;
    A_(k, k) = p.reduced.diagonal[k];
  };
  if (mode.kind == Kind::Open)
    for (int k = 0; k <= tangents; ++k) known(row + k);
  if (mode.kind != Kind::Slide) return;
  const PolygonalLcp::Column& d = p.lcp.columns()[at(mode.first)];
  for (int k = 1; mode.second < 0 && k <= tangents; ++k) {
    known(row + k);
    A_(row + k, row) = -p.reduced.diagonal[row + k] * c.mu * (k == 1 ? d.c0 : d.c1);
  }
  if (mode.second < 0) return;
  const PolygonalLcp::Column& e = p.lcp.columns()[at(mode.second)];
  const Vector2 edge = Vector2(e.c0 - d.c0, e.c1 - d.c1).normalized(), m(-edge.y(), edge.x());
  A_.row(row + 1) = edge.x() * p.reduced.W.row(row + 1) + edge.y() * p.reduced.W.row(row + 2);
  A_C_.row(row + 1) = edge.x() * C_.row(row + 1) + edge.y() * C_.row(row + 2);
  b_[row + 1] = edge.x() * q_[row + 1] + edge.y() * q_[row + 2];
  b_k_[row + 1] = edge.x() * k_[row + 1] + edge.y() * k_[row + 2];
  known(row + 2);
  const double w = p.reduced.diagonal[row + 2];
  A_(row + 2, row) = -w * c.mu * (m.x() * d.c0 + m.y() * d.c1);
  A_(row + 2, row + 1) = w * m.x();
  A_(row + 2, row + 2) = w * m.y();
}

/// r_ and u_ of the limit in the modes; false if there is none, or more than one.
bool PolygonalSharing::solve() {
  const Problem& p = *problem_;
  A_ = p.reduced.W;
  A_C_ = C_;
  b_ = q_;
  b_k_ = k_;
  for (std::size_t i = 0; i < contacts_.size(); ++i) tie(i);
  for (std::size_t i = 0; i < frictions_.size(); ++i) {
    if (frictions_[i].kind != Kind::Slide) continue;
    const int row = p.reduced.friction_row(static_cast<int>(i));
    const PolygonalLcp::Column& d = p.lcp.columns()[at(frictions_[i].first)];
    A_.row(row).setZero();
    A_C_.row(row).setZero();
    A_(row, row) = p.reduced.diagonal[row];
    b_[row] = -A_(row, row) * d.c0 * p.lcp.groups()[at(d.group)].bound;
    b_k_[row] = 0;
  }
  scale_ = p.reduced.diagonal.cwiseSqrt();
  if (limit_.solve(A_, b_, A_C_, b_k_, scale_, r_) != VanishingCompliance::Outcome::Found) return false;
  u_ = q_;
  u_.noalias() += p.reduced.W * r_;
  // of rows that give, to first order in what they give: tells where velocities are zero
  r_1_ = limit_.first_order();
  u_1_ = k_;
  u_1_.noalias() += C_ * r_;
  small_1_ = u_1_.cwiseAbs().maxCoeff();
  u_1_.noalias() += p.reduced.W * r_1_;
  return true;
}

/// Whether a velocity v is negative, or zero and negative to first order.
bool PolygonalSharing::negative(double v, double v_1) const {
  constexpr double first = 1e-6;  // of what rows give
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
  const auto& columns = problem_->lcp.columns();
  int j = static_cast<int>(contacts_.size());
  for (std::size_t g = 0; g < problem_->lcp.groups().size(); ++g) {
    const int first = j;
    int pushed = j;  // the vertex nearest to the impulse
    for (; j < static_cast<int>(columns.size()) && columns[at(j)].group == static_cast<int>(g); ++j)
      if (along(j, r_) > along(pushed, r_)) pushed = j;
    PolygonalMode& mode = mode_of(g);
    const double bound = bound_of(g);
    if (mode.kind == Kind::Rest && bound >= 0 && along(pushed, r_) > bound) {
      mode = {.kind = Kind::Slide, .first = pushed};
    } else if (mode.kind == Kind::Slide) {
      const int now = fastest(first, j);
      if (negative(-along(mode.first, u_), -along(mode.first, u_1_)))  // it would go with its friction
        mode = {.kind = Kind::Rest};
      else if (mode.second >= 0)
        mode = {.kind = Kind::Slide, .first = pushed};
      else if (now != mode.first)
        mode = {.kind = Kind::Slide,
                .first = now,
                .second = now == mode.last ? mode.first : -1,
                .last = mode.first};
    }
  }
  for (std::size_t i = 0; i < contacts_.size(); ++i) {
    const int row = columns[i].row;
    if (contacts_[i].kind != Kind::Open && problem_->reduced.diagonal[row] * r_[row] < -misfit * small_)
      contacts_[i] = {};
    else if (contacts_[i].kind == Kind::Open && negative(u_[row], u_1_[row]))
      contacts_[i] = {.kind = Kind::Rest};
  }
}

/// Whether the limit keeps to the complementarity of its modes; what it misses by rounding is cut off.
bool PolygonalSharing::fits() {
  const double velocity = misfit * small_;
  const auto& columns = problem_->lcp.columns();
  for (std::size_t i = 0; i < contacts_.size(); ++i) {
    const int row = columns[i].row;
    if (contacts_[i].kind == Kind::Open ? negative(u_[row], u_1_[row])
                                        : problem_->reduced.diagonal[row] * r_[row] < -velocity)
      return false;
  }
  int j = static_cast<int>(contacts_.size());
  for (std::size_t g = 0; g < problem_->lcp.groups().size(); ++g) {
    const int first = j;
    while (j < static_cast<int>(columns.size()) && columns[at(j)].group == static_cast<int>(g)) ++j;
    if (!fits(g, first, j)) return false;
  }
  for (std::size_t i = 0; i < contacts_.size(); ++i) {
    const int row = columns[i].row, contact = problem_->island.contacts[i];
    if (r_[row] < 0) r_.segment(row, 1 + problem_->instant.contacts[at(contact)].tangents).setZero();
  }
  return true;
}

/// The same of a group, whose columns are [first, end): friction against the vertex that opposes sliding most, inside the polygon.
bool PolygonalSharing::fits(std::size_t g, int first, int end) const {
  const PolygonalMode& mode = mode_of(g);
  if (mode.kind == Kind::Open) return true;
  if (mode.kind == Kind::Slide) {
    if (negative(-along(mode.first, u_), -along(mode.first, u_1_))) return false;
    const int now = fastest(first, end);
    if (now != mode.first && now != mode.second) return false;
    if (mode.second < 0) return true;
  }
  const bool plane = problem_->lcp.columns()[at(first)].rows == 2;
  const double wide = plane ? std::cos(std::acos(-1.0) / (end - first)) : 1;  // of an edge from the middle
  const double room = bound_of(g) * wide + misfit * small_ / problem_->lcp.groups()[g].diagonal;
  for (int i = first; i < end; ++i) {
    const int next = i + 1 < end ? i + 1 : first;
    const double p = plane ? (along(i, r_) + along(next, r_)) / (2 * wide) : along(i, r_);
    if (p > room) return false;
  }
  return true;
}

}  // namespace perp
