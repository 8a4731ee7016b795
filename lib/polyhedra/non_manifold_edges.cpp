#include "polyhedra/non_manifold_edges.hpp"

#include "core/parallel.hpp"
#include "polyhedra/edges_of_vertex.hpp"
#include "polyhedra/wedge_batch.hpp"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <limits>
#include <numbers>
#include <utility>

namespace clsdf::polyhedra {

namespace {

/// Each face shares its wedges with the next faces in either direction around the edge. Faces folded onto each other
/// have an empty wedge between them, whichever comes first.
void set_around(std::span<const EdgeEntry> faces, std::span<const TriangleFrame> frames, float open,
                std::span<EdgeSlope> slopes) {
    struct Spoke {
        double angle;
        std::size_t face;
    };
    const Vector x = frames[0].inwards[faces[0].edge().vertex];
    const Vector y = frames[0].normal;
    std::vector<Spoke> spokes;
    for (std::size_t i = 0; i < faces.size(); ++i) {
        const Vector& inward = frames[i].inwards[faces[i].edge().vertex];
        spokes.push_back({std::atan2(inward.dot(y), inward.dot(x)), i});
    }
    std::stable_sort(spokes.begin(), spokes.end(), [](const Spoke& a, const Spoke& b) { return a.angle < b.angle; });

    constexpr double turn = 2 * std::numbers::pi;
    const auto slope_of_gap = [open](double gap) {
        if (gap <= std::numbers::pi) return 0.0F;
        return gap < turn - fold_angle ? std::min(open, widened(-1 / std::tan(gap / 2))) : open;
    };
    for (std::size_t i = 0; i < spokes.size(); ++i) {
        const double angle = spokes[i].angle;
        const double next = i + 1 < spokes.size() ? spokes[i + 1].angle : spokes.front().angle + turn;
        const double previous = i > 0 ? spokes[i - 1].angle : spokes.back().angle - turn;
        const Vector turning = -std::sin(angle) * x + std::cos(angle) * y;
        EdgeSlope& slope = slopes[spokes[i].face];
        slope = {slope_of_gap(next - angle), slope_of_gap(angle - previous)};
        if (frames[spokes[i].face].normal.dot(turning) < 0) std::swap(slope.above, slope.below);
    }
}

}  // namespace

std::vector<EdgeSlope> non_manifold_slopes(const MeshFaces& faces, const OneRings& rings, PairedEdges& edges,
                                           float open) {
    std::vector<EdgeSlope> slopes(edges.non_manifold_corners);
    std::atomic<std::size_t> taken = 0;
    for_each_range(edges.non_manifold_ends.size(), [&](std::size_t begin, std::size_t end) {
        std::vector<EdgeEntry> entries;
        std::vector<TriangleFrame> frames;
        for (std::size_t i = begin; i < end; ++i) {
            edges_above(faces.triangles, rings, edges.non_manifold_ends[i], entries);
            for_each_edge(entries, [&](std::span<const EdgeEntry> edge) {
                if (!is_non_manifold(edge)) return;
                const std::size_t place = taken.fetch_add(edge.size());
                frames.clear();
                for (const EdgeEntry& entry : edge) frames.push_back(faces.frame(entry.edge().face));
                // A box takes the wedges of all its edges, so that faces beside it need none.
                const bool at_box =
                    std::any_of(frames.begin(), frames.end(), [](const TriangleFrame& frame) { return frame.is_box; });
                if (!at_box) set_around(edge, frames, open, std::span(slopes).subspan(place, edge.size()));
                for (std::size_t face = 0; face < edge.size(); ++face) {
                    const Corner corner = edge[face].edge();
                    edges.faces[corner.face].across[corner.vertex] = static_cast<std::uint32_t>(place + face);
                    if (at_box) edges.faces[corner.face].marks[corner.vertex] |= edge_at_box;
                }
            });
        }
    });
    return slopes;
}

}  // namespace clsdf::polyhedra
