#pragma once

#include <clsdf/calls.hpp>
#include <clsdf/mesh.hpp>
#include <clsdf/outer.hpp>
#include <clsdf/topology.hpp>

#include "finish/given_faces.hpp"

#include <string>

namespace clsdf::cutting {

/// The outer surface of a mesh, for transforms.
struct OuterMesh {
    OuterSurface surface;
    /// What outputs tell of its triangles. Empty if the surface is the mesh as given, all of whose faces are whole and
    /// look outwards, and whose vertices are joined only if they are equal: then that mesh serves.
    engine::GivenFaces faces;
    Topology topology;    ///< of the mesh as given
    SignRule rule;        ///< nonzero or parity
    std::string warning;  ///< about the mesh as given and what of it is not on the surface; may be empty
};

/// Throws as outer() does.
OuterMesh outer_mesh(const Mesh& given, SignRule asked, const CallOptions& call);

}  // namespace clsdf::cutting
