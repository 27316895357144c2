// Siconos: nsgs8 (Moreau-Jean, theta = 1/2, projected Gauss-Seidel to 1e-8), nsn (Newton on the Alart-Curnier function). Collisions by
// Bullet in single precision, as packaged; the ground is a box. It has joints, which are not tried here.
#include <MechanicsFwd.hpp>  // before all others: it says which shapes there are to visit

// Its parts.
#include <SolverOptions.h>
#include <FrictionContact.hpp>
#include <RigidBodyDS.hpp>
#include <SiconosBodies.hpp>
#include <SiconosBulletCollisionManager.hpp>
#include <SiconosContactor.hpp>
#include <SiconosKernel.hpp>
#include <SiconosShape.hpp>

#include "engine.hpp"

namespace peers {
namespace {

std::shared_ptr<SiconosVector> vector(std::initializer_list<double> entries) {
  auto v = std::make_shared<SiconosVector>(unsigned(entries.size()));
  unsigned i = 0;
  for (const double x : entries) v->setValue(i++, x);
  return v;
}

class SiconosWorld final : public World {
 public:
  SiconosWorld(const Scene& s, const std::string& configuration, double h) {
    const bool spheres = s.bodies[0].sphere(), newton = configuration == "nsn";
    const auto system = std::make_shared<NonSmoothDynamicalSystem>(0., s.t_end + 10 * h);
    for (const Body& b : s.bodies) {
      const Vec I = b.inertia(), w = turned_back(b.q, b.w);
      const auto inertia = std::make_shared<SimpleMatrix>(3, 3);
      inertia->zero();
      for (unsigned k = 0; k < 3; ++k) inertia->setValue(k, k, I[k]);
      const auto body =
          std::make_shared<RigidBodyDS>(vector({b.x[0], b.x[1], b.x[2], b.q[0], b.q[1], b.q[2], b.q[3]}),
                                        vector({b.v[0], b.v[1], b.v[2], w[0], w[1], w[2]}), b.mass, inertia);
      body->setFExtPtr(vector({b.mass * s.gravity[0], b.mass * s.gravity[1], b.mass * s.gravity[2]}));
      body->setContactors(contactor(b));
      system->insertDynamicalSystem(body);
      bodies_.push_back(body);
    }
    simulation_ = std::make_shared<TimeStepping>(system, std::make_shared<TimeDiscretisation>(0., h));
    simulation_->insertIntegrator(std::make_shared<MoreauJeanOSI>(0.5));
    const auto friction =
        std::make_shared<FrictionContact>(3, newton ? SICONOS_FRICTION_3D_NSN_AC : SICONOS_FRICTION_3D_NSGS);
    friction->numericsSolverOptions()->dparam[SICONOS_DPARAM_TOL] = 1e-8;
    friction->numericsSolverOptions()->iparam[SICONOS_IPARAM_MAX_ITER] = newton ? 200 : 10'000;
    friction->setMStorageType(NM_SPARSE_BLOCK);
    friction->setMaxSize(65'536);
    friction->setNumericsVerboseMode(0);
    friction->setKeepLambdaAndYState(true);
    simulation_->insertNonSmoothProblem(friction);

    SiconosBulletOptions options;
    options.worldScale = 1;
    options.contactBreakingThreshold = 0.02;
    options.perturbationIterations = options.minimumPointsPerturbationThreshold = spheres ? 0 : 150;
    collisions_ = std::make_shared<SiconosBulletCollisionManager>(options);
    collisions_->insertNonSmoothLaw(std::make_shared<NewtonImpactFrictionNSL>(0., 0., s.mu, 3), 0, 0);
    Body ground;
    ground.half = {10, 10, 0.5};
    collisions_->insertStaticContactorSet(contactor(ground), vector({0, 0, -0.5, 1, 0, 0, 0}));
    simulation_->insertInteractionManager(collisions_);
    simulation_->setNewtonOptions(spheres ? SICONOS_TS_LINEAR : SICONOS_TS_NONLINEAR);
    simulation_->setNewtonMaxIteration(2);
    simulation_->setNewtonTolerance(1e-10);
    simulation_->setWarnOnNonConvergence(false);
    simulation_->setDisplayNewtonConvergence(false);
  }

  void step() override {
    simulation_->computeOneStep();
    simulation_->nextStep();
  }
  Vec centre(std::size_t body) override {
    const SiconosVector& q = *bodies_[body]->q();
    return {q(0), q(1), q(2)};
  }

 private:
  static std::shared_ptr<SiconosContactorSet> contactor(const Body& b) {
    std::shared_ptr<SiconosShape> shape;
    if (b.sphere())
      shape = std::make_shared<SiconosSphere>(b.radius);
    else
      shape = std::make_shared<SiconosBox>(2 * b.half[0], 2 * b.half[1], 2 * b.half[2]);
    shape->setInsideMargin(b.sphere() ? 0.1 * b.radius : 0.05);
    shape->setOutsideMargin(0);
    auto set = std::make_shared<SiconosContactorSet>();
    set->push_back(std::make_shared<SiconosContactor>(shape));
    return set;
  }

  std::shared_ptr<TimeStepping> simulation_;
  std::shared_ptr<SiconosBulletCollisionManager> collisions_;
  std::vector<std::shared_ptr<RigidBodyDS>> bodies_;
};

}  // namespace
}  // namespace peers

int main(int argc, char** argv) {
  return peers::measure(
      argc, argv, "Siconos", PEER_VERSION,
      [](const peers::Scene& s, const std::string& c, double h) -> std::unique_ptr<peers::World> {
        if (!s.hinges.empty()) return nullptr;
        return std::make_unique<peers::SiconosWorld>(s, c, h);
      });
}
