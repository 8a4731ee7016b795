#include "polyhedra/frusta.hpp"

#include "core/parallel.hpp"
#include "polyhedra/edge_slopes.hpp"
#include "polyhedra/frame_planes.hpp"
#include "polyhedra/gap_screen.hpp"
#include "polyhedra/gaps.hpp"
#include "polyhedra/mesh_faces.hpp"
#include "polyhedra/non_manifold_edges.hpp"
#include "polyhedra/point_site.hpp"
#include "polyhedra/records.hpp"

#include <tbb/enumerable_thread_specific.h>

#include <algorithm>
#include <atomic>
#include <cmath>

namespace clsdf::polyhedra {

namespace {

struct MarkedVertices {
    std::size_t saddles = 0;
    std::vector<std::uint32_t> gaps{};  ///< ascending
};

MarkedVertices marked_vertices(std::span<const std::uint8_t> marks) {
    constexpr std::size_t stretch = 4096;
    std::vector<MarkedVertices> parts(stretch_count(marks.size(), stretch));
    for_each_stretch(marks.size(), stretch, [&](std::size_t part, std::size_t begin, std::size_t end) {
        for (std::size_t vertex = begin; vertex < end; ++vertex) {
            parts[part].saddles += (marks[vertex] & vertex_saddle) != 0 ? 1U : 0U;
            if ((marks[vertex] & vertex_gap) != 0) parts[part].gaps.push_back(static_cast<std::uint32_t>(vertex));
        }
    });
    MarkedVertices all;
    for (const MarkedVertices& part : parts) {
        all.saddles += part.saddles;
        all.gaps.insert(all.gaps.end(), part.gaps.begin(), part.gaps.end());
    }
    return all;
}

PairedEdges copy_of(const PairedEdges& edges) {
    PairedEdges copy{UninitializedVector<FaceEdges>(edges.faces.size()), edges.non_manifold_ends,
                     edges.non_manifold_corners};
    for_each_index(copy.faces.size(), [&](std::size_t face) { copy.faces[face] = edges.faces[face]; });
    return copy;
}

/// Lengths are of the order of one, so that their squares do not leave a double's range.
LatticeView view_of(std::span<const Vec3> positions) {
    double largest = 0;
    for (const Vec3& position : positions)
        for (const double x : position) largest = std::max(largest, std::abs(x));
    return {{}, largest > 0 ? std::ldexp(1.0, std::ilogb(largest) - 8) : 1.0};
}

}  // namespace

std::size_t Frusta::bytes() const {
    return positions.size() * sizeof(Vec3) + slopes.size() * sizeof(FaceSlopes) + sites.size() * sizeof(SiteFrustum);
}

Frusta make_frusta(const MeshTopology& topology, std::span<const Vec3> positions, const FirstRecords* first,
                   const FrustaOptions& options) {
    const OneRings& rings = topology.rings;
    const std::size_t count = topology.order.size();
    Frusta result;
    result.positions.resize(topology.faces.vertices.size());
    for_each_index(result.positions.size(),
                   [&](std::size_t i) { result.positions[i] = positions[topology.faces.vertices[i]]; });
    const LatticeView lattice = first != nullptr ? first->lattice : view_of(result.positions);
    const MeshFaces faces{result.positions, topology.faces.triangles, lattice};

    PairedEdges edges = copy_of(topology.edges);  // whose marks depend on the positions, too
    const std::vector<EdgeSlope> of_non_manifold = non_manifold_slopes(faces, rings, edges, CLSDF_OPEN_SLOPE);

    result.slopes.resize(count);
    UninitializedVector<FramePlanes::Directions> directions(count);
    UninitializedVector<std::uint8_t> marks(rings.vertex_count());
    for_each_index(marks.size(), [&](std::size_t vertex) { marks[vertex] = 0; });
    tbb::enumerable_thread_specific<GapScreen> screens(
        [&] { return GapScreen(topology.faces.first_vertices, edges.faces, rings, rejection_margin, marks); });
    std::atomic<std::size_t> boxes = 0;
    measure_edges(faces, edges.faces, of_non_manifold, CLSDF_OPEN_SLOPE, [&](EdgeSlopes& stretch) {
        std::size_t boxes_here = 0;
        for (std::size_t face = stretch.begin(); face < stretch.end(); ++face) {
            const TriangleFrame& frame = stretch.frame(face);
            if (options.lean) lean(frame, stretch.slopes(face));
            boxes_here += frame.is_box ? 1U : 0U;
            result.slopes[face] = stretch.slopes(face);
            directions[face] = {frame.normal, frame.inwards};
            if (first != nullptr) write_face_record(topology, result, lattice, face, frame, first->records[face]);
        }
        boxes += boxes_here;
        screens.local().look_at(stretch);
    });
    std::vector<std::uint32_t> left;
    for (GapScreen& screen : screens) {
        const auto& of_screen = screen.finish();
        left.insert(left.end(), of_screen.begin(), of_screen.end());
    }
    find_gaps(faces, edges.faces, rings, FramePlanes(directions, result.slopes), rejection_margin, left, marks);

    result.boxes = boxes;
    const MarkedVertices marked = marked_vertices(marks);
    result.saddle_vertices = marked.saddles;
    if (!options.point_sites) return result;
    result.sites.resize(marked.gaps.size());
    for_each_index(marked.gaps.size(), [&](std::size_t i) {
        result.sites[i] = point_site(faces, topology.order, topology.faces.vertices, rings, marked.gaps[i]);
    });
    return result;
}

}  // namespace clsdf::polyhedra
