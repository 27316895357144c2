// perp: lcp, lcp16 (16 edges), ncp, ncp2 (h is the step); event, event-adams, extrapolated (h is the tolerance).
// A step that does not reach its tolerance leaves the state where it was; the run then ends with an error.
#include <perp/perp.hpp>
#include <stdexcept>

#include "engine.hpp"

namespace peers {
namespace {

perp::Vector3 vector(const Vec& a) { return {a[0], a[1], a[2]}; }

class PerpWorld final : public World {
 public:
  PerpWorld(const Scene& s, const std::string& configuration, double h) : h_(h), t_end_(s.t_end) {
    model_.set_gravity(vector(s.gravity));
    for (const Body& b : s.bodies)
      bodies_.push_back(model_.add_body(b.sphere() ? perp::Inertia::solid_sphere(b.mass, b.radius)
                                                   : perp::Inertia::solid_box(b.mass, vector(2 * b.half)),
                                        {.pose = {.p = vector(b.x), .q = {b.q[0], b.q[1], b.q[2], b.q[3]}}}));
    for (std::size_t i = 0; s.floor && i < s.bodies.size(); ++i) {
      const Body& b = s.bodies[i];
      const perp::Vector3 size = vector(2 * b.half);
      if (b.sphere())
        model_.add_contact(perp::ground, bodies_[i], perp::sphere_on_plane(b.radius), {.mu = s.mu});
      else if (i == 0)
        model_.add_contact(perp::ground, bodies_[i], perp::box_on_plane(size), {.mu = s.mu});
      else
        model_.add_contact(bodies_[i - 1], bodies_[i],
                           perp::box_on_box(vector(2 * s.bodies[i - 1].half), size), {.mu = s.mu});
    }
    for (const Hinge& j : s.hinges) {
      const perp::BodyId a = j.a < 0 ? perp::ground : bodies_[std::size_t(j.a)];
      model_.add_joint(
          perp::revolute(a, bodies_[std::size_t(j.b)], {.point = vector(j.anchor), .axis = vector(j.axis)}));
    }
    x_ = model_.rest();
    for (std::size_t i = 0; i < bodies_.size(); ++i)
      model_.set_velocity(x_, bodies_[i], vector(s.bodies[i].v), vector(s.bodies[i].w));

    perp::MethodOptions options;
    options.tolerance = h;
    if (configuration == "lcp16") options.edges = 16;
    if (configuration == "event-adams") options.integrator = perp::Integrator::CvodeAdams;
    const std::string method =
        configuration.starts_with("lcp") ? "lcp" : configuration.substr(0, configuration.find('-'));
    if (method != "event" && method != "extrapolated") options.tolerance = perp::MethodOptions{}.tolerance;
    stepper_ = perp::make_stepper(method, options);
    adaptive_ = dynamic_cast<perp::AdaptiveStepper*>(stepper_.get());
  }

  void step() override {
    if (adaptive_) {
      perp::Trajectory run(x_, 0);
      need(adaptive_->run(model_, run, {.t_end = t_end_}));
      steps_ = static_cast<long>(run.steps());
      x_ = run.back();
      return;
    }
    stepper_->step(model_, x_, {.h = h_, .t_end = double(++steps_) * h_}, report_);
    need(report_);
  }

  Vec centre(std::size_t body) override {
    const perp::Vector3 p = model_.pose(x_, bodies_[body]).p;
    return {p.x(), p.y(), p.z()};
  }
  bool whole_run() const override { return adaptive_ != nullptr; }
  long steps() const override { return steps_; }

 private:
  static void need(const perp::StepReport& report) {
    if (!report.advanced()) throw std::runtime_error(report.message);
  }

  perp::Model model_;
  perp::State x_;
  std::vector<perp::BodyId> bodies_;
  std::unique_ptr<perp::Stepper> stepper_;
  perp::AdaptiveStepper* adaptive_ = nullptr;
  perp::StepReport report_;
  double h_, t_end_;
  long steps_ = 0;
};

}  // namespace
}  // namespace peers

int main(int argc, char** argv) {
  return peers::measure(argc, argv, "perp", PERP_VERSION,
                        [](const peers::Scene& s, const std::string& c, double h) {
                          return std::make_unique<peers::PerpWorld>(s, c, h);
                        });
}
