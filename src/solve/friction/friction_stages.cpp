#include "solve/friction/friction_stages.hpp"

namespace perp {

template <int R>
double natural_map(const ContactSystem<R>& system, const Columns<R>& r, const Columns<R>& u) {
  double sum = 0;
  for (int i = 0; i < system.n; ++i) {
    const Block<R>& block = system.block[i];
    const Column<R> velocity = u.col(i);
    const Column<R> u_hat = system.associated ? velocity : augmented_velocity(block, velocity);
    sum += (r.col(i) - project_block<R>(block, r.col(i) - u_hat)).squaredNorm();
  }
  return std::sqrt(sum);
}

template <int R>
void evaluate(const ContactSystem<R>& system, Iterate<R>& point) {
  system.W->apply(point.r, point.u);
  point.u += system.q;
  point.error = pass_error(natural_map(system, point.r, point.u), point.r.norm());
}

template double natural_map(const ContactSystem<3>&, const Columns<3>&, const Columns<3>&);
template double natural_map(const ContactSystem<6>&, const Columns<6>&, const Columns<6>&);
template void evaluate(const ContactSystem<3>&, Iterate<3>&);
template void evaluate(const ContactSystem<6>&, Iterate<6>&);

}  // namespace perp
