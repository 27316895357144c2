// Contact problems as files: text in four kinds, and FCLIB's HDF5 layout.
//
// text, local   2 or 3 rows a contact; contacts; matrix W; q; mu
// text, global  2 or 3 rows a contact; contacts; matrix M; matrix H (n, m); f (n); w (m); mu
// FCLIB         /fclib_local: spacedim, W, vectors/{q, mu}; /fclib_global: spacedim, M, H, [G], vectors/{f, w, mu, [b]}
//               [Acary, Brémond, Koziara, Pérignon, FCLIB: a collection of discrete 3D frictional contact problems]
// Text matrices as in numerics_matrix.hpp; a text is global if after its first matrix another one follows. What
// follows the last number is not read. Symbols as in FrictionProblem. Only cones (3) or planar contacts (2), no mixtures.
#pragma once

#include <string>

#include "perp/solve/friction_problem.hpp"
#include "perp/solve/text_reader.hpp"

namespace perp {

/// Throws ParseError at the first token that is not as above.
[[nodiscard]] FrictionProblem read_friction_text(const TextReader& reader);

/// Reads either format, told apart by the file's first bytes. Throws ParseError naming the file and the place (in
/// HDF5 the dataset), std::invalid_argument if the file cannot be read or the library was built without HDF5.
[[nodiscard]] FrictionProblem read_friction_problem(const std::string& path);

/// Whether the file begins as HDF5 does.
[[nodiscard]] bool is_hdf5_file(const std::string& path);

/// Numbers read back to the same bits. Throws std::invalid_argument for kinds that the format has no place for, or
/// bilateral rows in text, and std::runtime_error if the file cannot be written.
void write_friction_text(const FrictionProblem& problem, const std::string& path);
void write_fclib(const FrictionProblem& problem, const std::string& path);

bool has_hdf5();  ///< whether the library was built with HDF5

}  // namespace perp
