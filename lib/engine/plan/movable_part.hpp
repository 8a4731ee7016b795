#pragma once

#include "frusta/mesh_part.hpp"
#include "mesh/vertices.hpp"
#include "plan/restriction.hpp"
#include "surface/open_edges.hpp"

#include <clsdf/mesh.hpp>

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

namespace clsdf::engine {

/// What a part of a mesh has so that its vertices can move by up to a margin M, each in any direction, and the part
/// still has the bytes of the whole mesh at the same positions.
///
/// The whole's bytes at new positions follow from these values, and so does what is kept of each:
///
///     records of faces     A face matters near a region if the ball around it, whose centre lies on its longest edge,
///                          reaches there. Its corners move by M, and the edge grows by 2 M. So the part has the
///                          clusters of all faces whose box, widened by the longest edge and 3 M, meets a region's.
///                          For the sign it has those that do so with the rows of a region (Restriction::near_boxes).
///     slopes of a face     follow from it, the faces across its edges, and all faces around edges of three or more.
///     point sites          follow from the faces around a vertex and their slopes. Their records share groups, so the
///                          whole block of vertices (site_block) is decided if one of them may move near a region.
///     box of the mesh      limits of all vertices: those within 2 M of a side of the present box decide it.
///     sample, open edges   of the whole mesh: their vertices are kept.
///     negative volume      a sum over all faces. Kept as a fact, if no motion by M can change its sign.
///
/// `mesh` has the part's faces, those around them that slopes and point sites follow from, and the other vertices.
struct MovablePart {
    double margin = 0;
    Mesh mesh;                                 ///< at the positions that the margin counts from
    UninitializedVector<std::uint32_t> order;  ///< of its triangles, as in the whole's topology
    std::vector<std::uint32_t> numbers;        ///< of its vertices in the mesh that the caller gave, ascending
    std::vector<std::uint32_t> vertices;       ///< of each of the part's vertices, its number in `mesh`; ascending
    std::vector<std::uint32_t> faces;   ///< of each of the part's faces in order, its place in `order`; ascending
    std::vector<std::uint32_t> places;  ///< of each vertex its number in the whole's topology, if the part decides
                                        ///< whether it has a point site; else no_place
    std::vector<Triangle> sample;       ///< of the surface, by vertices of `mesh`; see SurfaceSample
    OpenLoops loops{};                  ///< that count, by vertices of `mesh`
    std::optional<bool> encloses_negative_volume{};  ///< the whole mesh; nothing if a motion may change it

    static constexpr std::uint32_t no_place = 0xFFFFFFFFU;

    std::size_t host_bytes() const;
};

/// The records of a mesh that may matter to samples and points of regions when all vertices may move by `margin`, and
/// the blocks of vertices (site_block) whose point sites may, 1 each.
struct NearWithinMargin {
    NearRecords records;
    std::vector<std::uint8_t> blocks;
};
NearWithinMargin near_within_margin(const Restriction::NearBoxes& near, const MeshTopology& topology,
                                    const Frusta& frusta, double margin);

/// The whole mesh at its present positions.
struct WholeMesh {
    const Mesh& mesh;
    const Vertices& vertices;
    const SignSurface& surface;
    const MeshTopology& topology;
    const OpenLoops* loops;  ///< those that count; null if none do
};
/// part: of near.records.
MovablePart make_movable(const WholeMesh& whole, const MeshPart& part, const NearWithinMargin& near, double margin);

}  // namespace clsdf::engine
