// Bodies that push on each other now, apart from those that do not: each island is a problem of its own.
#pragma once

#include <span>
#include <vector>

#include "perp/instant/instant.hpp"

namespace perp {

/// Contacts and joints that tie a set of bodies together; the ground and prescribed bodies tie nothing.
struct Island {
  std::vector<int> contacts;         ///< in Instant::contacts, ascending
  std::vector<int> joint_rows;       ///< in Instant::joint_rows, ascending
  std::vector<int> joint_frictions;  ///< in Instant::joint_frictions, ascending
};

/// Splits a system by connected components (union-find), in the order of each island's first body. Refilled, so that it
/// allocates nothing while islands keep their number and sizes.
class Islands {
 public:
  /// `active` lists the contacts that take part, ascending, as indices in instant.contacts; joints all take part.
  void find(const Model& model, const Instant& instant, std::span<const int> active);

  std::span<const Island> get() const { return {islands_.data(), count_}; }

 private:
  int root(int body);
  void tie(const Model& model, BodyId a, BodyId b);
  Island& of(const Model& model, BodyId a, BodyId b);

  std::vector<int> parent_;  // of a body
  std::vector<int> number_;  // of a root's island, or -1
  std::vector<Island> islands_;
  std::size_t count_ = 0;
};

}  // namespace perp
