// Whether program and library agree on what Eigen aligns to: matrices that one makes and the other frees depend on it.
#pragma once

#include <Eigen/Core>

namespace perp {

// The installed package (find_package, pkg-config) defines Eigen's alignment to be the library's, whatever -march says.
#if defined(PERP_EIGEN_MAX_ALIGN_BYTES)
static_assert(EIGEN_MAX_ALIGN_BYTES == PERP_EIGEN_MAX_ALIGN_BYTES &&
                  EIGEN_MAX_STATIC_ALIGN_BYTES == PERP_EIGEN_MAX_STATIC_ALIGN_BYTES,
              "this program makes Eigen align otherwise than the perp library it is compiled against; "
              "include perp's headers before "
              "Eigen is configured otherwise, and leave EIGEN_MAX_ALIGN_BYTES to perp's package");
#endif

/// Defined for the library's own alignments [bytes] alone: a program with others, compiled past the package, does not link, and
/// the linker names this function.
template <int Heap, int Fixed>
int program_and_perp_agree_on_eigen_alignment();

inline const int eigen_alignment_agreed =
    program_and_perp_agree_on_eigen_alignment<EIGEN_MAX_ALIGN_BYTES, EIGEN_MAX_STATIC_ALIGN_BYTES>();

}  // namespace perp
