#include "solve/ncp/ipopt_run.hpp"

#ifdef PERP_HAS_IPOPT

#define HAVE_CSTDDEF  // asked for by the headers of Ipopt 3.11
#include <IpIpoptApplication.hpp>
#include <IpTNLP.hpp>
#include <mutex>

namespace perp {

void run_ipopt(Ipopt::TNLP* program, bool exact_hessian) {
  static std::mutex one_at_a_time;  // MUMPS keeps global state
  const std::lock_guard lock(one_at_a_time);
  try {
    Ipopt::SmartPtr<Ipopt::IpoptApplication> application = new Ipopt::IpoptApplication(false);
    auto& options = *application->Options();
    options.SetIntegerValue("print_level", 0);
    options.SetStringValue("sb", "yes");
    options.SetStringValue("linear_solver", "mumps");
    options.SetIntegerValue("max_iter", 500);
    options.SetNumericValue("tol", 1e-10);
    options.SetNumericValue("bound_relax_factor", 0.0);
    options.SetStringValue("fixed_variable_treatment", "make_parameter");
    if (!exact_hessian) options.SetStringValue("hessian_approximation", "limited-memory");
    if (application->Initialize("") == Ipopt::Solve_Succeeded) application->OptimizeTNLP(program);
  } catch (...) {
    // whatever Ipopt met, the caller goes on from the best point there was
  }
}

}  // namespace perp

#endif
