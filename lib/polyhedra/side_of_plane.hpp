#pragma once

#include "polyhedra/one_rings.hpp"
#include "polyhedra/triangle_frame.hpp"

#include <array>
#include <cstdint>

namespace clsdf::polyhedra {

/// The plane of a face, and the vertex opposite to one of its edges in another face.
struct OppositeVertex {
    std::array<Vec3, 3> plane;
    Vec3 point;

    /// `second`: the edge, as the other face has it.
    OppositeVertex(const MeshFaces& faces, std::uint32_t first, const Corner& second)
        : plane(faces.corners(first)),
          point(faces.position(faces.triangles[second.face][previous_of_three(second.vertex)])) {}
};

/// On which side of the plane the vertex lies: 1 above (the edge is concave seen from above), -1 below, 0 in it. Exact
/// for the coordinates as given (CGAL's predicate).
int side_of_plane(const OppositeVertex& vertex);

}  // namespace clsdf::polyhedra
