// The course of a fit: bounds, starts, parameters, all together; the scatter of each column with them.
#pragma once

#include "study/fit_runs.hpp"
#include "study/least_squares.hpp"

namespace perp {

class FitAdjuster {
 public:
  /// `last_rows` of a motion alone have no part.
  FitAdjuster(const FitProblem& problem, FitRuns& runs, Unknowns& unknowns, int last_rows);

  void find_bounds();    ///< parameters' bounds that were not given: what the scene accepts
  void settle_starts();  ///< each motion's start to its rows before the first contact
  std::vector<std::string> search_parameters();  ///< derivative-free, over parameters alone
  bool adjust();  ///< everything to everything, beginnings first; whether it ended at a minimum
  void adjust_starts(int iterations);  ///< each motion's own unknowns alone, to the rows in force

  bool runs_at_all();
  const Vector& theta() const { return theta_; }
  void set_theta(const Vector& theta) { theta_ = theta; }
  const Vector& sigmas() const { return sigma_; }
  void set_sigmas(const Vector& sigma) { sigma_ = sigma; }
  FitRuns& runs() { return runs_; }
  const Unknowns& unknowns() const { return unknowns_; }

  /// The unknowns that all rows decide on.
  std::vector<int> adjusted() const;
  /// H = J^T w J by central differences, residuals in sigmas.
  Matrix hessian();
  std::vector<Residual> residuals(const Vector& theta);
  double cost(const Vector& theta);
  long cells() const;  ///< in force

  static double weight(double r);  ///< of a residual of r sigmas: rho'(r)/r

 private:
  LeastSquaresEnd minimise(const std::vector<int>& free, int iterations, double tolerance);
  void normal_equations(const Vector& theta, const std::vector<int>& free, bool central, Matrix& H,
                        Vector& g);
  void estimate_sigmas();
  double difference(int unknown) const;

  const FitProblem& problem_;
  FitRuns& runs_;
  Unknowns& unknowns_;
  std::vector<int> whole_;            // rows of each motion
  Vector theta_, sigma_, precision_;  // precision_: sqrt(H_jj) where it was last found, else 0
};

}  // namespace perp
