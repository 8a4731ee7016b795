#pragma once

#include <clsdf/mesh.hpp>
#include <clsdf/topology.hpp>

#include "surface/sign_surface.hpp"

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

namespace clsdf {

/// Whether a closed surface encloses a volume that is negative by more than its rounding error: its faces look inwards.
bool encloses_negative_volume(const Mesh& mesh, const SignSurface& surface = {});

/// The same at all positions that are at most `margin` from the mesh's; nothing if it is not the same at all of them.
std::optional<bool> encloses_negative_volume(const Mesh& mesh, const SignSurface& surface, double margin);

/// The same of sums over all faces: LocalFrame::add_volume(), by halves down to leaves of so many faces.
inline constexpr std::size_t volume_leaf = 64;
bool is_negative_volume(double sum, double magnitude, std::size_t faces);

/// The open edges of a mesh whose vertices are all different, or of a surface of it.
OpenLoops open_loops_of(const Mesh& mesh, const SignSurface& surface);

/// The first half of describe_topology(): the counts of vertices. first: first_equal_vertices().
Topology describe_vertices(const Mesh& mesh, std::span<const std::uint32_t> first);

/// The second half, for a mesh whose vertices are all different, with the surface that decides the sign. The mesh has
/// its first positions. are_paired: each edge is known to have two faces, which run along it in opposite directions;
/// then nothing is left to count. neighbours: the faces with other numbers of vertices, best in an order in which
/// neighbours follow each other. asked: the sign rule that the mesh is for; the winding number of a mesh with open
/// edges is looked at if the rule may become solid_angle.
SignSurface describe_edges(const Mesh& mesh, std::span<const Triangle> neighbours, bool are_paired, SignRule asked,
                           Topology& report);

/// The same of a mesh in one part, each of whose edges has two faces, which run along it in opposite directions. Other
/// parts are described by describe_parts().
void describe_paired_edges(bool encloses_negative_volume, Topology& report);

/// The topology of a mesh with its first positions, and the surface that decides its sign.
struct DescribedMesh {
    Topology topology;
    SignSurface surface;
};
/// As for `automatic`, unless another rule is asked for. Throws as describe_topology() does.
DescribedMesh describe_mesh(const Mesh& mesh, SignRule asked = SignRule::automatic);

}  // namespace clsdf
