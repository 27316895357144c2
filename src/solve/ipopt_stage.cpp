#include "ipopt_stage.hpp"

#include "perp/solve/friction_solver.hpp"

#ifndef PERP_HAS_IPOPT

namespace perp {
bool has_ipopt() { return false; }
void solve_by_ipopt(const ContactSystem&, double, Budget&, Iterate&) {}
}  // namespace perp

#else

#define HAVE_CSTDDEF  // asked for by the headers of Ipopt 3.11
#include <cmath>
#include <IpTNLP.hpp>

#include "ipopt_run.hpp"

namespace perp {
namespace {

using Ipopt::Index;
using Ipopt::Number;

constexpr double no_bound = 1e19;  // Ipopt reads beyond this as infinite

/// The program of ipopt_stage.hpp. Variables: r (3n), u (3n), s (n), t. For an interval, u = s - s' with s' = s - u
/// >= 0 in place of the friction rows: (mu + r) s <= t, (mu - r) s' <= t.
/// Constraints: u - W r = q (3n), then eight rows a block: those of `rows()`.
class ContactProgram final : public Ipopt::TNLP {
 public:
  ContactProgram(const ContactSystem& system, double start, Budget& budget)
      : system_(system),
        start_(start),
        budget_(budget),
        W_(system.W->dense()),
        n_(system.n),
        best_(Vector::Constant(7 * n_ + 1, not_set)) {
    for (Index i = 0; i < 3 * n_; ++i)
      for (Index j = 0; j < 3 * n_; ++j)
        if (W_(i, j) != 0) W_row_.push_back(i), W_col_.push_back(j);
  }

  Vector best() const { return best_; }

  bool get_nlp_info(Index& n, Index& m, Index& jacobian, Index& hessian, IndexStyleEnum& style) override {
    n = 7 * n_ + 1;
    m = 3 * n_ + rows_a_block * n_;
    jacobian = static_cast<Index>(W_row_.size()) + 3 * n_ + entries_a_block * n_;
    hessian = hessian_a_block * n_;
    style = C_STYLE;
    return true;
  }

  bool get_bounds_info(Index n, Number* lower, Number* upper, Index, Number* g_lower,
                       Number* g_upper) override {
    std::fill_n(lower, n, -no_bound);
    std::fill_n(upper, n, no_bound);
    for (Index i = 0; i < n_; ++i) {
      const BlockKind kind = system_.kind[i];
      const double mu = system_.mu[i];
      const bool friction = has_friction(i);
      for (Index k = 0; k < 3; ++k) lower[r(i, k)] = upper[r(i, k)] = 0;
      if (kind == BlockKind::Interval) {
        lower[r(i, 1)] = -mu, upper[r(i, 1)] = mu;
      } else {
        upper[r(i, 0)] = no_bound;
        lower[u(i, 0)] = 0;
      }
      if (friction) lower[r(i, 1)] = -no_bound, upper[r(i, 1)] = no_bound;
      if (friction && kind == BlockKind::Cone) lower[r(i, 2)] = -no_bound, upper[r(i, 2)] = no_bound;
      lower[s(i)] = 0;
      if (!friction && kind != BlockKind::Interval) upper[s(i)] = 0;
      // rows: two products <= t, cone <= 0, two of sliding = 0, s - u >= 0
      Number *below = g_lower + row(i, 0), *above = g_upper + row(i, 0);
      std::fill_n(below, rows_a_block, -no_bound);
      std::fill_n(above, rows_a_block, 0.0);
      below[3] = below[4] = 0;
      if (kind == BlockKind::Interval) below[5] = 0, above[5] = no_bound;
    }
    lower[t()] = 0;
    for (Index i = 0; i < 3 * n_; ++i) g_lower[i] = g_upper[i] = system_.q(i % 3, i / 3);
    return true;
  }

  bool get_starting_point(Index n, bool, Number* x, bool, Number*, Number*, Index, bool, Number*) override {
    std::fill_n(x, n, 0.0);
    Columns3 reaction = Columns3::Zero(3, n_), velocity;
    for (Index i = 0; i < n_; ++i)
      if (system_.kind[i] != BlockKind::Interval) reaction(0, i) = start_;
    system_.W->apply(reaction, velocity);
    velocity += system_.q;
    for (Index i = 0; i < n_; ++i) {
      for (Index k = 0; k < 3; ++k) x[r(i, k)] = reaction(k, i), x[u(i, k)] = velocity(k, i);
      x[s(i)] = std::max(start_, velocity.col(i).tail<2>().norm());
    }
    x[t()] = 1;
    return true;
  }

  bool eval_f(Index, const Number* x, bool, Number& value) override {
    value = x[t()];
    return true;
  }
  bool eval_grad_f(Index n, const Number*, bool, Number* gradient) override {
    std::fill_n(gradient, n, 0.0);
    gradient[t()] = 1;
    return true;
  }

  bool eval_g(Index, const Number* x, bool, Index, Number* g) override {
    const Eigen::Map<const Vector> reaction(x, 3 * n_), velocity(x + 3 * n_, 3 * n_);
    Eigen::Map<Vector>(g, 3 * n_) = velocity;
    for (size_t e = 0; e < W_row_.size(); ++e) g[W_row_[e]] -= W_(W_row_[e], W_col_[e]) * reaction(W_col_[e]);
    for (Index i = 0; i < n_; ++i) {
      const double mu = system_.mu[i], s_i = x[s(i)];
      Number* out = g + row(i, 0);
      if (system_.kind[i] == BlockKind::Interval) {
        const double p = x[r(i, 1)], v = x[u(i, 1)];
        out[0] = (mu + p) * s_i - x[t()];
        out[1] = (mu - p) * (s_i - v) - x[t()];
        out[2] = out[3] = out[4] = 0;
        out[5] = s_i - v;
        continue;
      }
      const Vector3 p = reaction.segment<3>(3 * i), v = velocity.segment<3>(3 * i);
      const double room = mu * mu * p(0) * p(0) - p.tail<2>().squaredNorm();
      const double friction = has_friction(i) ? 1 : 0;
      out[0] = p(0) * v(0) - x[t()];
      out[1] = friction * s_i * room - x[t()];
      out[2] = -friction * room;
      out[3] = friction * (mu * p(0) * v(1) + s_i * p(1));
      out[4] = system_.kind[i] == BlockKind::Cone ? friction * (mu * p(0) * v(2) + s_i * p(2)) : 0;
      out[5] = 0;
    }
    return true;
  }

  bool eval_jac_g(Index, const Number* x, bool, Index, Index, Index* rows, Index* cols,
                  Number* values) override {
    Index at = 0;
    const auto put = [&](Index i, Index j, double value) {
      if (values == nullptr)
        rows[at] = i, cols[at] = j;
      else
        values[at] = value;
      ++at;
    };
    for (size_t e = 0; e < W_row_.size(); ++e) put(W_row_[e], W_col_[e], -W_(W_row_[e], W_col_[e]));
    for (Index i = 0; i < 3 * n_; ++i) put(i, 3 * n_ + i, 1);
    for (Index i = 0; i < n_; ++i) {
      const double mu = system_.mu[i];
      const auto value = [&](Index j) { return x == nullptr ? 0 : x[j]; };
      const double p_0 = value(r(i, 0)), p_1 = value(r(i, 1)), p_2 = value(r(i, 2)), s_i = value(s(i));
      const double v_0 = value(u(i, 0)), v_1 = value(u(i, 1)), v_2 = value(u(i, 2));
      const bool interval = system_.kind[i] == BlockKind::Interval;
      const double on = has_friction(i) ? 1 : 0, on_2 = system_.kind[i] == BlockKind::Cone ? on : 0;
      const double room = on * (mu * mu * p_0 * p_0 - p_1 * p_1 - p_2 * p_2);
      put(row(i, 0), r(i, 0), interval ? 0 : v_0);
      put(row(i, 0), u(i, 0), interval ? 0 : p_0);
      put(row(i, 0), r(i, 1), interval ? s_i : 0);
      put(row(i, 0), s(i), interval ? mu + p_1 : 0);
      put(row(i, 0), t(), -1);
      put(row(i, 1), s(i), interval ? mu - p_1 : room);
      put(row(i, 1), r(i, 0), interval ? 0 : on * 2 * s_i * mu * mu * p_0);
      put(row(i, 1), r(i, 1), interval ? -(s_i - v_1) : -on * 2 * s_i * p_1);
      put(row(i, 1), r(i, 2), interval ? 0 : -on * 2 * s_i * p_2);
      put(row(i, 1), u(i, 1), interval ? -(mu - p_1) : 0);
      put(row(i, 1), t(), -1);
      put(row(i, 2), r(i, 0), -on * 2 * mu * mu * p_0);
      put(row(i, 2), r(i, 1), on * 2 * p_1);
      put(row(i, 2), r(i, 2), on * 2 * p_2);
      put(row(i, 3), r(i, 0), on * mu * v_1);
      put(row(i, 3), u(i, 1), on * mu * p_0);
      put(row(i, 3), s(i), on * p_1);
      put(row(i, 3), r(i, 1), on * s_i);
      put(row(i, 4), r(i, 0), on_2 * mu * v_2);
      put(row(i, 4), u(i, 2), on_2 * mu * p_0);
      put(row(i, 4), s(i), on_2 * p_2);
      put(row(i, 4), r(i, 2), on_2 * s_i);
      put(row(i, 5), s(i), interval ? 1 : 0);
      put(row(i, 5), u(i, 1), interval ? -1 : 0);
    }
    return true;
  }

  bool eval_h(Index, const Number* x, bool, Number, Index, const Number* multiplier, bool, Index, Index* rows,
              Index* cols, Number* values) override {
    Index at = 0;
    const auto put = [&](Index i, Index j, double value) {
      if (values == nullptr)
        rows[at] = std::max(i, j), cols[at] = std::min(i, j);
      else
        values[at] = value;
      ++at;
    };
    for (Index i = 0; i < n_; ++i) {
      double l[rows_a_block] = {};
      Vector3 p = Vector3::Zero();
      double s_i = 0;
      if (values != nullptr) {
        std::copy_n(multiplier + row(i, 0), rows_a_block, l);
        p = Eigen::Map<const Vector3>(x + r(i, 0));
        s_i = x[s(i)];
      }
      const double mu = system_.mu[i], mu2 = mu * mu;
      const bool interval = system_.kind[i] == BlockKind::Interval;
      const double on = has_friction(i) ? 1 : 0, on_2 = system_.kind[i] == BlockKind::Cone ? on : 0;
      put(r(i, 0), u(i, 0), interval ? 0 : l[0]);
      put(r(i, 0), r(i, 0), on * 2 * mu2 * (s_i * l[1] - l[2]));
      put(r(i, 1), r(i, 1), on * -2 * (s_i * l[1] - l[2]));
      put(r(i, 2), r(i, 2), on * -2 * (s_i * l[1] - l[2]));
      put(s(i), r(i, 0), on * 2 * mu2 * p(0) * l[1]);
      put(s(i), r(i, 1), interval ? l[0] - l[1] : on * (-2 * p(1) * l[1] + l[3]));
      put(s(i), r(i, 2), on * -2 * p(2) * l[1] + on_2 * l[4]);
      put(r(i, 0), u(i, 1), on * mu * l[3]);
      put(r(i, 0), u(i, 2), on_2 * mu * l[4]);
      put(r(i, 1), u(i, 1), interval ? l[1] : 0);
    }
    return true;
  }

  bool intermediate_callback(Ipopt::AlgorithmMode, Index, Number, Number, Number, Number, Number, Number,
                             Number, Number, Index, const Ipopt::IpoptData*,
                             Ipopt::IpoptCalculatedQuantities*) override {
    ++budget_.iterations;
    return !budget_.spent();
  }

  void finalize_solution(Ipopt::SolverReturn, Index n, const Number* x, const Number*, const Number*, Index,
                         const Number*, const Number*, Number, const Ipopt::IpoptData*,
                         Ipopt::IpoptCalculatedQuantities*) override {
    best_ = Eigen::Map<const Vector>(x, n);
  }

 private:
  static constexpr Index rows_a_block = 6, entries_a_block = 24, hessian_a_block = 10;

  bool has_friction(Index i) const {
    return (system_.kind[i] == BlockKind::Cone || system_.kind[i] == BlockKind::Planar) && system_.mu[i] > 0;
  }
  static Index r(Index i, Index k) { return 3 * i + k; }
  Index u(Index i, Index k) const { return 3 * n_ + 3 * i + k; }
  Index s(Index i) const { return 6 * n_ + i; }
  Index t() const { return 7 * n_; }
  Index row(Index i, Index k) const { return 3 * n_ + rows_a_block * i + k; }

  const ContactSystem& system_;
  double start_;
  Budget& budget_;
  Matrix W_;
  Index n_;
  std::vector<Index> W_row_, W_col_;
  Vector best_;
};

}  // namespace

bool has_ipopt() { return true; }

void solve_by_ipopt(const ContactSystem& system, double start, Budget& budget, Iterate& best) {
  const Ipopt::SmartPtr<ContactProgram> program = new ContactProgram(system, start, budget);
  run_ipopt(GetRawPtr(program), true);
  Iterate point;
  point.r = Eigen::Map<const Columns3>(program->best().data(), 3, system.n);
  if (!point.r.allFinite()) return;
  evaluate(system, point);
  if (point.error < best.error) best = std::move(point);
}

}  // namespace perp

#endif
