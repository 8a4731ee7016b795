#pragma once

#include "polyhedra/mesh_faces.hpp"
#include "polyhedra/slopes.hpp"
#include "polyhedra/triangle_frame.hpp"

namespace clsdf::polyhedra {

/// The device's record of a polyhedron. `triangle`: index in the caller's order. `corners`: of the frame's triangle,
/// among the positions of `faces`; a point site's are its vertex three times.
Polyhedron pack(const TriangleFrame& frame, const FaceSlopes& slopes, std::uint32_t triangle, const MeshFaces& faces,
                const Triangle& corners);

}  // namespace clsdf::polyhedra
