#pragma once

#include <clsdf/mesh.hpp>

#include "core/uninitialized_vector.hpp"
#include "outputs.h"

namespace clsdf::polyhedra {

/// How the vertices and edges of a mesh are named as nearest sites, a row per triangle, in the caller's order.
struct Sites {
    UninitializedVector<TriangleSites> triangles;
    /// Angle-weighted pseudonormals of the six sites of each triangle, three numbers each: unit vectors on the side
    /// that the faces look to. Where the faces cancel each other, the normal of the first one that has an area; not a
    /// number if none has. Empty unless they are asked for.
    UninitializedVector<float> normals;
    /// So do the faces look inwards, if the mesh is closed. Known with the normals.
    bool encloses_negative_volume = false;
};

/// Equal vertices of the mesh are one already.
Sites make_sites(const Mesh& mesh, bool with_normals);

}  // namespace clsdf::polyhedra
