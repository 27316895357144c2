// One way to call Ipopt: silent, with the library's options, one call at a time.
#pragma once

namespace Ipopt {
class TNLP;
}

namespace perp {

/// Runs Ipopt on the program, which a SmartPtr of the caller owns and which keeps its own answer. Without exact
/// Hessians it collects its own from gradients. Whatever Ipopt throws ends here.
void run_ipopt(Ipopt::TNLP* program, bool exact_hessian);

}  // namespace perp
