#pragma once

#include "core/kept_array.hpp"
#include "frusta/frames.hpp"
#include "frusta/slopes.hpp"
#include "topology/topology.hpp"

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace clsdf::engine {

/// The frustum of a vertex by itself, at a gap between those of its faces.
struct SiteFrustum {
    std::uint32_t vertex = 0;  ///< its number in MeshTopology::faces
    std::uint32_t face = 0;    ///< place in the list: the vertex' face that comes first in the caller's order
    Vector normal;             ///< its frame's
    FaceSlopes slopes{};
};

/// The part of a mesh's frusta that decisions of the host have found. Small: the host always has it.
struct FoundFrusta {
    std::vector<SiteFrustum> sites;      ///< ascending by vertex; those of a transform in_groups()
    std::vector<std::uint32_t> slivers;  ///< ascending: faces so thin that their frames may be special cases
    std::size_t saddle_vertices = 0;     ///< with convex and concave edges (kernels: flat up to rounding is neither)
    std::size_t boxes = 0;               ///< faces so degenerate that their polyhedron is a box

    std::size_t host_bytes() const;
};

/// The exact bounding polyhedra of a mesh (docs/method.md, 'Leaned frusta'), for every lattice and every band: frames
/// follow from the positions, and slopes have no unit. Together they are exact: every point y lies in the polyhedron of
/// a triangle at the distance dist(y, mesh), if tests widen them by a slack of 1e-3 + 2e-5 d units or more, d the
/// distance in units, which must exceed the tests' rounding, too.
struct Frusta : FoundFrusta {
    KeptArray<Vec3> positions;     ///< of the vertices, numbered as in MeshTopology::faces
    KeptArray<FaceSlopes> slopes;  ///< of each face

    std::size_t host_bytes() const;
};

/// Steps that tests switch off to show that they are needed.
struct FrustaOptions {
    bool lean = true;         ///< obtuse corners lean their neighbours' planes outward
    bool point_sites = true;  ///< gaps at saddle vertices get a polyhedron of their own
};

/// Decisions that kernels leave to the host (KernelTopology::left_to_host()).
struct LeftToHost {
    std::vector<std::uint32_t> faces{};     ///< ascending: their slopes
    std::vector<std::uint32_t> vertices{};  ///< ascending: whether they leave gaps, and are saddle vertices
    std::size_t saddles_elsewhere = 0;      ///< saddle vertices among the other vertices
    std::vector<std::uint32_t> gaps{};      ///< ascending: those of `vertices` that surely have one, saddle vertices
};

/// A lattice for frusta alone. Lengths are of the order of one, so that their squares do not leave a double's range.
/// `box`: of the vertices in use.
LatticeView view_of(const Box& box);

/// The positions of the mesh's vertices, numbered as in MeshTopology::faces.
UninitializedVector<Vec3> ordered_positions(const MeshTopology& topology, std::span<const Vec3> positions);

/// The frusta of all faces by the host alone, with exact predicates: the specification of what the kernels make.
/// `positions`: of the mesh's vertices, as the mesh numbers them.
Frusta make_frusta(const MeshTopology& topology, std::span<const Vec3> positions, const FrustaOptions& options = {});

/// Completes frusta that have their positions, and slopes of the other faces, by the same means. `box`: of the
/// positions.
void complete_frusta(const MeshTopology& topology, const Box& box, const LeftToHost& left, Frusta& frusta,
                     const FrustaOptions& options = {});

/// Consecutive vertices of a mesh, as MeshTopology numbers them, whose point sites share groups of records.
inline constexpr std::uint32_t site_block = 1024;
/// The block of each site, ascending. joined: of MeshTopology.
std::vector<std::uint32_t> site_blocks(std::span<const SiteFrustum> sites, std::span<const JoinedPart> joined);
/// The sites of each block filled up to whole groups of records (record_group), with cones that no block of samples
/// overlaps. So what shares a group with a site follows from the vertices near it, and a part of a mesh has the groups
/// of the whole. blocks: of each site, ascending.
std::vector<SiteFrustum> in_groups(std::span<const SiteFrustum> sites, std::span<const std::uint32_t> blocks);
/// Whether a site is one that in_groups() has added.
bool is_filling(const SiteFrustum& site);

/// The frustum of a vertex by itself: it holds the vertex' whole normal cone. `order`, `vertices`: the caller's indices
/// of the faces and of the vertices.
SiteFrustum point_site(const MeshFaces& faces, std::span<const std::uint32_t> order,
                       std::span<const std::uint32_t> vertices, const OneRings& rings, std::uint32_t vertex);

}  // namespace clsdf::engine
