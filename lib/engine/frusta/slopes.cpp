#include "frusta/slopes.hpp"

#include "core/parallel.hpp"
#include "frusta/one_lane.hpp"
#include "mesh/expansions.hpp"
#include "mesh/predicates.hpp"

#include <algorithm>
#include <cmath>
#include <mutex>
#include <numbers>
#include <utility>

namespace clsdf::engine {

int side_of_plane(const MeshFaces& faces, std::uint32_t first, const Corner& second) {
    const auto& [a, b, c] = faces.corners(first);
    const Vec3& p = faces.position(faces.triangles[second.face][previous_of_three(second.vertex)]);
    const std::array<Vec3, 4> points{a, b, c, p};
    return expansions::are_exact(points)
               ? expansions::orientation_in_space(expansions::vector(a), expansions::vector(b), expansions::vector(c),
                                                  expansions::vector(p))
               : orientation(a, b, c, p);
}

void lean(const TriangleFrame& frame, FaceSlopes& slopes) {
    for (std::array<float, 3>* side : {&slopes.above, &slopes.below}) {
        std::array<double, 3> by_edge;  // of the polyhedron
        for (std::uint32_t k = 0; k < 3; ++k) by_edge[frame.polyhedron_edge(k)] = static_cast<double>((*side)[k]);
        one_lane::lean(&frame.face, by_edge.data());
        for (std::uint32_t k = 0; k < 3; ++k) (*side)[k] = static_cast<float>(by_edge[frame.polyhedron_edge(k)]);
    }
}

namespace {

constexpr EdgeSlope open_edge{CLSDF_OPEN_SLOPE, CLSDF_OPEN_SLOPE};

void set_slope(MeasuredFace& measured, std::uint32_t edge, const EdgeSlope& slope) {
    measured.slopes.above[edge] = slope.above;
    measured.slopes.below[edge] = slope.below;
}

/// Each face shares its wedges with the next faces in either direction around the edge. Faces folded onto each other
/// have an empty wedge between them, whichever comes first.
void set_around(std::span<const EdgeEntry> faces, std::span<const TriangleFrame> frames, std::span<EdgeSlope> slopes) {
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
    const auto slope_of_gap = [](double gap) {
        if (gap <= std::numbers::pi) return 0.0F;
        return gap < turn - fold_angle ? std::min(CLSDF_OPEN_SLOPE, widened(-1 / std::tan(gap / 2))) : CLSDF_OPEN_SLOPE;
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

FaceMeasures::FaceMeasures(const MeshFaces& faces, const OneRings& rings, const PairedEdges& edges)
    : faces_(faces), edges_(edges.faces) {
    measure_non_manifold(rings, edges.non_manifold_ends);
    std::ranges::sort(non_manifold_, {}, &NonManifoldEdge::edge);
}

void FaceMeasures::measure_non_manifold(const OneRings& rings, std::span<const std::uint32_t> ends) {
    std::mutex mutex;
    for_each_range(ends.size(), [&](std::size_t begin, std::size_t end) {
        std::vector<NonManifoldEdge> found;
        std::vector<EdgeEntry> entries;
        std::vector<TriangleFrame> frames;
        std::vector<EdgeSlope> slopes;
        for (std::size_t i = begin; i < end; ++i) {
            edges_above(faces_.triangles, rings, ends[i], entries);
            for_each_edge(entries, [&](std::span<const EdgeEntry> edge) {
                if (!is_non_manifold(edge)) return;
                frames.clear();
                for (const EdgeEntry& entry : edge) frames.push_back(faces_.frame(entry.edge().face));
                const bool at_box =
                    std::any_of(frames.begin(), frames.end(), [](const TriangleFrame& frame) { return frame.is_box; });
                slopes.resize(edge.size());
                if (!at_box) set_around(edge, frames, slopes);
                for (std::size_t face = 0; face < edge.size(); ++face)
                    found.push_back({edge[face].edge().packed(), at_box ? std::nullopt : std::optional(slopes[face])});
            });
        }
        const std::lock_guard lock(mutex);
        non_manifold_.insert(non_manifold_.end(), found.begin(), found.end());
    });
}

MeasuredFace FaceMeasures::measure(std::uint32_t face) const {
    MeasuredFace measured;
    measured.frame = faces_.frame(face);
    measured.marks = edges_[face].marks;
    for (std::uint32_t k = 0; k < 3; ++k) {
        if ((measured.marks[k] & (edge_open | edge_non_manifold | edge_at_box)) != 0)
            set_unpaired({face, k}, measured);
        else
            set_pair({face, k}, measured);
    }
    return measured;
}

std::optional<EdgeSlope> FaceMeasures::non_manifold_slope(const Corner& edge) const {
    const std::uint32_t packed = edge.packed();
    const auto entry = std::ranges::lower_bound(non_manifold_, packed, {}, &NonManifoldEdge::edge);
    return entry != non_manifold_.end() && entry->edge == packed ? entry->slope : open_edge;
}

/// An edge without exactly one other face. A box takes the wedges of all its edges, so that faces beside it need none.
void FaceMeasures::set_unpaired(const Corner& edge, MeasuredFace& measured) const {
    EdgeSlope slope = open_edge;
    std::uint8_t& marks = measured.marks[edge.vertex];
    if ((marks & edge_non_manifold) != 0) {
        const std::optional<EdgeSlope> found = non_manifold_slope(edge);
        if (!found) marks |= edge_at_box;
        if (!measured.frame.is_box) slope = found.value_or(EdgeSlope{0, 0});
    }
    if (measured.frame.is_box) marks |= edge_at_box;
    set_slope(measured, edge.vertex, slope);
}

void FaceMeasures::set_pair(const Corner& edge, MeasuredFace& measured) const {
    const Corner other = Corner::unpack(edges_[edge.face].across[edge.vertex]);
    const TriangleFrame& own = measured.frame;
    const TriangleFrame across = faces_.frame(other.face);
    one_lane::FacePair pair = face_pair(vectors_of(own.inwards[edge.vertex]), vectors_of(across.inwards[other.vertex]),
                                        vectors_of(own.normal), own.turn + across.turn);
    if (pair.side == 0) pair.side = side_of_plane(faces_, edge.face, other);
    double above = 0, below = 0;
    std::uint8_t& marks = measured.marks[edge.vertex];
    std::uint32_t added = set_pair_slopes(pair, &above, &below);
    if ((marks & edge_unoriented) != 0) added &= ~std::uint32_t{edge_convex | edge_concave};
    if (own.is_box || across.is_box) {
        added = (added & (edge_convex | edge_concave)) | edge_at_box;
        above = below = own.is_box ? CLSDF_OPEN_SLOPE : 0;
    }
    marks = static_cast<std::uint8_t>(marks | added);
    set_slope(measured, edge.vertex, {static_cast<float>(above), static_cast<float>(below)});
}

}  // namespace clsdf::engine
