#include "perp/instant/islands.hpp"

#include <algorithm>
#include <numeric>

namespace perp {

int Islands::root(int body) {
  while (parent_[static_cast<std::size_t>(body)] != body) {
    int& up = parent_[static_cast<std::size_t>(body)];
    up = parent_[static_cast<std::size_t>(up)];  // halves the path for the next one
    body = up;
  }
  return body;
}

void Islands::tie(const Model& model, BodyId a, BodyId b) {
  if (model.body(a).nv == 0 || model.body(b).nv == 0) return;
  const int root_a = root(a.index), root_b = root(b.index);
  parent_[static_cast<std::size_t>(std::max(root_a, root_b))] = std::min(root_a, root_b);
}

Island& Islands::of(const Model& model, BodyId a, BodyId b) {
  const int body = root(model.body(a).nv > 0 ? a.index : b.index);
  return islands_[static_cast<std::size_t>(number_[static_cast<std::size_t>(body)])];
}

void Islands::find(const Model& model, const Instant& instant, std::span<const int> active) {
  const std::size_t bodies = model.bodies().size();
  parent_.resize(bodies);
  std::iota(parent_.begin(), parent_.end(), 0);
  const auto contact = [&](int i) {
    return model.contact(instant.contacts[static_cast<std::size_t>(i)].contact);
  };
  const auto joint = [&](const JointRowInstant& row) -> const JointGeometry& {
    return model.joints()[static_cast<std::size_t>(row.joint)];
  };
  for (const int i : active) tie(model, contact(i).a, contact(i).b);
  for (const JointGeometry& j : model.joints()) tie(model, j.a, j.b);

  // one island a root that something acts on
  number_.assign(bodies, -1);
  const auto mark = [&](BodyId a, BodyId b) {
    number_[static_cast<std::size_t>(root(model.body(a).nv > 0 ? a.index : b.index))] = 0;
  };
  for (const int i : active) mark(contact(i).a, contact(i).b);
  for (const JointGeometry& j : model.joints()) mark(j.a, j.b);
  count_ = 0;
  for (int& number : number_)
    if (number == 0) number = static_cast<int>(count_++);
  if (islands_.size() < count_) islands_.resize(count_);
  for (std::size_t i = 0; i < count_; ++i) {
    islands_[i].contacts.clear();
    islands_[i].joint_rows.clear();
    islands_[i].joint_frictions.clear();
  }

  for (const int i : active) of(model, contact(i).a, contact(i).b).contacts.push_back(i);
  for (std::size_t i = 0; i < instant.joint_rows.size(); ++i) {
    const JointGeometry& j = joint(instant.joint_rows[i]);
    of(model, j.a, j.b).joint_rows.push_back(static_cast<int>(i));
  }
  for (std::size_t i = 0; i < instant.joint_frictions.size(); ++i) {
    const JointGeometry& j = joint(instant.joint_frictions[i]);
    of(model, j.a, j.b).joint_frictions.push_back(static_cast<int>(i));
  }
}

}  // namespace perp
