#include "perp/core/alignment.hpp"

namespace perp {

template <int Heap, int Fixed, int Largest>
int program_and_perp_agree_on_eigen_alignment() {
  return Heap;
}

template int program_and_perp_agree_on_eigen_alignment<EIGEN_DEFAULT_ALIGN_BYTES,
                                                       EIGEN_MAX_STATIC_ALIGN_BYTES, EIGEN_MAX_ALIGN_BYTES>();

}  // namespace perp
