#include "polyhedra/edge_slopes.hpp"

#include "polyhedra/dihedral.hpp"
#include "polyhedra/parallel.hpp"

#include <tbb/enumerable_thread_specific.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <utility>

namespace clsdf::polyhedra {

namespace {

/// A face at an edge, filed under the edge's lower vertex.
struct EdgeEntry {
    std::uint32_t other;  // the edge's higher vertex
    EdgeUse use;
    bool upward;  // the face runs along the edge from the lower vertex to the higher one

    bool operator<(const EdgeEntry& right) const {
        if (other != right.other) return other < right.other;
        return use.face != right.use.face ? use.face < right.use.face : use.edge < right.use.edge;
    }
};

class EdgeSlopes {
public:
    EdgeSlopes(const Mesh& mesh, std::span<const Triangle> triangles, std::span<const TriangleFrame> frames,
               std::span<FaceEdges> faces, float open)
        : mesh_(mesh), triangles_(triangles), frames_(frames), faces_(faces), open_(open) {}

    /// Collects the edges of which `vertex` is the lower end.
    void collect(const OneRings& rings, std::uint32_t vertex, std::vector<EdgeEntry>& entries) const {
        entries.clear();
        for (std::size_t i = 0; i < rings.size(vertex); ++i) {
            const Corner corner = rings.corner(vertex, i);
            const Triangle& triangle = triangles_[corner.face];
            const std::uint32_t previous = previous_of_three(corner.vertex);
            const std::uint32_t to = triangle[next_of_three(corner.vertex)];
            const std::uint32_t from = triangle[previous];
            if (to > vertex) entries.push_back({to, {corner.face, corner.vertex}, true});
            if (from > vertex) entries.push_back({from, {corner.face, previous}, false});
        }
        std::sort(entries.begin(), entries.end());
    }

    /// Sets slopes and marks of one edge, given all its faces.
    void set(std::span<const EdgeEntry> edge) const {
        std::uint8_t marks = 0;
        if (edge.size() == 1) marks = edge_open;
        if (edge.size() > 2) marks = edge_non_manifold;
        if (edge.size() == 2 && edge[0].use.face != edge[1].use.face) {
            set_pair(edge[0], edge[1]);
            return;
        }
        for (const EdgeEntry& entry : edge) mark(entry.use, marks);
        const auto is_box = [&](const EdgeEntry& entry) { return frames_[entry.use.face].is_box; };
        if (std::any_of(edge.begin(), edge.end(), is_box)) {
            for (const EdgeEntry& entry : edge) set_slopes(entry.use, 0, 0);
        } else if (edge.size() == 1) {
            set_slopes(edge[0].use, infinite, infinite);
        } else {
            set_around(edge);
        }
    }

private:
    static constexpr double infinite = std::numeric_limits<double>::infinity();

    void mark(const EdgeUse& use, std::uint8_t marks) const { faces_[use.face].marks[use.edge] = marks; }

    /// A box takes the wedges of all its edges, so that faces beside it need none.
    void set_slopes(const EdgeUse& use, double above, double below) const {
        const bool is_box = frames_[use.face].is_box;
        FaceEdges& face = faces_[use.face];
        face.above[use.edge] = is_box ? open_ : std::min(open_, rounded_up(above));
        face.below[use.edge] = is_box ? open_ : std::min(open_, rounded_up(below));
    }

    void set_pair(const EdgeEntry& first, const EdgeEntry& second) const {
        const bool oriented = first.upward != second.upward;
        const int side = side_of_plane(mesh_, triangles_, frames_, first.use, second.use);
        std::uint8_t marks = 0;
        if (!oriented) {
            marks = edge_unoriented;
        } else if (side != 0) {
            marks = side < 0 ? edge_convex : edge_concave;
        }

        double above = 0;
        double below = 0;
        const TriangleFrame& first_frame = frames_[first.use.face];
        const TriangleFrame& second_frame = frames_[second.use.face];
        if (!first_frame.is_box && !second_frame.is_box) {
            const Vector first_inward = first_frame.inward(first.use.edge);
            const Vector second_inward = second_frame.inward(second.use.edge);
            if (folded(first_inward, second_inward)) {
                marks |= edge_open;
                above = below = infinite;
            } else if (side != 0) {
                (side < 0 ? above : below) = half_wedge_slope(first_inward, second_inward);
            }
        }
        mark(first.use, marks);
        mark(second.use, marks);
        set_slopes(first.use, above, below);
        if (!oriented) std::swap(above, below);
        set_slopes(second.use, above, below);
    }

    /// Three faces or more: each shares its wedges with the next faces in either direction around the edge. Faces
    /// folded onto each other have an empty wedge between them, whichever comes first.
    void set_around(std::span<const EdgeEntry> edge) const {
        struct Spoke {
            double angle;
            std::size_t entry;
        };
        const TriangleFrame& first = frames_[edge[0].use.face];
        const Vector x = first.inward(edge[0].use.edge);
        const Vector y = first.normal;
        std::vector<Spoke> spokes;
        for (std::size_t i = 0; i < edge.size(); ++i) {
            const Vector inward = frames_[edge[i].use.face].inward(edge[i].use.edge);
            spokes.push_back({std::atan2(inward.dot(y), inward.dot(x)), i});
        }
        std::sort(spokes.begin(), spokes.end(), [](const Spoke& a, const Spoke& b) {
            return a.angle != b.angle ? a.angle < b.angle : a.entry < b.entry;
        });

        constexpr double turn = 2 * std::numbers::pi;
        const auto slope_of_gap = [](double gap) {
            if (gap <= std::numbers::pi) return 0.0;
            return gap < turn - fold_angle ? -1 / std::tan(gap / 2) : infinite;
        };
        for (std::size_t i = 0; i < spokes.size(); ++i) {
            const double angle = spokes[i].angle;
            const double next = i + 1 < spokes.size() ? spokes[i + 1].angle : spokes.front().angle + turn;
            const double previous = i > 0 ? spokes[i - 1].angle : spokes.back().angle - turn;
            const EdgeUse& use = edge[spokes[i].entry].use;
            const Vector turning = -std::sin(angle) * x + std::cos(angle) * y;
            double above = slope_of_gap(next - angle);
            double below = slope_of_gap(angle - previous);
            if (frames_[use.face].normal.dot(turning) < 0) std::swap(above, below);
            set_slopes(use, above, below);
        }
    }

    const Mesh& mesh_;
    std::span<const Triangle> triangles_;
    std::span<const TriangleFrame> frames_;
    std::span<FaceEdges> faces_;
    float open_;
};

}  // namespace

float open_slope(double half_width, double slack) {
    return std::max(CLSDF_OPEN_SLOPE, rounded_up(2 * half_width / slack));
}

std::vector<FaceEdges> edge_slopes(const Mesh& mesh, std::span<const Triangle> triangles,
                                   std::span<const TriangleFrame> frames, const OneRings& rings, float open) {
    std::vector<FaceEdges> faces(triangles.size());
    for_each_index(triangles.size(), [&](std::size_t face) {
        if (frames[face].is_box) faces[face].above = faces[face].below = {open, open, open};
    });
    const EdgeSlopes slopes(mesh, triangles, frames, faces, open);
    tbb::enumerable_thread_specific<std::vector<EdgeEntry>> entries_of_thread;
    for_each_index(rings.vertex_count(), [&](std::size_t vertex) {
        std::vector<EdgeEntry>& entries = entries_of_thread.local();
        slopes.collect(rings, static_cast<std::uint32_t>(vertex), entries);
        const auto end = entries.end();
        for (auto first = entries.begin(); first != end;) {
            const auto last = std::find_if(first, end, [&](const EdgeEntry& e) { return e.other != first->other; });
            slopes.set({first, last});
            first = last;
        }
    });
    return faces;
}

void lean(const TriangleFrame& frame, FaceEdges& edges) {
    const double cosine = frame.normal_across[CLSDF_HALF_RIGHT] * frame.normal_across[CLSDF_HALF_LEFT] -
                          frame.normal_along[CLSDF_HALF_RIGHT] * frame.normal_along[CLSDF_HALF_LEFT];
    if (!(cosine > 0)) return;
    const std::size_t right = next_of_three(frame.base_edge);
    const std::size_t left = previous_of_three(frame.base_edge);
    for (std::array<float, 3>* slopes : {&edges.above, &edges.below}) {
        float& at_right = (*slopes)[right];
        float& at_left = (*slopes)[left];
        const float from_right = rounded_up(cosine * static_cast<double>(at_right));
        const float from_left = rounded_up(cosine * static_cast<double>(at_left));
        at_right = std::max(at_right, from_left);
        at_left = std::max(at_left, from_right);
    }
}

}  // namespace clsdf::polyhedra
