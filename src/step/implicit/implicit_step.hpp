// What the implicit methods share: reactions made from an Instant, slopes by the velocity that moves q, the report.
#pragma once

#include "perp/instant/derivatives.hpp"
#include "perp/step/stepper.hpp"
#include "step/certificate/step_answer.hpp"
#include "step/implicit/nonsmooth_newton.hpp"

namespace perp {

/// Impulses of the last step, first guesses of the next: by contact point (world axes), joint row and joint friction.
struct LastImpulses {
  PointTable<Vector3> contact{Vector3::Zero()};
  PointTable<Vector3> moment{
      Vector3::Zero()};  ///< of the same points, world axes; empty where no contact has moments
  std::vector<double> row, friction;
  double h = 0;
  State end;  ///< where that step ended
  std::uint64_t revision = 0;

  /// All zero unless the step that starts at x goes on from that one.
  void prepare(const Model& model, const Instant& s, const State& x);
};

/// The reactions of a step: of the contacts that may close in it, and of all joints. Joint friction is bounded by c_max h_p.
class StepReactions {
 public:
  /// Contacts that close within h at the velocity x.nu or `nu`, that of no reactions. First guesses: p from `last`, in
  /// proportion to h_p, and nu moved by it; p of joint rows is zero, so that of redundant rows none grows from step to step.
  void begin(const Model& model, const Instant& s, const State& x, double h, double h_p,
             const LastImpulses& last, const StepSpeeds& speeds, Vector& nu);
  /// Adds the contacts that were left out and overlap at `end`, those too that came into being within the step, with W as they are
  /// there, and keeps the others' p; false if there are none.
  bool add_overlapping(const Instant& s, const StepSpeeds& speeds, const Instant& end);

  std::vector<Reaction> all;

 private:
  void add_contact(const Instant& s, const ContactInstant& c, const Vector3& p, const Vector3& moment,
                   const StepSpeeds& speeds);

  std::vector<char> taken_;    // of the start's contacts
  std::vector<int> appeared_;  // points that it does not have
};

/// The contact of s that r is about: null for joints and moments, and for a point that s does not have.
const ContactInstant* contact_of(const Reaction& r, const Instant& s);
/// The moments of s that r is about: null for all else, and for a point that s does not have.
const MomentInstant* moments_of(const Reaction& r, const Instant& s);

/// The bodies that impacts change: those that meet, and those that reactions tie to them.
class StruckBodies {
 public:
  void clear(const Model& model) { struck_.assign(model.bodies().size(), 0), any_ = false; }
  bool add(const Reaction& r);  ///< false if it adds none
  void spread(const std::vector<Reaction>& all);

  bool any() const { return any_; }
  bool operator[](std::size_t body) const { return struck_[body] != 0; }
  const std::vector<char>& bodies() const { return struck_; }
  bool touches(const Reaction& r) const;

 private:
  std::vector<char> struck_;
  bool any_ = false;
};

/// W^T as slopes by both bodies' velocities.
Reaction::Slope slopes_of(const WrenchMap<3>& W);

/// How q+ = q ⊕ h nu moves with nu, over h: the identity; for rotations the exponential map's Jacobian at h w.
class Motion {
 public:
  Motion(const Model& model, const Vector& nu, double h) : model_(model), nu_(nu), h_(h) {}
  /// Slopes by xi at q+ turned into slopes by nu, over h.
  template <class Derived>
  void turn(const WrenchMap<3>& W, Eigen::MatrixBase<Derived>& slopes) const {
    turn_body(W.a, slopes.template leftCols<6>());
    turn_body(W.b, slopes.template rightCols<6>());
  }
  /// The same for one body's six columns.
  template <class Block>
  void turn_body(int body, Block&& columns) const {
    const Body& b = model_.bodies()[static_cast<std::size_t>(body)];
    if (b.kind != BodyKind::Spatial) return;
    const Matrix3 J = rotation_jacobian(h_ * nu_.template segment<3>(b.v0 + 3));
    columns.template rightCols<3>() = (columns.template rightCols<3>() * J).eval();
  }
  double h() const { return h_; }

 private:
  const Model& model_;
  const Vector& nu_;
  double h_;
};

/// -h_nu dk/dnu - h_q dk/dxi of the loads, the latter moved by `motion`.
void add_loads(const std::vector<LoadDerivative>& loads, double h_nu, double h_q, const Motion& motion,
               std::vector<Coupling>& K);
/// -h times d(W p)/dxi, moved by `motion`.
void add_turning(const WrenchMap<3>& W, Eigen::Matrix<double, 12, 12> force, const Motion& motion,
                 std::vector<Coupling>& K);

/// u = Wᵀ nu + bias of a reaction at velocity level: explicit velocities and restitution in the bias.
struct RelativeVelocity {
  WrenchMap<3> W;
  Vector3 bias = Vector3::Zero();
};

/// The equations at a fixed configuration, for the velocity alone:
///   M nu - momentum = sum W p,     u = (a reaction's RelativeVelocity),   M that of `instant`
class VelocityLevel final : public StepProblem {
 public:
  VelocityLevel(const Model& model, const Instant& instant, const Vector& momentum,
                const std::vector<RelativeVelocity>& velocities)
      : model_(model), instant_(instant), momentum_(momentum), velocities_(velocities) {}
  bool evaluate(const Vector& nu, std::span<Reaction> reactions, Vector& R) override;
  void differentiate(std::span<Reaction> reactions, std::vector<Coupling>& K) override;

 private:
  const Model& model_;
  const Instant& instant_;
  const Vector& momentum_;
  const std::vector<RelativeVelocity>& velocities_;
};

[[nodiscard]] Law law_of(const ContactInstant& c);

/// Whether loads but gyroscopic terms depend on velocities, or on the configuration.
[[nodiscard]] bool loads_vary(const Model& model, const Instant& s);

/// The state to which a step of `request` from x goes at nu, and everything there; `near` are the contacts to look at. False where it is not
/// finite.
[[nodiscard]] bool move_to_end(const Model& model, const State& x, const StepRequest& request,
                               const Vector& nu, const Instant& start, const std::vector<int>* near,
                               State& moved, Instant& end);

/// Newton's options for equations whose positions move with nu, from x over h.
NonsmoothNewton::Options moving_from(const Model& model, const State& x, double h,
                                     NonsmoothNewton::Options options);

/// Whether a contact slips at `speed`s of the step: u along t, o is more than rounding.
bool slips(const Reaction& r, double speed);

/// The report of a step that stays where it is.
void give_up(StepReport& report, StepStatus status, std::string why);
/// The report of a step whose equations `what` ("the first stage's residual") leaves above `tolerance`: by how much, and joints that disagree.
void give_up(const Model& model, const State& x, const StepRequest& request, std::string_view what,
             const StepResiduals& e, double tolerance, StepReport& report);

/// A report without contact and joint rows.
void begin_reactions(const Model& model, StepReport& report);

/// Contact rows and joint impulses of the report. Called once a stage; rows of one point add up. Of a step in two halves, `half` 1
/// and 2, each makes rows of its own too.
void report_reactions(const Model& model, const Instant& s, const std::vector<Reaction>& reactions,
                      double speed, StepReport& report, int half = 0);

/// The reactions' impulses as the certificate reads them.
void list_impulses(const std::vector<Reaction>& reactions, std::vector<Acting>& all);

/// What is the same for all: gaps and joints at the end.
void report_end(const Instant& end, const State& moved, StepReport& report);

/// Keeps the report's impulses for the next step.
void keep_impulses(const Model& model, const std::vector<Reaction>& reactions, const StepReport& report,
                   const State& end, LastImpulses& last);

}  // namespace perp
