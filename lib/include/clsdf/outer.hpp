#pragma once

#include <clsdf/calls.hpp>
#include <clsdf/export.hpp>
#include <clsdf/mesh.hpp>
#include <clsdf/topology.hpp>

#include <cstddef>
#include <cstdint>
#include <vector>

namespace clsdf {

/// The outer surface of a mesh: the boundary of what its sign rule says is inside.
struct OuterSurface {
    /// Closed and balanced; faces look outwards. Its groups are those of the faces as given.
    Mesh mesh;
    /// The number of the face as given that each triangle of `mesh` is a part of; of coincident faces one.
    std::vector<std::uint32_t> faces;

    std::size_t whole_faces = 0;    ///< faces as given that are on the outer surface wholly,
    std::size_t partial_faces = 0;  ///< in parts,
    std::size_t hidden_faces =
        0;              ///< and not at all: within others, repeated, without area, or with the same on both sides
    double volume = 0;  ///< inside, in cubed units of the mesh
    double area = 0;    ///< of the outer surface, in squared units
};

/// The outer surface of a mesh whose parts may overlap, touch, repeat or contain each other: those parts of its faces
/// that have the outside on one side and the inside on the other, by the rule's winding number. Faces are cut along
/// the segments in which they meet; where they meet, and what is inside, is decided exactly, and each new vertex is
/// rounded once, by at most half an ulp of each coordinate. Faces that meet no other keep their corners. Vertices that
/// the sign joins are joined, and faces that it turns, counts once or leaves out are used so (docs/sign.md).
///
/// Walls between two insides vanish, and so do sheets with the same on both sides: there the distance to the outer
/// surface is larger than that to the mesh, and it is never smaller. Uses all cores; may be called by many threads.
/// Memory and time grow with the number of pairs of faces that meet, and faster where many overlap in one plane.
///
/// sign: automatic, nonzero or parity. Throws the errors of resolve_sign_rule(); Error(invalid_mesh) if nothing is
/// inside; Error(unsupported) for the other rules, and for automatic if the mesh has none of these two:
/// close_down() closes a terrain, and weld() seams; Error(out_of_memory). Of `call`, should_stop counts, and log, which
/// gets the warning of resolve_sign_rule().
CLSDF_EXPORT OuterSurface outer(const Mesh& mesh, SignRule sign = SignRule::automatic, const CallOptions& call = {});

}  // namespace clsdf
