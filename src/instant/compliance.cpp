#include "instant/compliance.hpp"

#include <algorithm>
#include <cmath>

namespace perp {
namespace {

bool in_metres(JointRow::Kind kind) {
  return kind == JointRow::Kind::Point || kind == JointRow::Kind::Distance || kind == JointRow::Kind::Screw;
}

/// [m²]; 0 of what does not turn or is not moved by forces.
double gyration_squared(const Body& b) {
  if (b.kind == BodyKind::Planar) return b.J(2, 2) / b.mass;
  return b.kind == BodyKind::Spatial ? b.J.trace() / (2 * b.mass) : 0;
}

double compliance_of(const Model& model, const JointGeometry& joint, const JointRow& row) {
  if (in_metres(row.kind)) return 1;
  return 1 / std::max(gyration_squared(model.body(joint.a)), gyration_squared(model.body(joint.b)));
}

}  // namespace

double compliance_of(const Model& model, const ContactInstant& contact) {
  const Contact& pair = model.contact(contact.contact).law;
  const Contact::Stop& stop = pair.stop;
  if (stop.joint < 0) return pair.compliance;
  const JointGeometry& joint = model.joint({stop.joint});
  return compliance_of(model, joint, joint.coordinates[static_cast<std::size_t>(stop.coordinate)].row);
}

double moments_compliance_of(const Model& model, const ContactInstant& contact) {
  const Contact& pair = model.contact(contact.contact).law;
  return pair.compliance /
         std::max(gyration_squared(model.body(pair.a)), gyration_squared(model.body(pair.b)));
}

double compliance_of(const Model& model, const JointRowInstant& row) {
  const JointGeometry& joint = model.joint({row.joint});
  return compliance_of(model, joint,
                       row.row >= 0 ? joint.rows[static_cast<std::size_t>(row.row)]
                                    : joint.coordinates[static_cast<std::size_t>(row.coordinate)].row);
}

}  // namespace perp
