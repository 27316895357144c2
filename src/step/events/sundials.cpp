// SUNDIALS's ARKODE, CVODE and IDA over the dynamics of fixed modes.
#include "perp/core/errors.hpp"
#include "step/events/integrator.hpp"

#ifdef PERP_HAS_SUNDIALS
#include <arkode/arkode_erkstep.h>
#include <cvode/cvode.h>
#include <ida/ida.h>
#include <nvector/nvector_serial.h>
#include <sunlinsol/sunlinsol_dense.h>
#include <sunmatrix/sunmatrix_dense.h>

#include <cmath>
#include <Eigen/Dense>

#include "step/events/runge_kutta_87.hpp"

namespace perp {
namespace {

struct Context {
  SUNContext get = nullptr;
  Context() { SUNContext_Create(nullptr, &get); }
  ~Context() { SUNContext_Free(&get); }
  Context(const Context&) = delete;
  Context& operator=(const Context&) = delete;
};

struct FreeVector {
  void operator()(N_Vector v) const { N_VDestroy(v); }
};
using NVector = std::unique_ptr<_generic_N_Vector, FreeVector>;
struct FreeMatrix {
  void operator()(SUNMatrix A) const { SUNMatDestroy(A); }
};
using NMatrix = std::unique_ptr<_generic_SUNMatrix, FreeMatrix>;
struct FreeSolver {
  void operator()(SUNLinearSolver s) const { SUNLinSolFree(s); }
};
using NSolver = std::unique_ptr<_generic_SUNLinearSolver, FreeSolver>;

Eigen::Map<Vector> entries(N_Vector v) { return {N_VGetArrayPointer(v), N_VGetLength(v)}; }

constexpr int failed_steps_allowed =
    60;  // in a row, each smaller: near a singularity of the equations many are needed

/// What the solvers' C functions have in common: the state that they ask about, and exceptions that must not pass through C.
class Base : public ModeIntegrator {
 public:
  Base(ModeDynamics& dynamics, double rtol, double atol) : d_(dynamics), rtol_(rtol), atol_(atol) {}

 protected:
  ModeDynamics& d_;
  double rtol_, atol_;
  Context context_;
  State at_;
  Vector q_dot_;

  void unpack(double t, const Eigen::Map<Vector>& y) {
    at_.t = t;
    at_.q = y.head(d_.model().nq());
    at_.nu = y.segment(d_.model().nq(), d_.model().nv());
  }
  static void pack(const State& x, Eigen::Map<Vector> y) {
    y.head(x.q.size()) = x.q;
    y.segment(x.q.size(), x.nu.size()) = x.nu;
  }

  /// Runs `work` (true: done) where an exception must not leave: 0, 1 (try a smaller step) or -1 (an exception, kept).
  template <class Work>
  int guarded(Work&& work) noexcept {
    try {
      return work() ? 0 : 1;
    } catch (...) {
      thrown = std::current_exception();
      return -1;
    }
  }

  int rates(double t, N_Vector y, N_Vector y_dot) noexcept {
    return guarded([&] {
      unpack(t, entries(y));
      if (!d_.evaluate(at_)) return false;
      d_.kinematic_map(at_, q_dot_);
      entries(y_dot) << q_dot_, d_.nu_dot;
      return true;
    });
  }
  static int rates(double t, N_Vector y, N_Vector y_dot, void* self) {
    return static_cast<Base*>(self)->rates(t, y, y_dot);
  }
  static void keep_message(int, const char*, const char* function, char* text, void* self) {
    static_cast<Base*>(self)->message = std::string(function) + ": " + text;
  }
  bool check(int flag) const { return flag >= 0; }
};

class ErkIntegrator final : public Base {
 public:
  using Base::Base;
  ~ErkIntegrator() override {
    if (memory_ != nullptr) ERKStepFree(&memory_);
  }
  std::string_view name() const override { return "arkode"; }

  bool start(const State& x, double h) override {
    d_.stabilise = 0;
    at_.winding = x.winding;
    if (memory_ == nullptr && !create(x)) return false;
    pack(x, entries(y_.get()));
    return check(ERKStepReInit(memory_, rates, x.t, y_.get())) && check(ERKStepSetInitStep(memory_, h));
  }

  bool step(double t_stop, State& x) override {
    at_.winding = x.winding;
    if (!check(ERKStepSetStopTime(memory_, t_stop))) return false;
    double t = x.t;
    if (!check(ERKStepEvolve(memory_, t_stop, y_.get(), &t, ARK_ONE_STEP))) return false;
    unpack(t, entries(y_.get()));
    x = at_;
    return true;
  }

 private:
  bool create(const State& x) {
    y_.reset(N_VNew_Serial(x.q.size() + x.nu.size(), context_.get));
    pack(x, entries(y_.get()));
    memory_ = ERKStepCreate(rates, x.t, y_.get(), context_.get);
    if (memory_ == nullptr) return false;
    ERKStepSetErrHandlerFn(memory_, keep_message, this);
    ERKStepSetUserData(memory_, this);
    ERKStepSStolerances(memory_, rtol_, atol_);
    ERKStepSetMaxErrTestFails(memory_, failed_steps_allowed);
    ERKStepSetMaxNumSteps(memory_, -1);
    ERKStepSetMaxHnilWarns(memory_, -1);
    ERKStepSetPostprocessStepFn(memory_, project);
    constexpr double high = 1e-6;  // below this tolerance an order of 8 needs fewer evaluations than one of 5
    if (rtol_ >= high) return check(ERKStepSetTableNum(memory_, ARKODE_DORMAND_PRINCE_7_4_5));
    const RungeKutta87 pair = runge_kutta_87();
    ARKodeButcherTable table = ARKodeButcherTable_Create(
        pair.stages, 8, 7, const_cast<double*>(pair.c.data()), const_cast<double*>(pair.A.data()),
        const_cast<double*>(pair.b.data()), const_cast<double*>(pair.b_embedded.data()));
    const bool set = check(ERKStepSetTable(memory_, table));
    ARKodeButcherTable_Free(table);
    return set;
  }
  static int project(double t, N_Vector y, void* self) {
    auto* me = static_cast<ErkIntegrator*>(self);
    return me->guarded([&] {
      me->unpack(t, entries(y));
      if (!std::isfinite(me->d_.project(me->at_))) return false;
      pack(me->at_, entries(y));
      return true;
    });
  }

  void* memory_ = nullptr;
  NVector y_;
};

/// Projection would spoil the history of a multistep method: it integrates equations that draw violations to zero, and what
/// it answers is projected.
class CvodeIntegrator final : public Base {
 public:
  CvodeIntegrator(ModeDynamics& dynamics, double rtol, double atol, bool adams)
      : Base(dynamics, rtol, atol), adams_(adams) {}
  ~CvodeIntegrator() override {
    if (memory_ != nullptr) CVodeFree(&memory_);
  }
  std::string_view name() const override { return adams_ ? "cvode-adams" : "cvode-bdf"; }

  bool start(const State& x, double h) override {
    at_.winding = x.winding;
    const Scales scales = scales_of(d_.model(), x, d_.instant());
    d_.stabilise = scales.speed > 0 ? 2 * scales.speed / scales.length : 0;
    if (memory_ == nullptr && !create(x)) return false;
    pack(x, entries(y_.get()));
    return check(CVodeReInit(memory_, x.t, y_.get())) &&
           check(CVodeSetInitStep(memory_, h > 0 ? 1e-3 * h : 0));
  }

  bool step(double t_stop, State& x) override {
    at_.winding = x.winding;
    if (!check(CVodeSetStopTime(memory_, t_stop))) return false;
    double t = x.t;
    if (!check(CVode(memory_, t_stop, y_.get(), &t, CV_ONE_STEP))) return false;
    unpack(t, entries(y_.get()));
    x = at_;
    return std::isfinite(d_.project(x));
  }

 private:
  bool create(const State& x) {
    const auto n = x.q.size() + x.nu.size();
    y_.reset(N_VNew_Serial(n, context_.get));
    pack(x, entries(y_.get()));
    memory_ = CVodeCreate(adams_ ? CV_ADAMS : CV_BDF, context_.get);
    if (memory_ == nullptr) return false;
    CVodeSetErrHandlerFn(memory_, keep_message, this);
    CVodeInit(memory_, rates, x.t, y_.get());
    CVodeSetUserData(memory_, this);
    CVodeSStolerances(memory_, rtol_, atol_);
    matrix_.reset(SUNDenseMatrix(n, n, context_.get));
    solver_.reset(SUNLinSol_Dense(y_.get(), matrix_.get(), context_.get));
    CVodeSetLinearSolver(memory_, solver_.get(), matrix_.get());
    CVodeSetMaxErrTestFails(memory_, failed_steps_allowed);
    CVodeSetMaxConvFails(memory_, failed_steps_allowed);
    CVodeSetMaxHnilWarns(memory_, -1);
    return check(CVodeSetMaxNumSteps(memory_, -1));
  }

  bool adams_;
  void* memory_ = nullptr;
  NVector y_;
  NMatrix matrix_;
  NSolver solver_;
};

/// 0 = F(t, y, y'), y = (q, nu, lambda, mu), index 2 [GLG85]:
///   q' = G (nu + M^-1 R_p mu),   M nu' = k + L lambda,   R^T nu + dpsi/dt = 0,   psi = 0,
/// R_p the rows that have a psi; mu is zero but for rounding. Nothing is eliminated and nothing differentiated.
class IdaIntegrator final : public Base {
 public:
  using Base::Base;
  ~IdaIntegrator() override { free(); }
  std::string_view name() const override { return "ida"; }

  bool start(const State& x, double) override {
    free();
    at_.winding = x.winding;
    d_.stabilise = 0;
    if (!d_.evaluate(x)) return false;
    const Matrix& V = V_ = d_.basis();
    V_position_ = d_.position_basis();
    rows_ = V.size() > 0 ? V.cols() : d_.row_count();
    position_rows_ =
        V_position_.size() > 0 ? V_position_.cols() : static_cast<Eigen::Index>(d_.position_rows().size());
    const Eigen::Index nx = x.q.size() + x.nu.size(), n = nx + rows_ + position_rows_;
    const auto make = [&] { return NVector(N_VNew_Serial(n, context_.get)); };
    y_ = make(), y_dot_ = make(), id_ = make(), weight_ = make();
    entries(y_.get()).setZero();
    entries(y_dot_.get()).setZero();
    pack(x, entries(y_.get()));
    const Vector& c = d_.multipliers();
    const Vector lambda = V.size() > 0 ? Vector((V.transpose() * V).llt().solve(V.transpose() * c)) : c;
    entries(y_.get()).segment(nx, rows_) = lambda;
    d_.kinematic_map(x, q_dot_);
    entries(y_dot_.get()).head(nx) << q_dot_, d_.nu_dot;
    entries(id_.get()).setZero();
    entries(id_.get()).head(nx).setOnes();
    // multipliers are as accurate as velocities over h: they must not hold up Newton's method
    entries(weight_.get()).setConstant(atol_);
    entries(weight_.get())
        .tail(n - nx)
        .setConstant(std::sqrt(atol_) * std::max(1.0, c.size() > 0 ? c.cwiseAbs().maxCoeff() : 0.0));

    memory_ = IDACreate(context_.get);
    if (memory_ == nullptr) return false;
    IDASetErrHandlerFn(memory_, keep_message, this);
    if (!check(IDAInit(memory_, residual, x.t, y_.get(), y_dot_.get()))) return false;
    IDASetUserData(memory_, this);
    IDASVtolerances(memory_, rtol_, weight_.get());
    matrix_.reset(SUNDenseMatrix(n, n, context_.get));
    solver_.reset(SUNLinSol_Dense(y_.get(), matrix_.get(), context_.get));
    IDASetLinearSolver(memory_, solver_.get(), matrix_.get());
    IDASetJacFn(memory_, jacobian);
    scales_ = scales_of(d_.model(), x, d_.instant());
    IDASetId(memory_, id_.get());
    IDASetSuppressAlg(memory_, SUNTRUE);
    IDASetMaxErrTestFails(memory_, failed_steps_allowed);
    IDASetMaxConvFails(memory_, failed_steps_allowed);
    IDASetMaxNumSteps(memory_, -1);
    // IDA's own first step takes the multipliers for as smooth as the rest: too short for them to be found
    if (scales_.speed > 0) IDASetInitStep(memory_, std::sqrt(rtol_) * scales_.length / scales_.speed);
    return true;
  }

  bool step(double t_stop, State& x) override {
    at_.winding = x.winding;
    if (!check(IDASetStopTime(memory_, t_stop))) return false;
    double t = x.t;
    if (!check(IDASolve(memory_, t_stop, &t, y_.get(), y_dot_.get(), IDA_ONE_STEP))) return false;
    unpack(t, entries(y_.get()));
    x = at_;
    return std::isfinite(d_.project(x));
  }

 private:
  void free() {
    if (memory_ != nullptr) IDAFree(&memory_);
    memory_ = nullptr;
  }

  bool fill(double t, const Eigen::Map<Vector>& y, const Eigen::Map<Vector>& y_dot, Eigen::Map<Vector> F) {
    unpack(t, y);
    ++d_.evaluations;
    if (!y.allFinite() || !d_.rows(at_)) return false;
    const Model& model = d_.model();
    const Eigen::Index nq = model.nq(), nv = model.nv();
    const auto lambda = y.segment(nq + nv, rows_), mu = y.segment(nq + nv + rows_, position_rows_);
    const Matrix &V = V_, &V_p = V_position_;
    Vector force = d_.load(), shift(nv), acceleration;
    force += d_.L() * (V.size() > 0 ? Vector(V * lambda) : Vector(lambda));
    solve_mass(model, d_.instant(), force, acceleration);
    const Matrix R_p = d_.R()(Eigen::all, d_.position_rows());
    solve_mass(model, d_.instant(), R_p * (V_p.size() > 0 ? Vector(V_p * mu) : Vector(mu)), shift);
    F.segment(nq, nv) = y_dot.segment(nq, nv) - acceleration;
    at_.nu += shift;
    d_.kinematic_map(at_, q_dot_);
    F.head(nq) = y_dot.head(nq) - q_dot_;
    const Vector gap = d_.gap()(d_.position_rows());
    if (V.size() > 0)
      F.segment(nq + nv, rows_) = V.transpose() * d_.velocity();
    else
      F.segment(nq + nv, rows_) = d_.velocity();
    if (V_p.size() > 0)
      F.tail(position_rows_) = V_p.transpose() * gap;
    else
      F.tail(position_rows_) = gap;
    return F.allFinite();
  }
  static int residual(double t, N_Vector y, N_Vector y_dot, N_Vector F, void* self) {
    auto* me = static_cast<IdaIntegrator*>(self);
    return me->guarded([&] { return me->fill(t, entries(y), entries(y_dot), entries(F)); });
  }

  /// dF/dy + alpha dF/dy' by differences over a share of what each variable is measured by: those of IDA itself are over a
  /// share of the tolerance where a variable is zero, and drown in rounding.
  bool differentiate(double t, double alpha, const Eigen::Map<Vector>& y, const Eigen::Map<Vector>& y_dot,
                     const Eigen::Map<Vector>& F, SUNMatrix J) {
    constexpr double share = 1e-7;
    const Eigen::Index n = y.size(), nq = d_.model().nq(), nv = d_.model().nv();
    Vector moved = y, changed(n);
    for (Eigen::Index j = 0; j < n; ++j) {
      const double scale = j < nq ? scales_.length : j < nq + nv ? scales_.speed : 1;
      const double size =
          scale > 0 ? scale : atol_ / rtol_;  // all of it at rest in the origin: as the user measures
      const double delta = share * std::max(std::abs(y[j]), size);
      moved[j] = y[j] + delta;
      if (!fill(t, Eigen::Map<Vector>(moved.data(), n), y_dot, Eigen::Map<Vector>(changed.data(), n)))
        return false;
      moved[j] = y[j];
      Eigen::Map<Vector>(SUNDenseMatrix_Column(J, j), n) = (changed - F) / delta;
      if (j < nq + nv) SUNDenseMatrix_Column(J, j)[j] += alpha;
    }
    return true;
  }
  static int jacobian(double t, double alpha, N_Vector y, N_Vector y_dot, N_Vector F, SUNMatrix J, void* self,
                      N_Vector, N_Vector, N_Vector) {
    auto* me = static_cast<IdaIntegrator*>(self);
    return me->guarded(
        [&] { return me->differentiate(t, alpha, entries(y), entries(y_dot), entries(F), J); });
  }

  Matrix V_, V_position_;  // of the forces that are variables: those of the start
  void* memory_ = nullptr;
  Scales scales_;
  Eigen::Index rows_ = 0, position_rows_ = 0;
  NVector y_, y_dot_, id_, weight_;
  NMatrix matrix_;
  NSolver solver_;
};

}  // namespace

bool has_sundials() { return true; }

std::unique_ptr<ModeIntegrator> make_integrator(Integrator kind, ModeDynamics& dynamics, double rtol,
                                                double atol) {
  switch (kind) {
    case Integrator::CvodeAdams:
    case Integrator::CvodeBdf:
      return std::make_unique<CvodeIntegrator>(dynamics, rtol, atol, kind == Integrator::CvodeAdams);
    case Integrator::Ida:
      return std::make_unique<IdaIntegrator>(dynamics, rtol, atol);
    case Integrator::Arkode:
      break;
  }
  return std::make_unique<ErkIntegrator>(dynamics, rtol, atol);
}

}  // namespace perp

#else

namespace perp {

bool has_sundials() { return false; }

std::unique_ptr<ModeIntegrator> make_integrator(Integrator, ModeDynamics&, double, double) { return nullptr; }

}  // namespace perp

#endif
