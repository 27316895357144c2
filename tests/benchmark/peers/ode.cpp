// ODE: step (its direct LCP), stepfdir (with the first direction of friction along the slip), quick20 (20 sweeps).
#include <ode/ode.h>
#include <cstdlib>

#include "engine.hpp"

namespace peers {
namespace {

class OdeWorld final : public World {
 public:
  OdeWorld(const Scene& s, const std::string& configuration, double h)
      : h_(h),
        mu_(s.mu),
        quick_(configuration.starts_with("quick")),
        along_slip_(configuration == "stepfdir") {
    static const int started = dInitODE2(0);
    (void)started;
    world_ = dWorldCreate(), space_ = dHashSpaceCreate(nullptr), contacts_ = dJointGroupCreate(0);
    dRandSetSeed(1);
    dWorldSetGravity(world_, s.gravity[0], s.gravity[1], s.gravity[2]);
    if (quick_) dWorldSetQuickStepNumIterations(world_, std::atoi(configuration.c_str() + 5));
    if (s.floor) dCreatePlane(space_, 0, 0, 1, 0);
    for (const Body& b : s.bodies) {
      const dBodyID body = dBodyCreate(world_);
      const Vec I = b.inertia();
      dMass mass;
      dMassSetParameters(&mass, b.mass, 0, 0, 0, I[0], I[1], I[2], 0, 0, 0);
      dBodySetMass(body, &mass);
      dBodySetPosition(body, b.x[0], b.x[1], b.x[2]);
      dBodySetQuaternion(body, b.q.data());
      dBodySetLinearVel(body, b.v[0], b.v[1], b.v[2]);
      dBodySetAngularVel(body, b.w[0], b.w[1], b.w[2]);
      if (s.floor)
        dGeomSetBody(b.sphere() ? dCreateSphere(space_, b.radius)
                                : dCreateBox(space_, 2 * b.half[0], 2 * b.half[1], 2 * b.half[2]),
                     body);
      bodies_.push_back(body);
    }
    for (const Hinge& j : s.hinges) {
      const dJointID hinge = dJointCreateHinge(world_, nullptr);
      dJointAttach(hinge, bodies_[std::size_t(j.b)], j.a < 0 ? nullptr : bodies_[std::size_t(j.a)]);
      dJointSetHingeAnchor(hinge, j.anchor[0], j.anchor[1], j.anchor[2]);
      dJointSetHingeAxis(hinge, j.axis[0], j.axis[1], j.axis[2]);
    }
    collide_ = s.floor;
  }
  ~OdeWorld() override {
    dJointGroupDestroy(contacts_);
    dSpaceDestroy(space_);
    dWorldDestroy(world_);
  }

  void step() override {
    if (collide_) dSpaceCollide(space_, this, near);
    if (quick_)
      dWorldQuickStep(world_, h_);
    else
      dWorldStep(world_, h_);
    dJointGroupEmpty(contacts_);
  }
  Vec centre(std::size_t body) override {
    const dReal* x = dBodyGetPosition(bodies_[body]);
    return {x[0], x[1], x[2]};
  }

 private:
  static void near(void* self, dGeomID one, dGeomID other) {
    OdeWorld& o = *static_cast<OdeWorld*>(self);
    const dBodyID a = dGeomGetBody(one), b = dGeomGetBody(other);
    if (!a && !b) return;
    dContact contact[16];
    const int n = dCollide(one, other, 16, &contact[0].geom, sizeof(dContact));
    for (int i = 0; i < n; ++i) {
      contact[i].surface.mode = dContactApprox1;
      contact[i].surface.mu = o.mu_;
      if (o.along_slip_) {
        dVector3 va{}, vb{};
        const dReal *p = contact[i].geom.pos, *normal = contact[i].geom.normal;
        if (a) dBodyGetPointVel(a, p[0], p[1], p[2], va);
        if (b) dBodyGetPointVel(b, p[0], p[1], p[2], vb);
        const Vec along{normal[0], normal[1], normal[2]}, u{va[0] - vb[0], va[1] - vb[1], va[2] - vb[2]};
        const Vec slip = u - (u[0] * along[0] + u[1] * along[1] + u[2] * along[2]) * along;
        if (norm(slip) > 1e-9) {
          contact[i].surface.mode |= dContactFDir1;
          for (std::size_t k = 0; k < 3; ++k) contact[i].fdir1[k] = slip[k] / norm(slip);
        }
      }
      dJointAttach(dJointCreateContact(o.world_, o.contacts_, &contact[i]), a, b);
    }
  }

  dWorldID world_;
  dSpaceID space_;
  dJointGroupID contacts_;
  std::vector<dBodyID> bodies_;
  double h_, mu_;
  bool quick_, along_slip_, collide_ = false;
};

}  // namespace
}  // namespace peers

int main(int argc, char** argv) {
  return peers::measure(argc, argv, "ODE", PEER_VERSION,
                        [](const peers::Scene& s, const std::string& c, double h) {
                          return std::make_unique<peers::OdeWorld>(s, c, h);
                        });
}
