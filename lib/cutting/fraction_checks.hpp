#pragma once

#include <clsdf/fractions.hpp>

namespace clsdf::cutting {

/// Throw Error(invalid_argument), also if a cell cannot be numbered.
void check_cells(const Grid& grid);
void check_options(const FractionOptions& options);
/// Throws the error of a mesh of which a vertex is too far away.
[[noreturn]] void refuse_far_vertices(const Mesh& mesh, const Grid& grid);

}  // namespace clsdf::cutting
