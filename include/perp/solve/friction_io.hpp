// Contact problems as files: text in four kinds, and FCLIB's HDF5 layout (doc/problem-files.md, with an example of each).
//
// text, local   2 to 6 rows a contact; contacts; matrix W; q; mu [; torsion] [; mu_r] [; the word mu_o; mu_o]
// text, global  2 to 6 rows a contact; contacts; matrix M; matrix H (n, m); f (n); w (m); mu and what follows as above
// FCLIB         /fclib_local: spacedim, W, vectors/{q, mu, ...}; /fclib_global: spacedim, M, H, [G], vectors/{f, w, mu, [b], ...};
//               with rolling /fclib_local_rolling, /fclib_global_rolling; vectors/{[torsion], [mu_r], [mu_o]}
//               [Acary, Brémond, Koziara, Pérignon, FCLIB: a collection of discrete 3D frictional contact problems]
// Rows a contact: 2 planar, 3 cones, 4 with torsion, 5 with rolling, 6 with both, all contacts alike; FCLIB's rolling layouts also have planar
// contacts with rolling (3). mu_r is FrictionProblem::rolling. Text matrices as in numerics_matrix.hpp; a text is global if after
// its first matrix another one follows. What follows the last number is not read. Symbols as in FrictionProblem.
//
// FCLIB's triplets have the row in `i` and the column in `p`, as its files do; its documents also say the reverse. A file with a matrix whose
// triplets fit only the reverse way (as a rectangular H shows it) is read that way, all of its matrices, and a remark says so.
#pragma once

#include <string>
#include <vector>

#include "perp/solve/friction_problem.hpp"
#include "perp/solve/text_reader.hpp"

namespace perp {

/// Throws ParseError at the first token that is not as above.
[[nodiscard]] FrictionProblem read_friction_text(const TextReader& reader);

/// Reads either format, told apart by the file's first bytes. Throws ParseError naming the file and the place (in
/// HDF5 the dataset), std::invalid_argument if the file cannot be read or the library was built without HDF5.
[[nodiscard]] FrictionProblem read_friction_problem(const std::string& path);

/// The same; what a reader should know of how the file was read is appended to `remarks`, unless null.
[[nodiscard]] FrictionProblem read_friction_problem(const std::string& path,
                                                    std::vector<std::string>* remarks);

/// Whether the file begins as HDF5 does.
[[nodiscard]] bool is_hdf5_file(const std::string& path);

/// Numbers read back to the same bits. Throws std::invalid_argument for kinds that the format has no place for, or
/// bilateral rows in text, and std::runtime_error if the file cannot be written.
void write_friction_text(const FrictionProblem& problem, const std::string& path);
void write_fclib(const FrictionProblem& problem, const std::string& path);

bool has_hdf5();  ///< whether the library was built with HDF5

}  // namespace perp
