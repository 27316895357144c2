#include "sphere_packing.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace perp {
namespace {

/// Pairs of spheres that are near: a grid of cubes as wide as the largest sphere, neighbours by a list that is made anew now and then.
class Neighbours {
 public:
  Neighbours(const SpherePacking& packing, double reach) : reach_(reach) {
    cell_ = 2 * *std::max_element(packing.radius.begin(), packing.radius.end()) + reach;
    nx_ = std::max(1, static_cast<int>(packing.box.x() / cell_));
    ny_ = std::max(1, static_cast<int>(packing.box.y() / cell_));
    double top = 0;
    for (const Vector3& p : packing.centre) top = std::max(top, p.z());
    nz_ = 1 + static_cast<int>(top / cell_);
    cells_.resize(static_cast<std::size_t>(nx_ * ny_ * nz_));
    for (std::size_t i = 0; i < packing.centre.size(); ++i)
      cells_[number(place(packing.centre[i].x(), nx_), place(packing.centre[i].y(), ny_),
                    place(packing.centre[i].z(), nz_))]
          .push_back(i);
    for (int z = 0; z < nz_; ++z)
      for (int y = 0; y < ny_; ++y)
        for (int x = 0; x < nx_; ++x) add_pairs(packing, x, y, z);
  }

  const std::vector<std::pair<std::size_t, std::size_t>>& pairs() const { return pairs_; }

 private:
  int place(double x, int n) const { return std::clamp(static_cast<int>(x / cell_), 0, n - 1); }
  std::size_t number(int x, int y, int z) const { return static_cast<std::size_t>((z * ny_ + y) * nx_ + x); }

  void add_pairs(const SpherePacking& packing, int x, int y, int z) {
    const auto& here = cells_[number(x, y, z)];
    for (int k = -1; k <= 1; ++k)
      for (int j = -1; j <= 1; ++j)
        for (int i = -1; i <= 1; ++i) {
          if (x + i < 0 || x + i >= nx_ || y + j < 0 || y + j >= ny_ || z + k < 0 || z + k >= nz_) continue;
          for (const std::size_t a : here)
            for (const std::size_t b : cells_[number(x + i, y + j, z + k)])
              if (a < b && (packing.centre[a] - packing.centre[b]).norm() <
                               packing.radius[a] + packing.radius[b] + reach_)
                pairs_.emplace_back(a, b);
        }
  }

  double reach_, cell_ = 0;
  int nx_ = 1, ny_ = 1, nz_ = 1;
  std::vector<std::vector<std::size_t>> cells_;
  std::vector<std::pair<std::size_t, std::size_t>> pairs_;
};

double cubed(double r) { return r * r * r; }

/// Takes every overlap away, once through all pairs, then puts all between the walls and above the floor.
void push_apart(const Neighbours& near, SpherePacking& packing) {
  for (const auto& [a, b] : near.pairs()) {
    const Vector3 d = packing.centre[b] - packing.centre[a];
    const double distance = d.norm(), overlap = packing.radius[a] + packing.radius[b] - distance;
    if (!(overlap > 0) || !(distance > 0)) continue;
    // the lighter gives way
    const double va = cubed(packing.radius[a]), vb = cubed(packing.radius[b]);
    packing.centre[a] -= d * (overlap / distance * vb / (va + vb));
    packing.centre[b] += d * (overlap / distance * va / (va + vb));
  }
  for (std::size_t i = 0; i < packing.centre.size(); ++i) {
    Vector3& p = packing.centre[i];
    const double r = packing.radius[i];
    p.x() = std::clamp(p.x(), r, packing.box.x() - r);
    p.y() = std::clamp(p.y(), r, packing.box.y() - r);
    p.z() = std::max(p.z(), r);
  }
}

/// In layers, `pitch` apart; the large ones may overlap.
void set_out(Random& random, double pitch, SpherePacking& packing) {
  const double jitter = 0.02 * pitch;
  const int nx = std::max(1, static_cast<int>(packing.box.x() / pitch)),
            ny = std::max(1, static_cast<int>(packing.box.y() / pitch));
  for (std::size_t i = 0; i < packing.radius.size(); ++i) {
    const int k = static_cast<int>(i), layer = k / (nx * ny), rest = k % (nx * ny);
    packing.centre.push_back(pitch *
                                 Vector3(rest % nx + 0.5, static_cast<double>(rest / nx) + 0.5, layer + 0.5) +
                             random.vector(jitter));
  }
}

void sort_by_height(SpherePacking& packing) {
  std::vector<std::size_t> order(packing.centre.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
    return packing.centre[a].z() < packing.centre[b].z();
  });
  SpherePacking sorted{packing.box, {}, {}};
  for (const std::size_t i : order) {
    sorted.centre.push_back(packing.centre[i]);
    sorted.radius.push_back(packing.radius[i]);
  }
  packing = std::move(sorted);
}

}  // namespace

SpherePacking pack_spheres(Random& random, int count, double largest, double ratio) {
  SpherePacking packing;
  double volume = 0;
  for (int i = 0; i < count; ++i) {
    // as many cubic metres of each size: the density of radii falls as r^-3
    const double low = 1 / (ratio * ratio), u = random.uniform(0, 1);
    const double radius = largest / std::sqrt((1 - u) / low + u);
    packing.radius.push_back(radius);
    volume += cubed(2 * radius);
  }
  const double side = std::max(2 * 2.05 * largest, 0.9 * std::cbrt(volume));  // about as high as wide
  packing.box = {side, side, 0};
  set_out(random, std::cbrt(1.1 * volume / count), packing);

  constexpr int rounds = 160, sinkings = 12, passes = 4;
  constexpr double first = 0.06,
                   last = 3e-5;  // of the largest radius, that all sink at once: first to fall, last to lie
  for (int round = 0; round < rounds; ++round) {
    const Neighbours near(packing, 0.5 * largest);
    const double sink = largest * first * std::pow(last / first, std::max(0, round - 30) / (rounds - 31.0));
    for (int i = 0; i < sinkings; ++i) {
      for (Vector3& p : packing.centre) p.z() -= sink;
      for (int pass = 0; pass < passes; ++pass) push_apart(near, packing);
    }
  }
  sort_by_height(packing);
  return packing;
}

}  // namespace perp
