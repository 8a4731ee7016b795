#pragma once

#include <clsdf/mesh.hpp>
#include <clsdf/topology.hpp>

#include <cstdint>
#include <span>
#include <vector>

namespace clsdf {

/// For each vertex the index of the first vertex with equal coordinates, which may be its own; -0.0 equals 0.0. At most
/// 2^32 - 1 vertices.
std::vector<std::uint32_t> first_equal_vertices(std::span<const Vec3> vertices);

/// Whether a closed mesh encloses a volume that is negative by more than its rounding error: its faces look inwards.
bool encloses_negative_volume(const Mesh& mesh);

/// The first half of describe_topology(): the counts of vertices.
Topology describe_vertices(const Mesh& mesh);

/// The second half, for a mesh whose vertices are all different. are_paired: each edge is known to have two faces,
/// which run along it in opposite directions; then nothing is left to count.
void describe_edges(const Mesh& mesh, bool are_paired, Topology& report);

}  // namespace clsdf
