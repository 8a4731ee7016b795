#pragma once

#include <clsdf/mesh.hpp>
#include <clsdf/topology.hpp>

#include "surface/open_edges.hpp"

#include <span>
#include <string>

namespace clsdf {

/// Sets the counts of faces that look down. Returns whether all look up, or stand upright, and one looks up. triangles:
/// all faces, with numbers of vertices that are all different.
bool describe_looks(const Mesh& mesh, std::span<const Triangle> triangles, Topology& report);

/// Sets how the rim of such a mesh, its open edges, overlaps itself, seen from above. As many faces lie above a point
/// of the plane as the rim goes around it. So the mesh is a graph over the plane if the rim goes around each point once
/// or not at all.
void describe_rim(const Mesh& mesh, const OpenLoops& rim, Topology& report);

/// Throws Error(invalid_argument) unless the floor is finite and below the box of the mesh.
void check_floor(double floor, const Box& box, const std::string& mesh_name);

/// Whether the rule `below` suits a mesh that has been described for it or for `automatic`.
inline bool is_terrain(const Topology& topology) {
    return topology.rim_loops > 0 && topology.overlapping_rim_edges == 0;
}

}  // namespace clsdf
