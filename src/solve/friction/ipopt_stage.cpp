#include "solve/friction/ipopt_stage.hpp"

#include "perp/solve/friction_solver.hpp"

#ifndef PERP_HAS_IPOPT

namespace perp {
bool has_ipopt() { return false; }
template <int R>
void solve_by_ipopt(const ContactSystem<R>&, double, Budget&, Iterate<R>&) {}
template void solve_by_ipopt(const ContactSystem<3>&, double, Budget&, Iterate<3>&);
template void solve_by_ipopt(const ContactSystem<6>&, double, Budget&, Iterate<6>&);
}  // namespace perp

#else

#define HAVE_CSTDDEF  // asked for by the headers of Ipopt 3.11
#include <cmath>
#include <IpTNLP.hpp>

#include "solve/ncp/ipopt_run.hpp"

namespace perp {
namespace {

using Ipopt::Index;
using Ipopt::Number;

constexpr double no_bound = 1e19;  // Ipopt reads beyond this as infinite

/// The program of ipopt_stage.hpp. Variables: r (R n), u (R n), s (groups n), t. Constraints: u - W r = q (R n), then for each block
/// r_N u_N <= t and for each of its groups a product, the cone, and its rows of sliding.
template <int R>
class ContactProgram final : public Ipopt::TNLP {
 public:
  ContactProgram(const ContactSystem<R>& system, double start, Budget& budget)
      : system_(system),
        start_(start),
        budget_(budget),
        W_(system.W->dense()),
        n_(system.n),
        best_(Vector::Constant(t() + 1, not_set)) {
    for (Index i = 0; i < R * n_; ++i)
      for (Index j = 0; j < R * n_; ++j)
        if (W_(i, j) != 0) W_row_.push_back(i), W_col_.push_back(j);
  }

  Vector best() const { return best_; }

  bool get_nlp_info(Index& n, Index& m, Index& jacobian, Index& hessian, IndexStyleEnum& style) override {
    n = t() + 1;
    m = R * n_ + rows_a_block * n_;
    jacobian = static_cast<Index>(W_row_.size()) + R * n_;
    hessian = 0;
    for (Index i = 0; i < n_; ++i) {
      jacobian += 3, hessian += 1;
      for (const RowGroup& group : RowGroups<R>::all)
        jacobian += 4 + 6 * group.size, hessian += 2 + 3 * group.size;
    }
    style = C_STYLE;
    return true;
  }

  bool get_bounds_info(Index n, Number* lower, Number* upper, Index, Number* g_lower,
                       Number* g_upper) override {
    std::fill_n(lower, n, -no_bound);
    std::fill_n(upper, n, no_bound);
    for (Index i = 0; i < n_; ++i) {
      const Block<R>& block = system_.block[i];
      lower[r(i, 0)] = 0;
      upper[r(i, 0)] = block.contact ? no_bound : 0;
      if (block.contact) lower[u(i, 0)] = 0;
      for (Index k = 1; k < R; ++k)
        if (!(block.axes(k) > 0)) lower[r(i, k)] = upper[r(i, k)] = 0;
      for (Index g = 0; g < groups; ++g) {
        lower[s(i, g)] = 0;
        if (!block.has(RowGroups<R>::all[g])) upper[s(i, g)] = 0;
      }
      std::fill_n(g_lower + row(i, 0), rows_a_block, -no_bound);  // products and cones <= 0
      std::fill_n(g_upper + row(i, 0), rows_a_block, 0.0);
      for (Index g = 0; g < groups; ++g)
        for (Index k = 0; k < RowGroups<R>::all[g].size; ++k) {
          if (block.axes(RowGroups<R>::all[g].first + k) > 0)
            g_lower[row(i, sliding(g, k))] = 0;
          else
            g_upper[row(i, sliding(g, k))] = no_bound;  // 0 = 0: no equation
        }
    }
    lower[t()] = 0;
    for (Index i = 0; i < R * n_; ++i) g_lower[i] = g_upper[i] = system_.q(i % R, i / R);
    return true;
  }

  bool get_starting_point(Index n, bool, Number* x, bool, Number*, Number*, Index, bool, Number*) override {
    std::fill_n(x, n, 0.0);
    Columns<R> reaction = Columns<R>::Zero(R, n_), velocity;
    for (Index i = 0; i < n_; ++i)
      if (system_.block[i].contact) reaction(0, i) = start_;
    system_.W->apply(reaction, velocity);
    velocity += system_.q;
    for (Index i = 0; i < n_; ++i) {
      for (Index k = 0; k < R; ++k) x[r(i, k)] = reaction(k, i), x[u(i, k)] = velocity(k, i);
      for (Index g = 0; g < groups; ++g) {
        const Terms term(system_.block[i], g, x + r(i, 0), x + u(i, 0));
        x[s(i, g)] = std::max(start_, term.slip());
      }
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

  bool eval_g(Index, const Number* x, bool, Index, Number* g_out) override {
    const Eigen::Map<const Vector> reaction(x, R * n_), velocity(x + R * n_, R * n_);
    Eigen::Map<Vector>(g_out, R * n_) = velocity;
    for (size_t e = 0; e < W_row_.size(); ++e)
      g_out[W_row_[e]] -= W_(W_row_[e], W_col_[e]) * reaction(W_col_[e]);
    for (Index i = 0; i < n_; ++i) {
      g_out[row(i, 0)] = (system_.block[i].contact ? x[r(i, 0)] * x[u(i, 0)] : 0) - x[t()];
      for (Index g = 0; g < groups; ++g) {
        const Terms term(system_.block[i], g, x + r(i, 0), x + u(i, 0));
        const double s_g = x[s(i, g)];
        g_out[row(i, product(g))] = s_g * term.room() - x[t()];
        g_out[row(i, product(g) + 1)] = -term.room();
        for (Index k = 0; k < RowGroups<R>::all[g].size; ++k)
          g_out[row(i, sliding(g, k))] = term.size * term.A(k) * term.u(k) + s_g * term.c(k) * term.r(k);
      }
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
    for (Index i = 0; i < R * n_; ++i) put(i, R * n_ + i, 1);
    const Vector zero = x == nullptr ? Vector(Vector::Zero(t() + 1)) : Vector();
    if (x == nullptr) x = zero.data();
    for (Index i = 0; i < n_; ++i) {
      const double contact = system_.block[i].contact ? 1 : 0;
      put(row(i, 0), r(i, 0), contact * x[u(i, 0)]);
      put(row(i, 0), u(i, 0), contact * x[r(i, 0)]);
      put(row(i, 0), t(), -1);
      for (Index g = 0; g < groups; ++g) {
        const RowGroup& group = RowGroups<R>::all[g];
        const Terms term(system_.block[i], g, x + r(i, 0), x + u(i, 0));
        const double s_g = x[s(i, g)], by_normal = contact * 2 * term.a * term.a * term.size;
        put(row(i, product(g)), s(i, g), term.room());
        put(row(i, product(g)), r(i, 0), s_g * by_normal);
        put(row(i, product(g)), t(), -1);
        put(row(i, product(g) + 1), r(i, 0), -by_normal);
        for (Index k = 0; k < group.size; ++k) {
          const double by_friction = -2 * term.c(k) * term.c(k) * term.r(k);
          put(row(i, product(g)), r(i, group.first + k), s_g * by_friction);
          put(row(i, product(g) + 1), r(i, group.first + k), -by_friction);
          put(row(i, sliding(g, k)), r(i, 0), contact * term.A(k) * term.u(k));
          put(row(i, sliding(g, k)), u(i, group.first + k), term.size * term.A(k));
          put(row(i, sliding(g, k)), s(i, g), term.c(k) * term.r(k));
          put(row(i, sliding(g, k)), r(i, group.first + k), s_g * term.c(k));
        }
      }
    }
    return true;
  }

  bool eval_h(Index, const Number* x, bool, Number, Index m, const Number* multiplier, bool, Index,
              Index* rows, Index* cols, Number* values) override {
    Index at = 0;
    const auto put = [&](Index i, Index j, double value) {
      if (values == nullptr)
        rows[at] = std::max(i, j), cols[at] = std::min(i, j);
      else
        values[at] = value;
      ++at;
    };
    const Vector zero = values == nullptr ? Vector(Vector::Zero(std::max(t() + 1, m))) : Vector();
    if (values == nullptr) x = multiplier = zero.data();
    for (Index i = 0; i < n_; ++i) {
      const double contact = system_.block[i].contact ? 1 : 0;
      put(r(i, 0), u(i, 0), contact * multiplier[row(i, 0)]);
      for (Index g = 0; g < groups; ++g) {
        const RowGroup& group = RowGroups<R>::all[g];
        const Terms term(system_.block[i], g, x + r(i, 0), x + u(i, 0));
        const double l = multiplier[row(i, product(g))];
        const double bend = 2 * (x[s(i, g)] * l - multiplier[row(i, product(g) + 1)]);
        put(r(i, 0), r(i, 0), contact * bend * term.a * term.a);
        put(s(i, g), r(i, 0), contact * 2 * term.a * term.a * term.size * l);
        for (Index k = 0; k < group.size; ++k) {
          const double slide = multiplier[row(i, sliding(g, k))], c2 = term.c(k) * term.c(k);
          put(r(i, group.first + k), r(i, group.first + k), -bend * c2);
          put(s(i, g), r(i, group.first + k), -2 * c2 * term.r(k) * l + term.c(k) * slide);
          put(r(i, 0), u(i, group.first + k), contact * term.A(k) * slide);
        }
      }
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
  static constexpr Index groups = static_cast<Index>(RowGroups<R>::all.size());
  static constexpr Index rows_a_block = R + 2 * groups;

  /// A group's semi-axes A, the longest a, c = a/A (0 where A is), its r and u, and the size of its ellipsoid.
  struct Terms {
    Vector3 A, c = Vector3::Zero(), r, u;
    double a, size;

    Terms(const Block<R>& block, Index g, const Number* r_i, const Number* u_i)
        : A(Block<R>::rows(block.axes, RowGroups<R>::all[g])),
          r(Block<R>::rows(Eigen::Map<const Column<R> >(r_i), RowGroups<R>::all[g])),
          u(Block<R>::rows(Eigen::Map<const Column<R> >(u_i), RowGroups<R>::all[g])),
          a(A.maxCoeff()),
          size(block.contact ? r_i[0] : 1) {
      for (Index k = 0; k < 3; ++k)
        if (A(k) > 0) c(k) = a / A(k);
    }
    double room() const { return a * a * size * size - c.cwiseProduct(r).squaredNorm(); }
    double slip() const { return a > 0 ? A.cwiseProduct(u).norm() / a : 0; }
  };

  static Index r(Index i, Index k) { return R * i + k; }
  Index u(Index i, Index k) const { return R * n_ + R * i + k; }
  Index s(Index i, Index g) const { return 2 * R * n_ + groups * i + g; }
  Index t() const { return (2 * R + groups) * n_; }
  Index row(Index i, Index k) const { return R * n_ + rows_a_block * i + k; }
  static Index product(Index g) { return RowGroups<R>::all[g].first + 2 * g; }  // the cone's row follows
  static Index sliding(Index g, Index k) { return product(g) + 2 + k; }

  const ContactSystem<R>& system_;
  double start_;
  Budget& budget_;
  Matrix W_;
  Index n_;
  std::vector<Index> W_row_, W_col_;
  Vector best_;
};

}  // namespace

bool has_ipopt() { return true; }

template <int R>
void solve_by_ipopt(const ContactSystem<R>& system, double start, Budget& budget, Iterate<R>& best) {
  const Ipopt::SmartPtr<ContactProgram<R> > program = new ContactProgram<R>(system, start, budget);
  run_ipopt(GetRawPtr(program), true);
  Iterate<R> point;
  point.r = Eigen::Map<const Columns<R> >(program->best().data(), R, system.n);
  if (!point.r.allFinite()) return;
  evaluate(system, point);
  if (point.error < best.error) best = std::move(point);
}

template void solve_by_ipopt(const ContactSystem<3>&, double, Budget&, Iterate<3>&);
template void solve_by_ipopt(const ContactSystem<6>&, double, Budget&, Iterate<6>&);

}  // namespace perp

#endif
