#include "polyhedra/leaned_frusta.hpp"

#include "core/parallel.hpp"
#include "polyhedra/edge_slopes.hpp"
#include "polyhedra/gap_screen.hpp"
#include "polyhedra/gaps.hpp"
#include "polyhedra/mesh_faces.hpp"
#include "polyhedra/morton_order.hpp"
#include "polyhedra/non_manifold_edges.hpp"
#include "polyhedra/one_rings.hpp"
#include "polyhedra/ordered_faces.hpp"
#include "polyhedra/pack.hpp"
#include "polyhedra/pair_edges.hpp"
#include "polyhedra/point_site.hpp"
#include "polyhedra/record_planes.hpp"

#include <tbb/enumerable_thread_specific.h>

#include <algorithm>
#include <atomic>
#include <new>

namespace clsdf::polyhedra {

namespace {

/// Room for the point sites of most meshes: one of 240 faces needs one on a noisy scan, one of 1600 on a smooth one.
std::size_t spare_records(std::size_t faces) {
    return 64 + faces / 128;
}

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

bool has_non_manifold_edge(const FaceEdges& edges) {
    return ((edges.marks[0] | edges.marks[1] | edges.marks[2]) & edge_non_manifold) != 0;
}

}  // namespace

LeanedFrusta leaned_frusta(const Mesh& mesh, const LatticeView& lattice, double half_width, double slack,
                           const LeanedFrustaOptions& options) {
    LeanedFrusta result;
    const auto memory = [&](std::size_t count) {
        result.polyhedra.resize(count);
        return std::span<Polyhedron>(result.polyhedra);
    };
    static_cast<LeanedCounts&>(result) = leaned_frusta(mesh, lattice, half_width, slack, memory, nullptr, options);
    result.polyhedra.resize(result.records);
    return result;
}

LeanedCounts leaned_frusta(const Mesh& mesh, const LatticeView& lattice, double half_width, double slack,
                           const std::function<std::span<Polyhedron>(std::size_t)>& memory, ScratchMemory* scratch,
                           const LeanedFrustaOptions& options) {
    const UninitializedVector<std::uint32_t> order = morton_order(mesh, scratch);
    const std::size_t count = order.size();
    const OrderedFaces ordered = ordered_faces(mesh, order, scratch);
    const MeshFaces faces{ordered.positions, ordered.triangles, lattice};

    const OneRings rings(ordered, scratch);
    PairedEdges edges = pair_edges(ordered.triangles, rings, scratch);
    const float open = open_slope(half_width, slack);
    const std::vector<EdgeSlope> of_non_manifold = non_manifold_slopes(faces, rings, edges, open);

    const std::size_t room = count + spare_records(count);
    std::span<Polyhedron> records = memory(room);
    const double margin = rejection_margin(half_width, slack);
    UninitializedVector<std::uint8_t> marks(rings.vertex_count(), scratch);
    for_each_index(marks.size(), [&](std::size_t vertex) { marks[vertex] = 0; });
    tbb::enumerable_thread_specific<GapScreen> screens(
        [&] { return GapScreen(ordered.first_vertices, edges.faces, rings, margin, marks); });
    std::atomic<std::size_t> boxes = 0;
    measure_edges(faces, edges.faces, of_non_manifold, open, [&](EdgeSlopes& stretch) {
        for (std::size_t face = stretch.begin(); face < stretch.end(); ++face) {
            const TriangleFrame& frame = stretch.frame(face);
            if (options.lean) lean(frame, stretch.slopes(face));
            if (frame.is_box) ++boxes;
            // Constructed in its place rather than copied there.
            new (&records[face])
                Polyhedron(pack(frame, stretch.slopes(face), order[face], faces, faces.triangles[face]));
            if (has_non_manifold_edge(edges.faces[face])) records[face].flags |= CLSDF_POLYHEDRON_NON_MANIFOLD;
        }
        screens.local().look_at(stretch);
    });
    std::vector<std::uint32_t> left;
    for (GapScreen& screen : screens) {
        const auto& of_screen = screen.finish();
        left.insert(left.end(), of_screen.begin(), of_screen.end());
    }
    find_gaps(faces, edges.faces, rings, RecordPlanes(records.first(count), edges.faces, lattice), margin, left, marks);

    LeanedCounts result;
    result.boxes = boxes;
    const MarkedVertices marked = marked_vertices(marks);
    result.saddle_vertices = marked.saddles;
    std::vector<std::uint32_t> gaps;
    if (options.point_sites) gaps = marked.gaps;
    // The order of the mesh's own vertices.
    std::sort(gaps.begin(), gaps.end(),
              [&](std::uint32_t a, std::uint32_t b) { return ordered.vertices[a] < ordered.vertices[b]; });
    result.point_sites = gaps.size();
    result.records = count + gaps.size();

    if (result.records > room) records = memory(result.records);
    for_each_index(gaps.size(), [&](std::size_t i) {
        const PointSite site = point_site(faces, order, ordered.vertices, rings, gaps[i], open);
        new (&records[count + i])
            Polyhedron(pack(site.frame, site.slopes, order[site.face], faces, {gaps[i], gaps[i], gaps[i]}));
    });
    return result;
}

}  // namespace clsdf::polyhedra
