#pragma once

#include <clsdf/mesh.hpp>

#include "outputs.h"
#include "surface/sign_surface.hpp"
#include "topology/topology.hpp"

#include <span>

namespace clsdf::engine {

/// Names the vertices and edges of a mesh as nearest sites: a row per triangle, in the caller's order.
void name_sites(const MeshTopology& topology, std::span<TriangleSites> names);

/// Angle-weighted pseudonormals of the six sites of each triangle, three numbers each, in the caller's order: unit
/// vectors on the side that the faces look to. If the faces' normals cancel, the normal of the first face with area;
/// NaN if none has area. `positions`: of the mesh's vertices.
void make_pseudonormals(const MeshTopology& topology, std::span<const Vec3> positions, std::span<float> normals);

/// The same for a mesh whose sign another surface decides: sites of that surface, with its faces as they look there.
/// Faces that it leaves out have the pseudonormals of its sites, or else those of the mesh.
void make_pseudonormals(const Mesh& mesh, const SignSurface& surface, const MeshTopology& topology,
                        std::span<float> normals);

/// Whether a sample of the lattice may lie on an edge or a vertex. If none does, gradients on grids need no
/// pseudonormals. `positions`: in the topology's order.
bool may_meet_samples(const MeshTopology& topology, std::span<const Vec3> positions, const Vec3& origin,
                      const Vec3& spacing);

}  // namespace clsdf::engine
