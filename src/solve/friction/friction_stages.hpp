// The stages of the friction solver's chain, each a method of its own on the scaled problem.
#pragma once

#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>

#include "solve/friction/contact_system.hpp"

namespace perp {

/// What rounding of u = W r + q may hide in the natural map at |r| = size, in the scaled problem [-].
inline double round_off(double size) { return 4 * std::numeric_limits<double>::epsilon() * size; }

/// What must be below the tolerance: the natural map over max(1, |r|), and a hundredth of it as it stands with what
/// rounding may hide, since reactions that run off to infinity make the first small by themselves [-].
inline double pass_error(double natural_map, double size) {
  return std::max(natural_map / std::max(1.0, size), 0.01 * (natural_map + round_off(size)));
}

/// A point with its residual; stages keep the best one they meet.
template <int R>
struct Iterate {
  Columns<R> r, u;          ///< u = W r + q
  double error = infinity;  ///< pass_error
};

/// The natural map's Euclidean norm over the scaled problem, |r - P_K(r - û)|.
template <int R>
double natural_map(const ContactSystem<R>& system, const Columns<R>& r, const Columns<R>& u);

/// Recomputes u and the error of point.r.
template <int R>
void evaluate(const ContactSystem<R>& system, Iterate<R>& point);

/// When to give up; shared by all stages of one solve.
struct Budget {
  int iterations = 0;            ///< done so far, over all stages
  int most = 0;                  ///< 0: no limit
  double time_limit = infinity;  ///< from `start` on [s]
  std::chrono::steady_clock::time_point start = std::chrono::steady_clock::now();

  double seconds_left() const {
    return time_limit - std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  }
  bool spent() const {
    return (most > 0 && iterations >= most) || (std::isfinite(time_limit) && seconds_left() <= 0);
  }
};

/// Semismooth Newton on r - p(r - rho u) = 0 with Alart and Curnier's p. W + eps I stands in the Jacobian only, with
/// eps = regularisation * error between the least one and 1e-2: with less redundant contacts are thrown about.
struct NewtonOptions {
  int most = 12;   ///< iterations
  double rho = 1;  ///< in the scaled problem [-]
  double regularisation = 1e-3;
  double least_regularisation = 1e-7;
  bool fischer_burmeister = false;  ///< solve FB(r, û) = 0 on the cone instead, eps ~ sqrt(error)
};

/// Improves `best` from its r; goes on below `tolerance` while the error still falls by half.
template <int R>
void newton(const ContactSystem<R>& system, const NewtonOptions& options, double tolerance, Budget& budget,
            Iterate<R>& best);

/// Interior-point homotopy on the exact problem with Nesterov-Todd scaling, the De Saxcé term inside.
struct InteriorPointOptions {
  int most = 60;       ///< iterations
  double start = 10;   ///< x = y = start * max(0.1, |b'|_inf) e0
  double damping = 1;  ///< factor on the derivative of |y_T| [-]
};
template <int R>
void interior_point(const ContactSystem<R>& system, const InteriorPointOptions& options, double tolerance,
                    Budget& budget, Iterate<R>& best);

/// Proximal point method: r_(k+1) solves the problem with alpha (r - r_k) added to u by Newton's method, alpha falls
/// while these inner problems are solved and grows when one is not. It needs no smoothing and comes to solutions
/// whose contacts hardly press and hardly slip, where the others stall.
struct ProximalOptions {
  int most = 100;       ///< inner problems
  double alpha = 1e-2;  ///< at the start; beside tr W_ii = rows [-]
  int newton = 15;      ///< iterations on each map in an inner problem
  int sweeps = 100;     ///< of Gauss-Seidel after an inner problem that was not solved; 0: none
};
template <int R>
void proximal_point(const ContactSystem<R>& system, const ProximalOptions& options, double tolerance,
                    Budget& budget, Iterate<R>& best);

/// Sweeps as long as they are the cheapest way to the tolerance: what is left to do at the contraction just measured costs less than
/// `iterations` of Newton's method would, both in multiplications. Where it cannot be they do not begin.
template <int R>
void sweeps_while_they_pay(const ContactSystem<R>& system, double iterations, double tolerance,
                           Budget& budget, Iterate<R>& best);

/// Sweeps with an exact solution of each contact alone.
template <int R>
void gauss_seidel(const ContactSystem<R>& system, int sweeps, double tolerance, Budget& budget,
                  Iterate<R>& best);

/// Solves one contact: u = W r + q, W (R, R), warm-started from r.
template <int R>
Column<R> solve_one_contact(const Block<R>& block, const Square<R>& W, const Column<R>& q,
                            const Column<R>& r);

}  // namespace perp
