#include "solve/ncp/ncp_by_ipopt.hpp"

#ifndef PERP_HAS_IPOPT

namespace perp {
Vector ncp_by_ipopt(const NcpFunction&, const NcpJacobian&, const Vector& z0, int&) {
  return Vector::Constant(z0.size(), not_set);
}
}  // namespace perp

#else

#define HAVE_CSTDDEF  // asked for by the headers of Ipopt 3.11
#include <IpTNLP.hpp>

#include "solve/ncp/ipopt_run.hpp"

namespace perp {
namespace {

using Ipopt::Index;
using Ipopt::Number;

constexpr double no_bound = 1e19;  // Ipopt reads beyond this as infinite

/// Variables z (n), w (n), t. Constraints F(z) - w = 0 (n), then z_i w_i - t <= 0 (n).
class NcpProgram final : public Ipopt::TNLP {
 public:
  NcpProgram(const NcpFunction& F, const NcpJacobian& J, const Vector& z0, int& iterations)
      : answer(Vector::Constant(z0.size(), not_set)),
        F_(F),
        J_(J),
        z0_(z0.cwiseMax(0)),
        n_(static_cast<Index>(z0.size())),
        iterations_(iterations) {}

  Vector answer;

  bool get_nlp_info(Index& n, Index& m, Index& jacobian, Index& hessian, IndexStyleEnum& style) override {
    n = 2 * n_ + 1;
    m = 2 * n_;
    jacobian = n_ * n_ + 4 * n_;
    hessian = 0;
    style = C_STYLE;
    return true;
  }

  bool get_bounds_info(Index n, Number* lower, Number* upper, Index m, Number* g_lower,
                       Number* g_upper) override {
    std::fill_n(lower, n, 0.0);
    std::fill_n(upper, n, no_bound);
    std::fill_n(g_lower, n_, 0.0);
    std::fill_n(g_lower + n_, m - n_, -no_bound);
    std::fill_n(g_upper, m, 0.0);
    return true;
  }

  bool get_starting_point(Index, bool, Number* x, bool, Number*, Number*, Index, bool, Number*) override {
    const Vector w = F_(z0_);
    if (!w.allFinite()) return false;
    at(x, 0) = z0_;
    at(x, n_) = w.cwiseMax(0);
    x[2 * n_] = std::max(1.0, z0_.cwiseProduct(w).maxCoeff());
    return true;
  }

  bool eval_f(Index, const Number* x, bool, Number& value) override {
    value = x[2 * n_];
    return true;
  }
  bool eval_grad_f(Index n, const Number*, bool, Number* gradient) override {
    std::fill_n(gradient, n, 0.0);
    gradient[2 * n_] = 1;
    return true;
  }

  bool eval_g(Index, const Number* x, bool, Index, Number* g) override {
    const Vector z = at(x, 0), w = at(x, n_), F = F_(z);
    at(g, 0) = F - w;
    at(g, n_) = z.cwiseProduct(w).array() - x[2 * n_];
    return F.allFinite();
  }

  bool eval_jac_g(Index, const Number* x, bool, Index, Index, Index* rows, Index* cols,
                  Number* values) override {
    const Matrix J = values == nullptr ? Matrix::Zero(n_, n_) : J_(at(x, 0));
    Index entry = 0;
    const auto put = [&](Index i, Index j, double value) {
      if (values == nullptr)
        rows[entry] = i, cols[entry] = j;
      else
        values[entry] = value;
      ++entry;
    };
    for (Index i = 0; i < n_; ++i) {
      for (Index j = 0; j < n_; ++j) put(i, j, J(i, j));
      put(i, n_ + i, -1);
      put(n_ + i, i, values == nullptr ? 0 : x[n_ + i]);
      put(n_ + i, n_ + i, values == nullptr ? 0 : x[i]);
      put(n_ + i, 2 * n_, -1);
    }
    return J.allFinite();
  }

  bool intermediate_callback(Ipopt::AlgorithmMode, Index, Number, Number, Number, Number, Number, Number,
                             Number, Number, Index, const Ipopt::IpoptData*,
                             Ipopt::IpoptCalculatedQuantities*) override {
    ++iterations_;
    return true;
  }

  void finalize_solution(Ipopt::SolverReturn, Index, const Number* x, const Number*, const Number*, Index,
                         const Number*, const Number*, Number, const Ipopt::IpoptData*,
                         Ipopt::IpoptCalculatedQuantities*) override {
    answer = at(x, 0);
  }

 private:
  Eigen::Map<Vector> at(Number* x, Index first) const { return {x + first, n_}; }
  Eigen::Map<const Vector> at(const Number* x, Index first) const { return {x + first, n_}; }

  const NcpFunction& F_;
  const NcpJacobian& J_;
  Vector z0_;
  Index n_;
  int& iterations_;
};

}  // namespace

Vector ncp_by_ipopt(const NcpFunction& F, const NcpJacobian& J, const Vector& z0, int& iterations) {
  const Ipopt::SmartPtr<NcpProgram> program = new NcpProgram(F, J, z0, iterations);
  run_ipopt(GetRawPtr(program), false);
  return program->answer;
}

}  // namespace perp

#endif
