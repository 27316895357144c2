// Bullet in double: si10 (sequential impulses, ten sweeps, as it comes), si200 (200 sweeps), dantzig (its direct LCP solver).
// The ground is a thick box: a box on it then has its four corners at once.
#include <btBulletDynamicsCommon.h>
#include <BulletDynamics/MLCPSolvers/btDantzigSolver.h>
#include <BulletDynamics/MLCPSolvers/btMLCPSolver.h>
#include <cmath>

#include "engine.hpp"

namespace peers {
namespace {

btVector3 vector(const Vec& a) { return {a[0], a[1], a[2]}; }

class BulletWorld final : public World {
 public:
  BulletWorld(const Scene& s, const std::string& configuration, double h) : h_(h) {
    if (configuration == "dantzig")
      solver_ = std::make_unique<btMLCPSolver>(&dantzig_);
    else
      solver_ = std::make_unique<btSequentialImpulseConstraintSolver>();
    world_ =
        std::make_unique<btDiscreteDynamicsWorld>(&dispatcher_, &broad_phase_, solver_.get(), &collisions_);
    world_->setGravity(vector(s.gravity));
    if (configuration == "si200") world_->getSolverInfo().m_numIterations = 200;
    if (configuration == "dantzig") world_->getSolverInfo().m_minimumSolverBatchSize = 1;

    if (s.floor) add({.half = {50, 50, 5}, .mass = 0, .x = {0, 0, -5}}, s);
    first_ = int(bodies_.size());
    for (const Body& b : s.bodies) add(b, s);
    for (const Hinge& j : s.hinges) {
      btRigidBody& b = *bodies_[std::size_t(first_ + j.b)];
      const btTransform from_b = b.getWorldTransform().inverse();
      const btVector3 at_b = from_b * vector(j.anchor), axis_b = from_b.getBasis() * vector(j.axis);
      if (j.a < 0) {
        hinges_.push_back(std::make_unique<btHingeConstraint>(b, at_b, axis_b));
      } else {
        btRigidBody& a = *bodies_[std::size_t(first_ + j.a)];
        const btTransform from_a = a.getWorldTransform().inverse();
        hinges_.push_back(std::make_unique<btHingeConstraint>(a, b, from_a * vector(j.anchor), at_b,
                                                              from_a.getBasis() * vector(j.axis), axis_b));
      }
      world_->addConstraint(hinges_.back().get(), true);
    }
  }
  ~BulletWorld() override {
    for (const auto& j : hinges_) world_->removeConstraint(j.get());
    for (const auto& b : bodies_) world_->removeRigidBody(b.get());
  }

  void step() override { world_->stepSimulation(h_, 0); }
  Vec centre(std::size_t body) override {
    const btVector3& x = bodies_[std::size_t(first_) + body]->getWorldTransform().getOrigin();
    return {x.x(), x.y(), x.z()};
  }

 private:
  void add(const Body& b, const Scene& s) {
    if (b.sphere())
      shapes_.push_back(std::make_unique<btSphereShape>(b.radius));
    else
      shapes_.push_back(std::make_unique<btBoxShape>(vector(b.half)));
    btRigidBody::btRigidBodyConstructionInfo info(b.mass, nullptr, shapes_.back().get(), vector(b.inertia()));
    info.m_startWorldTransform = btTransform(btQuaternion(b.q[1], b.q[2], b.q[3], b.q[0]), vector(b.x));
    info.m_friction = std::sqrt(s.mu);  // the two surfaces' are multiplied
    bodies_.push_back(std::make_unique<btRigidBody>(info));
    btRigidBody& body = *bodies_.back();
    body.setActivationState(DISABLE_DEACTIVATION);
    body.setLinearVelocity(vector(b.v));
    body.setAngularVelocity(vector(b.w));
    if (s.floor)
      world_->addRigidBody(&body);
    else
      world_->addRigidBody(&body, 1, 0);  // touches nothing
  }

  btDefaultCollisionConfiguration collisions_;
  btCollisionDispatcher dispatcher_{&collisions_};
  btDbvtBroadphase broad_phase_;
  btDantzigSolver dantzig_;
  std::unique_ptr<btSequentialImpulseConstraintSolver> solver_;
  std::unique_ptr<btDiscreteDynamicsWorld> world_;
  std::vector<std::unique_ptr<btCollisionShape>> shapes_;
  std::vector<std::unique_ptr<btRigidBody>> bodies_;
  std::vector<std::unique_ptr<btTypedConstraint>> hinges_;
  double h_;
  int first_ = 0;
};

}  // namespace
}  // namespace peers

int main(int argc, char** argv) {
  return peers::measure(argc, argv, "Bullet", PEER_VERSION,
                        [](const peers::Scene& s, const std::string& c, double h) {
                          return std::make_unique<peers::BulletWorld>(s, c, h);
                        });
}
