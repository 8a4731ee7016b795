#pragma once

#include <clsdf/mesh.hpp>

#include <cstddef>

namespace clsdf {

/// What may be wrong with a mesh besides its edges, which Topology describes. Vertices of equal coordinates count as
/// one. None of it keeps a distance from being computed.
struct Defects {
    std::size_t zero_area_faces = 0;  ///< three different vertices on one line, exactly
    std::size_t duplicate_faces = 0;  ///< with the three different vertices of an earlier face, in whatever order
    std::size_t components = 0;       ///< parts of the mesh that share no vertex
};

Defects find_defects(const Mesh& mesh);

}  // namespace clsdf
