// The lengths of the woodpecker toy, which its gaps and its picture share.
#pragma once

namespace perp {

/// [m]: pole r_0; sleeve r_M inside, h_M half its height, l_M from the pole's axis to the spring; bird l_G from the spring to its centre, its
/// beak l_S back from there and h_S above.
struct WoodpeckerSizes {
  double r_0 = 0.0025, r_M = 0.0031, h_M = 0.0058, l_M = 0.01, l_G = 0.015, h_S = 0.02, l_S = 0.0201;
};

}  // namespace perp
