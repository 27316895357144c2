#include "step/certificate/closeness.hpp"

#include "core/index.hpp"

namespace perp::closeness {
namespace {

constexpr double joint_terms = 32;  // a row turns anchors and adds four positions

}  // namespace

bool is_angular(const Model& model, const WrenchMap<3>& W, int column) {
  const auto no_lever = [&](int body, int n, const WrenchMap<3>::Block& block) {
    if (n == 0) return true;
    const BodyKind kind = model.bodies()[at(body)].kind;
    if (kind == BodyKind::Generalized) return false;
    return block.col(column).head(kind == BodyKind::Planar ? 2 : 3).isZero(0);
  };
  return W.na + W.nb > 0 && no_lever(W.a, W.na, W.A) && no_lever(W.b, W.nb, W.B);
}

double gap_rounding(const Model& model, const Instant& s, const State& x, const ContactInstant& c) {
  const Contact& contact = model.contact(c.contact).law;
  if (contact.stop.joint >= 0)
    return joint_rounding(model, s, s.coordinate({contact.stop.joint}, contact.stop.coordinate));
  if (contact.own) {
    const Body& b = model.body(contact.b);
    return terms * eps * x.q.segment(b.q0, b.nq).lpNorm<1>();
  }
  double sizes = 0;
  for (const int body : {c.W.a, c.W.b}) {
    const Vector3& p = s.X[at(body)].p;
    sizes += p.lpNorm<Eigen::Infinity>() + (c.position - p).lpNorm<Eigen::Infinity>();
  }
  return terms * eps * sizes;
}

double joint_rounding(const Model& model, const Instant& s, const JointRowInstant& row) {
  if (row.world.linear.isZero(0)) return joint_terms * eps * std::max(1.0, std::abs(row.psi_b));
  const JointGeometry& j = model.joint({row.joint});
  double length = std::max(j.anchor_a.norm(), j.anchor_b.norm());
  for (const int body : {j.a.index, j.b.index}) {
    const Body& b = model.bodies()[at(body)];
    length = std::max(length, s.X[at(body)].p.norm());
    if (b.mass > 0)
      length = std::max(length, std::sqrt(b.J.trace() / b.mass));  // of one that turns about the origin
  }
  return joint_terms * eps * length;
}

double joint_misfit(const Model& model, const Instant& s) {
  double worst = 0;
  for (const JointRowInstant& row : s.joint_rows)
    if (row.psi_b != 0) worst = std::max(worst, std::abs(row.psi_b) / joint_rounding(model, s, row));
  return worst;
}

}  // namespace perp::closeness
