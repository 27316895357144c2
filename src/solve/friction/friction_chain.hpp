// The stages of the chain on one scaled problem, and the best point that they came to.
#pragma once

#include <algorithm>
#include <cmath>
#include <utility>

#include "perp/solve/friction_solver.hpp"
#include "solve/friction/friction_stages.hpp"
#include "solve/friction/ipopt_stage.hpp"

namespace perp {

/// The chain over one scaled problem. `best` only ever improves.
template <int R>
class Chain {
 public:
  Chain(const ContactSystem<R>& system, const FrictionOptions& options, Budget& budget)
      : system_(system), options_(options), budget_(budget) {}

  FrictionStage stage = FrictionStage::None;
  Iterate<R> best;

  bool solved() const { return best.error <= options_.tolerance; }
  bool done() const { return solved() || budget_.spent(); }

  void start(Columns<R> r) {
    best.r = std::move(r);
    evaluate(system_, best);
  }

  /// Newton from the best point.
  void newton_stage(int most) {
    attempt(
        FrictionStage::Newton,
        [&](Iterate<R>& point) {
          newton_from(point, {.most = most});
          sharpen(point);
        },
        best);
  }

  /// A few sweeps set the contacts' modes right where the start is another problem's answer; not counted.
  void sweep_start() {
    if (done()) return;
    constexpr int sweeps = 3;
    Budget own;
    Iterate<R> point = best;
    point.error = infinity;  // take the sweeps' end, better or not: Newton is what it is for
    gauss_seidel(system_, sweeps, options_.tolerance, own, point);
    if (!std::isfinite(point.error)) return;
    attempt(
        FrictionStage::Newton,
        [&](Iterate<R>& x) {
          newton_from(x, {.most = 12});
          if (x.error > options_.tolerance) newton_from(x, {.most = 25, .least_regularisation = 1e-6});
        },
        point);
  }

  /// Sweeps first, as long as they pay. Newton's method takes more than three iterations, but a multiplication in its blocks costs less
  /// than one in a sweep.
  void sweeps_first() {
    constexpr int few = 30;          // contacts: of fewer, iterations cost no more than sweeps
    constexpr double by_newton = 3;  // iterations
    if (done() || system_.n < few) return;
    attempt(
        FrictionStage::GaussSeidel,
        [&](Iterate<R>& point) {
          sweeps_while_they_pay(system_, by_newton, options_.tolerance, budget_, point);
        },
        best);
  }

  /// Where Newton stalled: sweeps as long as they pay beside a homotopy, then Newton once more.
  void sweeps_again() {
    constexpr int few = 30;             // contacts
    constexpr double by_homotopy = 40;  // iterations
    if (done() || system_.n < few) return;
    attempt(
        FrictionStage::GaussSeidel,
        [&](Iterate<R>& point) {
          const double before = point.error;
          sweeps_while_they_pay(system_, by_homotopy, options_.tolerance, budget_, point);
          if (point.error < before && point.error > options_.tolerance) newton_from(point, {.most = 25});
          sharpen(point);
        },
        best);
  }

  /// One interior-point run, then the polish from its best point.
  void interior_point_stage(FrictionStage name, const InteriorPointOptions& interior) {
    Iterate<R> point;
    point.r = Columns<R>::Zero(R, system_.n);
    evaluate(system_, point);
    attempt(
        name,
        [&](Iterate<R>& x) {
          interior_point(system_, interior, options_.tolerance, budget_, x);
          polish(x);
        },
        point);
  }

  void proximal_stage(const ProximalOptions& proximal) {
    Iterate<R> point;
    point.r = Columns<R>::Zero(R, system_.n);
    evaluate(system_, point);
    attempt(
        FrictionStage::Proximal,
        [&](Iterate<R>& x) {
          proximal_point(system_, proximal, options_.tolerance, budget_, x);
          polish(x);
        },
        point);
  }

  /// Takes an answer found elsewhere if it is better.
  void offer(FrictionStage name, Columns<R> r) {
    Iterate<R> point;
    point.r = std::move(r);
    evaluate(system_, point);
    attempt(
        name, [&](Iterate<R>& x) { sharpen(x); }, point);
  }

  void gauss_seidel_stage(int sweeps) {
    attempt(
        FrictionStage::GaussSeidel,
        [&](Iterate<R>& point) {
          gauss_seidel(system_, sweeps, options_.tolerance, budget_, point);
          polish(point);
        },
        best);
  }

  void ipopt_stage() {
    for (const double start : {0.1, 1.0, 0.01}) {
      if (done()) return;
      Iterate<R> point;
      point.r = Columns<R>::Zero(R, system_.n);
      evaluate(system_, point);
      attempt(
          FrictionStage::Ipopt,
          [&](Iterate<R>& x) {
            solve_by_ipopt(system_, start, budget_, x);
            polish(x);
          },
          point);
    }
  }

 private:
  template <class Method>
  void attempt(FrictionStage name, Method&& method, Iterate<R> point) {
    const double before = best.error;
    const int most = budget_.most;
    if (options_.stage_iterations > 0 && name != FrictionStage::Ipopt) {
      const int own = budget_.iterations + options_.stage_iterations;
      budget_.most = most > 0 ? std::min(most, own) : own;
    }
    method(point);
    budget_.most = most;
    if (!(point.error < before)) return;
    best = std::move(point);
    stage = name;
  }

  void newton_from(Iterate<R>& point, const NewtonOptions& newton_options) {
    newton(system_, newton_options, options_.tolerance, budget_, point);
  }

  /// A few steps towards round-off where redundant contacts made Newton stall below the tolerance.
  void sharpen(Iterate<R>& point) {
    constexpr double round_off = 1e-13;
    if (point.error <= options_.tolerance && point.error > round_off) newton_from(point, {.most = 5});
  }

  /// Four Newton methods in turn, until one reaches the tolerance.
  void polish(Iterate<R>& point) {
    const auto passed = [&] { return point.error <= options_.tolerance; };
    newton_from(point, {.most = 30});
    if (!passed()) newton_from(point, {.most = 30, .fischer_burmeister = true});
    if (!passed()) newton_from(point, {.most = 30, .rho = 0.1});
    if (!passed()) newton_from(point, {.most = 30, .rho = 10});
    sharpen(point);
  }

  const ContactSystem<R>& system_;
  const FrictionOptions& options_;
  Budget& budget_;
};

}  // namespace perp
