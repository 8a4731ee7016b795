#include "polyhedra/edge_slopes.hpp"

#include "polyhedra/dihedral.hpp"
#include "polyhedra/edges_above.hpp"
#include "polyhedra/pair_batch.hpp"
#include "polyhedra/parallel.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <utility>
#include <vector>

namespace clsdf::polyhedra {

namespace {

class EdgeSlopes {
public:
    EdgeSlopes(const Mesh& mesh, std::span<const Triangle> triangles, std::span<const TriangleFrame> frames,
               std::span<FaceEdges> faces, float open)
        : mesh_(mesh), triangles_(triangles), frames_(frames), faces_(faces), open_(open) {}

    /// Sets what is known of the edges of which `vertex` is the lower end, where each has two faces that run along it
    /// in opposite directions; false where one has not, or many meet. Some may have been set by then, to the same as
    /// set() does.
    bool set_pairs_above(std::uint32_t vertex, const OneRings& rings) {
        constexpr std::size_t few = 16;
        const std::size_t count = rings.size(vertex);
        if (count > few) return false;
        std::array<Corner, few> corners;
        std::array<std::uint32_t, few> next;
        std::array<std::uint32_t, few> previous;
        std::size_t unpaired = 0;
        for (std::size_t i = 0; i < count; ++i) {
            corners[i] = rings.corner(vertex, i);
            const Triangle& triangle = triangles_[corners[i].face];
            next[i] = triangle[next_of_three(corners[i].vertex)];
            previous[i] = triangle[previous_of_three(corners[i].vertex)];
            if (previous[i] > vertex) ++unpaired;
            fetch_ahead(frames_[corners[i].face]);
        }
        for (std::size_t i = 0; i < count; ++i) {
            if (next[i] <= vertex) continue;
            std::size_t leaving = 0;
            std::size_t arriving = 0;
            std::size_t other = 0;
            for (std::size_t j = 0; j < count; ++j) {
                if (next[j] == next[i]) ++leaving;
                if (previous[j] != next[i]) continue;
                ++arriving;
                other = j;
            }
            const Corner& edge = corners[i];
            // A face with a vertex twice arrives along the edge that it leaves by.
            if (leaving != 1 || arriving != 1 || corners[other].face == edge.face) return false;
            const Corner across{corners[other].face, previous_of_three(corners[other].vertex)};
            add_pair(edge.face < across.face ? PairBatch::Pair{edge, across, true}
                                             : PairBatch::Pair{across, edge, true});
            --unpaired;
        }
        return unpaired == 0;
    }

    /// Sets what is known of one edge, given all its faces.
    void set(std::span<const EdgeEntry> faces) {
        if (faces.size() == 2 && faces[0].edge().face != faces[1].edge().face) {
            const Corner first = faces[0].edge();
            const Corner second = faces[1].edge();
            add_pair({first, second, triangles_[first.face][first.vertex] != triangles_[second.face][second.vertex]});
            return;
        }
        const bool at_box = std::any_of(faces.begin(), faces.end(),
                                        [&](const EdgeEntry& entry) { return frames_[entry.edge().face].is_box; });
        std::uint8_t marks = faces.size() == 1 ? edge_open : edge_non_manifold;
        if (at_box) marks |= edge_at_box;
        for (const EdgeEntry& entry : faces) {
            faces_[entry.edge().face].marks[entry.edge().vertex] = marks;
            faces_[entry.edge().face].across[entry.edge().vertex] = 0;
        }
        if (at_box) {
            for (const EdgeEntry& entry : faces) set_slopes(entry.edge(), 0, 0);
        } else if (faces.size() == 1) {
            set_slopes(faces[0].edge(), infinite, infinite);
        } else {
            set_around(faces);
        }
    }

    /// Sets what is known of the edges that are still waiting for others to be measured with.
    void finish() {
        PairBatch::Results results;
        batch_.measure(results);
        for (std::size_t i = 0; i < batch_.size(); ++i)
            set_pair(batch_.pair(i), results.sine[i], results.squared_apart[i], results.slope[i]);
        batch_.clear();
    }

private:
    static constexpr double infinite = std::numeric_limits<double>::infinity();

    /// A box takes the wedges of all its edges, so that faces beside it need none.
    void set_slopes(const Corner& edge, double above, double below) const {
        const bool is_box = frames_[edge.face].is_box;
        FaceEdges& face = faces_[edge.face];
        face.above[edge.vertex] = is_box ? open_ : std::min(open_, widened(above));
        face.below[edge.vertex] = is_box ? open_ : std::min(open_, widened(below));
    }

    void add_pair(const PairBatch::Pair& pair) {
        batch_.add(pair, frames_[pair.first.face], frames_[pair.second.face]);
        if (batch_.is_full()) finish();
    }

    void set_pair(const PairBatch::Pair& pair, double sine, double squared_apart, double slope) const {
        const auto& [first, second, oriented] = pair;
        const TriangleFrame& first_frame = frames_[first.face];
        const TriangleFrame& second_frame = frames_[second.face];
        int side = certain_side(first_frame, second_frame, sine);
        if (side == 0) side = side_of_plane(mesh_, triangles_, frames_, first, second);
        std::uint8_t marks = 0;
        if (!oriented) {
            marks = edge_unoriented;
        } else if (side != 0) {
            marks = side < 0 ? edge_convex : edge_concave;
        }

        double above = 0;
        double below = 0;
        if (first_frame.is_box || second_frame.is_box) {
            marks |= edge_at_box;
        } else if (folded(squared_apart)) {
            marks |= edge_open | edge_folded;
            above = below = infinite;
        } else {
            above = side < 0 ? slope : 0;
            below = side > 0 ? slope : 0;
        }
        set_one_of_pair(first, second, marks, above, below);
        if (!oriented) std::swap(above, below);
        set_one_of_pair(second, first, marks, above, below);
    }

    void set_one_of_pair(const Corner& edge, const Corner& across, std::uint8_t marks, double above,
                         double below) const {
        faces_[edge.face].marks[edge.vertex] = marks;
        faces_[edge.face].across[edge.vertex] = across.packed();
        set_slopes(edge, above, below);
    }

    /// Three faces or more: each shares its wedges with the next faces in either direction around the edge. Faces
    /// folded onto each other have an empty wedge between them, whichever comes first.
    void set_around(std::span<const EdgeEntry> faces) const {
        struct Spoke {
            double angle;
            Corner edge;
        };
        const TriangleFrame& first = frames_[faces[0].edge().face];
        const Vector x = first.inwards[faces[0].edge().vertex];
        const Vector y = first.normal;
        std::vector<Spoke> spokes;
        for (const EdgeEntry& entry : faces) {
            const Vector inward = frames_[entry.edge().face].inwards[entry.edge().vertex];
            spokes.push_back({std::atan2(inward.dot(y), inward.dot(x)), entry.edge()});
        }
        std::stable_sort(spokes.begin(), spokes.end(),
                         [](const Spoke& a, const Spoke& b) { return a.angle < b.angle; });

        constexpr double turn = 2 * std::numbers::pi;
        const auto slope_of_gap = [](double gap) {
            if (gap <= std::numbers::pi) return 0.0;
            return gap < turn - fold_angle ? -1 / std::tan(gap / 2) : infinite;
        };
        for (std::size_t i = 0; i < spokes.size(); ++i) {
            const double angle = spokes[i].angle;
            const double next = i + 1 < spokes.size() ? spokes[i + 1].angle : spokes.front().angle + turn;
            const double previous = i > 0 ? spokes[i - 1].angle : spokes.back().angle - turn;
            const Vector turning = -std::sin(angle) * x + std::cos(angle) * y;
            double above = slope_of_gap(next - angle);
            double below = slope_of_gap(angle - previous);
            if (frames_[spokes[i].edge.face].normal.dot(turning) < 0) std::swap(above, below);
            set_slopes(spokes[i].edge, above, below);
        }
    }

    const Mesh& mesh_;
    std::span<const Triangle> triangles_;
    std::span<const TriangleFrame> frames_;
    std::span<FaceEdges> faces_;
    float open_;
    PairBatch batch_;
};

}  // namespace

float open_slope(double half_width, double slack) {
    return std::max(CLSDF_OPEN_SLOPE, widened(2 * half_width / slack));
}

UninitializedVector<FaceEdges> edge_slopes(const Mesh& mesh, std::span<const Triangle> triangles,
                                           std::span<const TriangleFrame> frames, const OneRings& rings, float open,
                                           ScratchMemory* scratch) {
    UninitializedVector<FaceEdges> faces(triangles.size(), scratch);
    for_each_index(triangles.size(), [&](std::size_t face) {
        if (!frames[face].is_box) return;
        faces[face].across = {};
        faces[face].above = faces[face].below = {open, open, open};
        faces[face].marks = {edge_at_box, edge_at_box, edge_at_box};  // an edge from a vertex to itself is not visited
    });
    for_each_range(triangles.size(), [&](std::size_t begin, std::size_t end) {
        EdgeSlopes slopes(mesh, triangles, frames, faces, open);
        std::vector<EdgeEntry> entries;
        for_each_vertex(triangles, rings, begin, end, [&](std::uint32_t vertex) {
            if (slopes.set_pairs_above(vertex, rings)) return;
            edges_above(triangles, rings, vertex, entries);
            for_each_edge(entries, [&](std::span<const EdgeEntry> edge) { slopes.set(edge); });
        });
        slopes.finish();
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
        const float from_right = widened(cosine * static_cast<double>(at_right));
        const float from_left = widened(cosine * static_cast<double>(at_left));
        at_right = std::max(at_right, from_left);
        at_left = std::max(at_left, from_right);
    }
}

}  // namespace clsdf::polyhedra
