// Whether program and library agree on what Eigen aligns to: matrices that one makes and the other frees depend on it.
#pragma once

#include <Eigen/Core>

namespace perp {

// The installed package (find_package, pkg-config) makes Eigen's alignment the library's, whatever -march says.
#if defined(PERP_EIGEN_MAX_ALIGN_BYTES)
static_assert(
    EIGEN_MAX_ALIGN_BYTES == PERP_EIGEN_MAX_ALIGN_BYTES &&
        EIGEN_MAX_STATIC_ALIGN_BYTES == PERP_EIGEN_MAX_STATIC_ALIGN_BYTES &&
        EIGEN_DEFAULT_ALIGN_BYTES == PERP_EIGEN_DEFAULT_ALIGN_BYTES,
    "this program aligns otherwise than the perp library it is compiled against: leave EIGEN_MAX_ALIGN_BYTES "
    "and -mavx to perp's package, or build perp with the program's flags");
#endif

/// Defined for the library's own alignments [bytes] alone: a program with others, compiled past the package, does not link, and
/// the linker names this function.
template <int Heap, int Fixed, int Largest>
int program_and_perp_agree_on_eigen_alignment();

inline const int eigen_alignment_agreed =
    program_and_perp_agree_on_eigen_alignment<EIGEN_DEFAULT_ALIGN_BYTES, EIGEN_MAX_STATIC_ALIGN_BYTES,
                                              EIGEN_MAX_ALIGN_BYTES>();

}  // namespace perp
