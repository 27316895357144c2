// DART: dantzig (its boxed LCP, the default). Its own collision detector; the ground is a thick box.
#include <dart/collision/CollisionOption.hpp>
#include <dart/collision/dart/DARTCollisionDetector.hpp>
#include <dart/constraint/BoxedLcpConstraintSolver.hpp>
#include <dart/constraint/DantzigBoxedLcpSolver.hpp>
#include <dart/dynamics/BodyNode.hpp>
#include <dart/dynamics/BoxShape.hpp>
#include <dart/dynamics/FreeJoint.hpp>
#include <dart/dynamics/RevoluteJoint.hpp>
#include <dart/dynamics/Skeleton.hpp>
#include <dart/dynamics/SphereShape.hpp>
#include <dart/dynamics/WeldJoint.hpp>
#include <dart/simulation/World.hpp>

#include "engine.hpp"

namespace peers {
namespace {

namespace dynamics = dart::dynamics;

Eigen::Vector3d vector(const Vec& a) { return {a[0], a[1], a[2]}; }

Eigen::Isometry3d pose(const Vec& x, const Quat& q) {
  Eigen::Isometry3d X = Eigen::Isometry3d::Identity();
  X.translation() = vector(x);
  X.linear() = Eigen::Quaterniond(q[0], q[1], q[2], q[3]).toRotationMatrix();
  return X;
}

class DartWorld final : public World {
 public:
  DartWorld(const Scene& s, double h) {
    world_->setTimeStep(h);
    world_->setGravity(vector(s.gravity));
    auto solver = std::make_unique<dart::constraint::BoxedLcpConstraintSolver>(
        std::make_shared<dart::constraint::DantzigBoxedLcpSolver>());
    solver->setCollisionDetector(dart::collision::DARTCollisionDetector::create());
    world_->setConstraintSolver(std::move(solver));
    world_->getConstraintSolver()->getCollisionOption().maxNumContacts = 100'000;

    if (s.floor) {
      const auto ground = dynamics::Skeleton::create("ground");
      auto* node = ground->createJointAndBodyNodePair<dynamics::WeldJoint>().second;
      node->getParentJoint()->setTransformFromParentBodyNode(pose({0, 0, -5}, {1, 0, 0, 0}));
      give_shape(*node, {.half = {50, 50, 5}}, s.mu);
      world_->addSkeleton(ground);
    }
    if (s.hinges.empty())
      for (const Body& b : s.bodies) add_free(b, s);
    else
      add_chain(s);
  }

  void step() override { world_->step(); }
  Vec centre(std::size_t body) override {
    const Eigen::Vector3d p = bodies_[body]->getTransform().translation();
    return {p.x(), p.y(), p.z()};
  }

 private:
  static void give_shape(dynamics::BodyNode& node, const Body& b, double mu) {
    dynamics::ShapePtr shape;
    if (b.sphere())
      shape = std::make_shared<dynamics::SphereShape>(b.radius);
    else
      shape = std::make_shared<dynamics::BoxShape>(2 * vector(b.half));
    auto* in_node = node.createShapeNodeWith<dynamics::CollisionAspect, dynamics::DynamicsAspect>(shape);
    in_node->getDynamicsAspect()->setFrictionCoeff(mu);
    in_node->getDynamicsAspect()->setRestitutionCoeff(0);
  }
  static void give_mass(dynamics::BodyNode& node, const Body& b) {
    const Vec I = b.inertia();
    dynamics::Inertia inertia;
    inertia.setMass(b.mass);
    inertia.setMoment(I[0], I[1], I[2], 0, 0, 0);
    node.setInertia(inertia);
  }
  void add_free(const Body& b, const Scene& s) {
    const auto skeleton = dynamics::Skeleton::create("body" + std::to_string(bodies_.size()));
    const auto [joint, node] = skeleton->createJointAndBodyNodePair<dynamics::FreeJoint>();
    give_mass(*node, b);
    give_shape(*node, b, s.mu);
    joint->setTransform(pose(b.x, b.q), dynamics::Frame::World());
    joint->setLinearVelocity(vector(b.v));
    joint->setAngularVelocity(vector(b.w));
    world_->addSkeleton(skeleton);
    bodies_.push_back(node);
  }
  void add_chain(const Scene& s) {
    const auto skeleton = dynamics::Skeleton::create("chain");
    dynamics::BodyNode* parent = nullptr;
    Vec parent_x{};
    Quat parent_q{1, 0, 0, 0};
    for (std::size_t i = 0; i < s.bodies.size(); ++i) {
      const Body& b = s.bodies[i];
      const Vec anchor = s.hinges[i].anchor;
      const auto [joint, node] = skeleton->createJointAndBodyNodePair<dynamics::RevoluteJoint>(parent);
      joint->setAxis(Eigen::Vector3d::UnitY());
      joint->setTransformFromParentBodyNode(pose(turned_back(parent_q, anchor - parent_x),
                                                 i == 0 ? b.q : Quat{1, 0, 0, 0}));  // all rods start alike
      joint->setTransformFromChildBodyNode(pose(turned_back(b.q, anchor - b.x), {1, 0, 0, 0}));
      give_mass(*node, b);
      parent = node, parent_x = b.x, parent_q = b.q;
      bodies_.push_back(node);
    }
    world_->addSkeleton(skeleton);
  }

  dart::simulation::WorldPtr world_ = dart::simulation::World::create();
  std::vector<dynamics::BodyNode*> bodies_;
};

}  // namespace
}  // namespace peers

int main(int argc, char** argv) {
  return peers::measure(argc, argv, "DART", PEER_VERSION,
                        [](const peers::Scene& s, const std::string&, double h) {
                          return std::make_unique<peers::DartWorld>(s, h);
                        });
}
