// Integration in fixed modes by extrapolation of half-explicit steps.
#pragma once

#include <vector>

#include "step/events/integrator.hpp"

namespace perp {

/// Column j divides a step H into n_j = 2 j substeps of the half-explicit midpoint rule [Lub91], h = H/n_j:
///   q_k+1 = q_k-1 ⊕ 2h nu_k,   M(q_k) (nu_k+1 - nu_k-1) = 2h k(q_k, nu_k) + L(q_k, nu_k) z_k,   R(q_k+1)ᵀ nu_k+1 + ∂ψ/∂t = 0,
/// the first from (q_0, nu_0) with h in 2h's place. Each is a contact step in given modes: impulses z_k, the velocity equations solved at its
/// end, one linear system. It is symmetric, so that at even k errors have an expansion in h², which Aitken and Neville's scheme takes away term
/// by term: order 2 K of K columns. Orientations are extrapolated as rotation vectors from that of the first column.
///
/// With `order` a step leads to t_stop by order/2 columns; else their number and H follow from the error a unit of work
/// [HNW93, II.9], the difference of the last two entries of a row.
class ExtrapolatedFlow final : public ModeIntegrator {
 public:
  struct Options {
    int order = 0;  ///< even; 0: chosen
    double rtol = 1e-10, atol = 1e-10;
  };
  ExtrapolatedFlow(ModeDynamics& dynamics, const Options& options);

  std::string_view name() const override { return "extrapolated"; }
  bool start(const State& x, double h) override;
  bool step(double t_stop, State& x) override;
  const RowSums* sums() const override { return &row_sums_; }

  static constexpr int most_columns = 9;  ///< beyond, rounding grows as fast as errors fall

 private:
  bool begin_step(const State& x);
  bool substeps(const State& x, double H, int n);
  bool add_column(const State& x, double H);
  double error() const;
  double first_guess(const State& x) const;
  bool finish(const State& x, double H, State& end);
  bool fixed(double H, State& x);
  bool try_step(const State& x, double& H, State& end);
  bool fits(int k, double error) const;
  void choose_next(double H);
  void retreat(double& H, bool finite);

  ModeDynamics& d_;
  Options options_;
  ModeKick first_, kick_;  // at the start of the step; of the substep
  State now_, before_, next_;
  Vector z_, base_, weight_;
  std::vector<Vector> row_;  // T_j1 .. T_jj of the last column: (configuration from base_, velocity, sums)
  Vector last_;              // T_j,j-1
  int columns_ = 0;          // in this step
  double h_ = 0;             // of the next
  int target_ = 0;           // columns that it is expected to need
  bool rejected_ = false;
  std::vector<double> best_h_, work_;  // by number of columns
  RowRates first_rates_, rates_;
  Vector sum_;  // impulses and works of a column
  RowSums row_sums_;
};

}  // namespace perp
