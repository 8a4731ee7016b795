#pragma once

#include "surface/open_edges.hpp"
#include "tree/crossed_faces.hpp"
#include "tree/point_mesh.hpp"
#include "tree/wide_tree.hpp"

#include <cstddef>

namespace clsdf::engine {

/// The closed surface that decides the sign with the rule `below`, for the host: behind the faces of a mesh those of
/// the walls, then those of the floor, which is a copy of the mesh. These have no number (no_triangle in
/// MeshTopology::order). mesh: with walls. boundary: with a floor. A part of a mesh has all walls, and the
/// floor below it.
struct ClosedMesh {
    PointMesh mesh;

    std::size_t host_bytes() const { return mesh.host_bytes() + mesh.topology->host_bytes(); }
};
ClosedMesh closed_down(const PointMesh& mesh, const OpenBoundary& boundary);

/// How the host finds its faces.
struct ClosedFaces {
    WideTree tree;
    CrossedExtent extent;

    std::size_t host_bytes() const { return tree.host_bytes() + CrossedExtent::host_bytes(); }
};

}  // namespace clsdf::engine
