#pragma once

#include <clsdf/mesh.hpp>
#include <clsdf/mesh_files.hpp>

namespace clsdf {

/// Throws Error(invalid_argument) that names the option.
void check_placement(const ReadOptions& options);

/// The mesh in the unit, the axes and at the place of the options. Throws Error(invalid_argument) if a vertex in use
/// becomes infinite.
Mesh placed(Mesh mesh, const ReadOptions& options);

}  // namespace clsdf
