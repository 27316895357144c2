// Simbody: rkm (Runge-Kutta-Merson under error control, compliant contact of 1e8 N/m, transition at 1e-4 m/s), cpodes. `h` is the
// accuracy. A box is a sphere of 5 cm at each corner of its base; there is no box on box.
#include <Simbody.h>
#include <simmath/CPodesIntegrator.h>

#include "engine.hpp"

namespace peers {
namespace {

SimTK::Vec3 vector(const Vec& a) { return {a[0], a[1], a[2]}; }
SimTK::Rotation rotation(const Quat& q) { return SimTK::Rotation(SimTK::Quaternion(q[0], q[1], q[2], q[3])); }

class SimbodyWorld final : public World {
 public:
  SimbodyWorld(const Scene& s, const std::string& configuration, double accuracy) : t_end_(s.t_end) {
    using namespace SimTK;
    Force::UniformGravity(forces_, matter_, vector(s.gravity));
    contact_.setTransitionVelocity(1e-4);
    const ContactMaterial material(1e8, 1, s.mu, s.mu, 0);
    if (s.floor)  // a half space is solid where its x > 0
      matter_.Ground().updBody().addContactSurface(Transform(Rotation(Pi / 2, YAxis), SimTK::Vec3(0)),
                                                   ContactSurface(ContactGeometry::HalfSpace(), material));
    MobilizedBody parent = matter_.Ground();
    Vec parent_x{};
    Quat parent_q{1, 0, 0, 0};
    const Rotation to_axis(-Pi / 2, XAxis);  // a pin turns about its z, the hinges about y
    for (std::size_t i = 0; i < s.bodies.size(); ++i) {
      const peers::Body& b = s.bodies[i];
      const peers::Vec I = b.inertia();
      SimTK::Body::Rigid body(MassProperties(b.mass, SimTK::Vec3(0), SimTK::Inertia(I[0], I[1], I[2])));
      const double small = 0.05;
      if (s.floor && b.sphere())
        body.addContactSurface(Transform(), ContactSurface(ContactGeometry::Sphere(b.radius), material));
      else if (s.floor)
        for (const int x : {-1, 1})
          for (const int y : {-1, 1})
            body.addContactSurface(Transform(SimTK::Vec3(x * b.half[0], y * b.half[1], small - b.half[2])),
                                   ContactSurface(ContactGeometry::Sphere(small), material));
      if (s.hinges.empty()) {
        bodies_.push_back(MobilizedBody::Free(matter_.Ground(), Transform(), body, Transform()));
        continue;
      }
      const Vec anchor = s.hinges[i].anchor;
      const Transform in_parent(i ? to_axis : rotation(b.q) * to_axis,
                                vector(turned_back(parent_q, anchor - parent_x)));
      const Transform in_body(to_axis, vector(turned_back(b.q, anchor - b.x)));
      bodies_.push_back(MobilizedBody::Pin(parent, in_parent, body, in_body));
      parent = bodies_.back(), parent_x = b.x, parent_q = b.q;
    }
    SimTK::State state = system_.realizeTopology();
    for (std::size_t i = 0; s.hinges.empty() && i < bodies_.size(); ++i) {
      const peers::Body& b = s.bodies[i];
      bodies_[i].setQToFitTransform(state, Transform(rotation(b.q), vector(b.x)));
      bodies_[i].setUToFitVelocity(state, SpatialVec(vector(b.w), vector(b.v)));
    }
    if (configuration == "cpodes")
      integrator_ = std::make_unique<CPodesIntegrator>(system_);
    else
      integrator_ = std::make_unique<RungeKuttaMersonIntegrator>(system_);
    integrator_->setAccuracy(accuracy);
    stepper_ = std::make_unique<TimeStepper>(system_, *integrator_);
    stepper_->initialize(state);
  }

  void step() override { stepper_->stepTo(t_end_); }
  Vec centre(std::size_t body) override {
    const SimTK::State& state = integrator_->getState();
    system_.realize(state, SimTK::Stage::Position);
    const SimTK::Vec3 p = bodies_[body].getBodyOriginLocation(state);
    return {p[0], p[1], p[2]};
  }
  bool whole_run() const override { return true; }
  long steps() const override { return integrator_->getNumStepsTaken(); }

 private:
  SimTK::MultibodySystem system_;
  SimTK::SimbodyMatterSubsystem matter_{system_};
  SimTK::GeneralForceSubsystem forces_{system_};
  SimTK::ContactTrackerSubsystem tracker_{system_};
  SimTK::CompliantContactSubsystem contact_{system_, tracker_};
  std::unique_ptr<SimTK::Integrator> integrator_;
  std::unique_ptr<SimTK::TimeStepper> stepper_;
  std::vector<SimTK::MobilizedBody> bodies_;
  double t_end_;
};

}  // namespace
}  // namespace peers

int main(int argc, char** argv) {
  return peers::measure(
      argc, argv, "Simbody", PEER_VERSION,
      [](const peers::Scene& s, const std::string& c, double h) -> std::unique_ptr<peers::World> {
        if (s.bodies.size() > 2) return nullptr;
        return std::make_unique<peers::SimbodyWorld>(s, c, h);
      });
}
