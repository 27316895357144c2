#include "instant/body_loops.hpp"

#include "core/index.hpp"

namespace perp {
void BodyLoops::begin(const Model& model) {
  for (const int body : touched_) parent_[at(body)] = body;
  touched_.clear();
  while (parent_.size() < model.bodies().size()) parent_.push_back(static_cast<int>(parent_.size()));
}

int BodyLoops::root(int body) {
  while (parent_[at(body)] != body) body = parent_[at(body)] = parent_[at(parent_[at(body)])];
  return body;
}

bool BodyLoops::close(const Model& model, int a, int b) {
  const Body &body_a = model.bodies()[at(a)], &body_b = model.bodies()[at(b)];
  if (body_a.kind == BodyKind::Generalized || body_b.kind == BodyKind::Generalized)
    return true;  // of as few coordinates as they please
  a = root(body_a.nv > 0 ? a : 0);
  b = root(body_b.nv > 0 ? b : 0);
  if (a == b) return true;
  parent_[at(a)] = b;
  touched_.push_back(a);
  return false;
}

bool BodyLoops::in(const Model& model, const Instant& instant, const Island& island) {
  if (island.contacts.size() + island.joint_rows.size() < 2) return false;
  begin(model);
  int last = -1;  // joint: its rows stand together
  for (const int i : island.joint_rows) {
    const JointRowInstant& row = instant.joint_rows[at(i)];
    if (row.joint == last) continue;
    last = row.joint;
    if (close(model, row.W.a, row.W.b)) return true;
  }
  for (const int i : island.contacts)
    if (close(model, instant.contacts[at(i)].W.a, instant.contacts[at(i)].W.b)) return true;
  return false;
}

}  // namespace perp
