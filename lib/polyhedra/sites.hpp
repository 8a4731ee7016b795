#pragma once

#include <clsdf/mesh.hpp>

#include "core/uninitialized_vector.hpp"
#include "outputs.h"

namespace clsdf::polyhedra {

/// The names of a mesh's vertices and edges as nearest sites, a row per triangle, in the caller's order.
struct Sites {
    UninitializedVector<TriangleSites> triangles;
    /// Angle-weighted pseudonormals of the six sites of each triangle, three numbers each: unit vectors on the side
    /// that the faces look to. If the faces' normals cancel, the normal of the first face with area; NaN if none has
    /// area. Empty unless they are requested.
    UninitializedVector<float> normals;
    /// So do the faces look inwards, if the mesh is closed. Known with the normals.
    bool encloses_negative_volume = false;
};

/// Whether the faces of a closed mesh look inwards.
bool encloses_negative_volume(const Mesh& mesh);

/// Equal vertices of the mesh are one already.
Sites make_sites(const Mesh& mesh, bool with_normals);

}  // namespace clsdf::polyhedra
