#include "perp/model/broad_phase.hpp"

#include <algorithm>
#include <numeric>

#include "core/index.hpp"

namespace perp {
const std::vector<std::pair<int, int>>& BroadPhase::overlaps(std::span<const Box> boxes) {
  pairs_.clear();
  nodes_.clear();
  order_.resize(boxes.size());
  std::iota(order_.begin(), order_.end(), 0);
  if (boxes.size() < 2) return pairs_;
  within(boxes, build(boxes, 0, static_cast<int>(boxes.size())));
  std::sort(pairs_.begin(), pairs_.end(), [](const auto& p, const auto& q) {
    return std::pair(p.second, p.first) < std::pair(q.second, q.first);
  });
  return pairs_;
}

int BroadPhase::build(std::span<const Box> boxes, int first, int last) {
  const int node = static_cast<int>(nodes_.size());
  nodes_.push_back({Box(), first, last, 0});
  Box centres;
  for (int k = first; k < last; ++k) {
    const Box& box = boxes[at(order_[at(k)])];
    nodes_[at(node)].box.extend(box);
    centres.extend(box.center());
  }
  if (last - first <= few) return node;
  Eigen::Index axis = 0;
  centres.sizes().maxCoeff(&axis);
  const int middle = first + (last - first) / 2;
  std::nth_element(order_.begin() + first, order_.begin() + middle, order_.begin() + last, [&](int i, int j) {
    const double x = boxes[at(i)].center()[axis], y = boxes[at(j)].center()[axis];
    return x < y || (x == y && i < j);
  });
  build(boxes, first, middle);
  const int right = build(boxes, middle, last);
  nodes_[at(node)].right = right;
  return node;
}

void BroadPhase::take(std::span<const Box> boxes, int i, int j) {
  if (boxes[at(i)].intersects(boxes[at(j)])) pairs_.emplace_back(std::min(i, j), std::max(i, j));
}

void BroadPhase::within(std::span<const Box> boxes, int node) {
  const Node& n = nodes_[at(node)];
  if (n.right == 0) {
    for (int k = n.first; k < n.last; ++k)
      for (int l = n.first; l < k; ++l) take(boxes, order_[at(k)], order_[at(l)]);
    return;
  }
  within(boxes, node + 1);
  within(boxes, n.right);
  across(boxes, node + 1, n.right);
}

void BroadPhase::across(std::span<const Box> boxes, int a, int b) {
  const Node &m = nodes_[at(a)], &n = nodes_[at(b)];
  if (!m.box.intersects(n.box)) return;
  if (m.right == 0 && n.right == 0) {
    for (int k = m.first; k < m.last; ++k)
      for (int l = n.first; l < n.last; ++l) take(boxes, order_[at(k)], order_[at(l)]);
    return;
  }
  if (n.right == 0 || (m.right != 0 && m.last - m.first >= n.last - n.first)) {
    across(boxes, a + 1, b);
    across(boxes, m.right, b);
  } else {
    across(boxes, a, b + 1);
    across(boxes, a, n.right);
  }
}

std::size_t BroadPhase::bytes() const {
  return order_.capacity() * sizeof(int) + nodes_.capacity() * sizeof(Node) +
         pairs_.capacity() * sizeof(pairs_[0]);
}

}  // namespace perp
