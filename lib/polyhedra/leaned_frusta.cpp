#include "polyhedra/leaned_frusta.hpp"

#include "polyhedra/edge_slopes.hpp"
#include "polyhedra/frame_batch.hpp"
#include "polyhedra/gaps.hpp"
#include "polyhedra/morton_order.hpp"
#include "polyhedra/one_rings.hpp"
#include "polyhedra/pack.hpp"
#include "polyhedra/parallel.hpp"
#include "polyhedra/point_site.hpp"
#include "polyhedra/triangle_frame.hpp"

#include <algorithm>
#include <new>

namespace clsdf::polyhedra {

LeanedFrusta leaned_frusta(const Mesh& mesh, const LatticeView& lattice, double half_width, double slack,
                           const LeanedFrustaOptions& options) {
    LeanedFrusta result;
    const auto memory = [&](std::size_t count) {
        result.polyhedra.resize(count);
        return std::span<Polyhedron>(result.polyhedra);
    };
    static_cast<LeanedCounts&>(result) = leaned_frusta(mesh, lattice, half_width, slack, memory, nullptr, options);
    return result;
}

LeanedCounts leaned_frusta(const Mesh& mesh, const LatticeView& lattice, double half_width, double slack,
                           const std::function<std::span<Polyhedron>(std::size_t)>& memory, ScratchMemory* scratch,
                           const LeanedFrustaOptions& options) {
    const UninitializedVector<std::uint32_t> order = morton_order(mesh, scratch);
    const std::size_t count = order.size();
    UninitializedVector<Triangle> triangles(count, scratch);
    UninitializedVector<TriangleFrame> frames(count, scratch);
    for_each_range(count, [&](std::size_t begin, std::size_t end) {
        for (std::size_t face = begin; face != end; ++face) triangles[face] = mesh.triangles()[order[face]];
        triangle_frames(mesh, std::span(triangles).subspan(begin, end - begin), lattice,
                        std::span(frames).subspan(begin, end - begin));
    });

    const OneRings rings(triangles, mesh.vertices().size(), scratch);
    const float open = open_slope(half_width, slack);
    UninitializedVector<FaceEdges> faces = edge_slopes(mesh, triangles, frames, rings, open, scratch);
    if (options.lean) for_each_index(count, [&](std::size_t face) { lean(frames[face], faces[face]); });
    const std::vector<std::uint8_t> marks =
        find_gaps(mesh, triangles, frames, faces, rings, lattice, half_width, slack);

    LeanedCounts result;
    std::vector<std::size_t> gaps;
    for (std::size_t vertex = 0; vertex < marks.size(); ++vertex) {
        if (marks[vertex] & vertex_saddle) ++result.saddle_vertices;
        if ((marks[vertex] & vertex_gap) && options.point_sites) gaps.push_back(vertex);
    }
    result.point_sites = gaps.size();
    result.boxes = static_cast<std::size_t>(
        std::count_if(frames.begin(), frames.end(), [](const TriangleFrame& frame) { return frame.is_box; }));

    const std::span<Polyhedron> polyhedra = memory(count + gaps.size());
    // Constructed in their place rather than copied there.
    for_each_index(count, [&](std::size_t face) {
        new (&polyhedra[face]) Polyhedron(pack(frames[face], faces[face], order[face], lattice));
    });
    for_each_index(gaps.size(), [&](std::size_t i) {
        const PointSite site = point_site(mesh, triangles, order, rings, gaps[i], lattice, open);
        new (&polyhedra[count + i]) Polyhedron(pack(site.frame, site.edges, order[site.face], lattice));
    });
    return result;
}

}  // namespace clsdf::polyhedra
