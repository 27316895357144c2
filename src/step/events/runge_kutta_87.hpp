// The embedded pair of orders 8 and 7 of Prince and Dormand.
#pragma once

#include <vector>

namespace perp {

/// RK8(7)13M [PD81, Table 2], 13 stages. Unlike Fehlberg's pair of orders 7 and 8 its error estimate does not vanish for y' = f(t).
struct RungeKutta87 {
  static constexpr int stages = 13;
  std::vector<double> c, A;           ///< (13); (13, 13) by rows
  std::vector<double> b, b_embedded;  ///< orders 8, 7
};

[[nodiscard]] RungeKutta87 runge_kutta_87();

}  // namespace perp
