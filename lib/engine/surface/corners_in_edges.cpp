#include "surface/corners_in_edges.hpp"

#include "mesh/box_index.hpp"
#include "mesh/disjoint_sets.hpp"
#include "mesh/one_rings.hpp"
#include "surface/edge_counts.hpp"
#include "surface/local_frame.hpp"
#include "surface/parts.hpp"
#include "surface/sign_surface.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <map>
#include <optional>
#include <utility>

namespace clsdf {

namespace {

/// The way from the start of an edge to the point of it that is nearest to another one, as a part of the edge; the
/// distance between the two.
struct Foot {
    double along, distance;
};
Foot foot_of(const Vec3& from, const Vec3& to, const Vec3& point) {
    const auto difference = [](const Vec3& a, const Vec3& b) { return Vec3{a[0] - b[0], a[1] - b[1], a[2] - b[2]}; };
    const Vec3 edge = difference(to, from), way = difference(point, from);
    const double squared = edge[0] * edge[0] + edge[1] * edge[1] + edge[2] * edge[2];
    const double along = squared > 0 ? (way[0] * edge[0] + way[1] * edge[1] + way[2] * edge[2]) / squared : 0;
    return {along, length_of({way[0] - along * edge[0], way[1] - along * edge[1], way[2] - along * edge[2]})};
}

/// The ends of open edges, and which of them lie in an edge.
class Ends {
public:
    /// vertices: in any order, each as often as you like.
    Ends(const Mesh& mesh, std::vector<std::uint32_t> vertices) : frame_(mesh), vertices_(std::move(vertices)) {
        std::ranges::sort(vertices_);
        const auto repeated = std::ranges::unique(vertices_);
        vertices_.erase(repeated.begin(), repeated.end());
        std::vector<Box> boxes;
        boxes.reserve(vertices_.size());
        for (const std::uint32_t vertex : vertices_) boxes.push_back({frame_.local(vertex), frame_.local(vertex)});
        index_.emplace(boxes);
    }

    /// Ascending.
    const std::vector<std::uint32_t>& all() const { return vertices_; }
    bool contains(std::uint32_t vertex) const { return std::ranges::binary_search(vertices_, vertex); }
    /// The edge from a to b, and those that lie in it, in their order.
    std::vector<std::uint32_t> points_of(std::uint32_t a, std::uint32_t b) const {
        constexpr double tolerance = 2 * joining_tolerance;  // half of the longest side is 1
        const Vec3 from = frame_.local(a), to = frame_.local(b);
        std::vector<std::pair<double, std::uint32_t>> within;
        Box box = empty_box;
        for (const Vec3& end : {from, to}) add(box, {end, end});
        index_->any(widened(box, tolerance), [&](std::size_t n) {
            const std::uint32_t vertex = vertices_[n];
            if (vertex == a || vertex == b) return false;
            const auto [along, distance] = foot_of(from, to, frame_.local(vertex));
            if (along > 0 && along < 1 && distance <= tolerance) within.emplace_back(along, vertex);
            return false;
        });
        std::ranges::sort(within);
        std::vector<std::uint32_t> points{a};
        for (const auto& [along, vertex] : within) points.push_back(vertex);
        points.push_back(b);
        return points;
    }

private:
    LocalFrame frame_;
    std::vector<std::uint32_t> vertices_;
    std::optional<BoxIndex> index_;
};

}  // namespace

std::vector<ClosingTriangle> corners_in_edges(const Mesh& mesh, std::span<const Triangle> triangles) {
    const EdgeCounts edges = count_edges(triangles, mesh.vertices().size());
    // Edges that one face more uses in one direction than in the other one, and such a face.
    std::map<std::pair<std::uint32_t, std::uint32_t>, std::uint32_t> open;  // from, to
    std::vector<std::uint32_t> of_open;
    for (const UnbalancedEdge& edge : edges.unbalanced)
        if (edge.net == 1 || edge.net == -1) {
            const auto way = edge.net > 0 ? std::pair(edge.lower, edge.higher) : std::pair(edge.higher, edge.lower);
            open.emplace(way, 0);
            of_open.insert(of_open.end(), {edge.lower, edge.higher});
        }
    if (open.empty()) return {};
    for (std::uint32_t face = 0; face < triangles.size(); ++face) {
        if (has_repeated_vertex(triangles[face])) continue;
        for (std::size_t k = 0; k < 3; ++k)
            if (const auto found = open.find({triangles[face][k], triangles[face][(k + 1) % 3]}); found != open.end())
                found->second = face;
    }
    const Ends ends(mesh, std::move(of_open));
    // The corners in each edge in their order, and the parts between them. An edge is closed with those that have parts
    // in common with it, if fewer are open then.
    struct Divided {
        std::pair<std::uint32_t, std::uint32_t> way;
        std::uint32_t face;
        std::vector<std::uint32_t> points;  // from its start to its end
    };
    std::vector<Divided> divided;
    struct Part {
        int net = 0;
        std::uint32_t edge;  // one of those that have it
    };
    std::map<std::pair<std::uint32_t, std::uint32_t>, Part> parts;
    DisjointSets groups(open.size());
    for (const auto& [way, face] : open) {
        const auto number = static_cast<std::uint32_t>(divided.size());
        Divided edge{way, face, ends.points_of(way.first, way.second)};
        for (std::size_t k = 0; k + 1 < edge.points.size(); ++k) {
            const std::uint32_t a = edge.points[k], b = edge.points[k + 1];
            const auto [part, is_new] = parts.try_emplace(std::minmax(a, b), Part{0, number});
            part->second.net += a < b ? 1 : -1;
            groups.join(part->second.edge, number);
        }
        divided.push_back(std::move(edge));
    }
    std::vector<int> less_open(divided.size());  // by group
    for (std::uint32_t n = 0; n < divided.size(); ++n) ++less_open[groups.root(n)];
    for (const auto& [ends_of_part, part] : parts) less_open[groups.root(part.edge)] -= std::abs(part.net);
    std::vector<ClosingTriangle> result;
    for (std::uint32_t n = 0; n < divided.size(); ++n) {
        if (less_open[groups.root(n)] <= 0) continue;
        const Divided& edge = divided[n];
        for (std::size_t k = 1; k + 1 < edge.points.size(); ++k)
            result.push_back({{edge.way.second, edge.points[k - 1], edge.points[k]}, edge.face, edge.way.first});
    }
    return result;
}

std::vector<Triangle> corners_in_edges_of_walls(const Mesh& mesh, std::span<const Triangle> triangles) {
    using Edge = std::array<std::uint32_t, 2>;  // the lower vertex first
    const OneRings rings(triangles, mesh.vertices().size());
    std::vector<EdgeEntry> entries;
    // Calls f(edge, number of faces) for the edges whose lower vertex this is.
    const auto for_each_edge_above = [&](std::uint32_t lower, const auto& f) {
        edges_above(triangles, rings, lower, entries);
        for_each_edge(entries, [&](std::span<const EdgeEntry> faces) {
            const Corner edge = faces[0].edge();
            const std::uint32_t a = triangles[edge.face][edge.vertex],
                                b = triangles[edge.face][next_of_three(edge.vertex)];
            f(Edge{std::min(a, b), std::max(a, b)}, faces.size());
        });
    };
    std::vector<Edge> of_one_face;
    for (std::uint32_t lower = 0; lower < mesh.vertices().size(); ++lower)
        for_each_edge_above(lower, [&](const Edge& edge, std::size_t faces) {
            if (faces == 1) of_one_face.push_back(edge);
        });
    if (of_one_face.empty()) return {};
    std::ranges::sort(of_one_face);
    std::vector<std::uint32_t> of_edges;
    for (const Edge& edge : of_one_face) of_edges.insert(of_edges.end(), edge.begin(), edge.end());
    const Ends ends(mesh, std::move(of_edges));
    std::vector<Edge> edges;  // that may have corners within
    for (const std::uint32_t lower : ends.all())
        for_each_edge_above(lower, [&](const Edge& edge, std::size_t) {
            if (ends.contains(edge[1])) edges.push_back(edge);
        });
    std::vector<Triangle> result;
    for (const auto& [a, b] : edges) {
        const std::vector<std::uint32_t> points = ends.points_of(a, b);
        const auto is_part = [&](std::uint32_t from, std::uint32_t to) {
            return std::ranges::binary_search(of_one_face, Edge{std::min(from, to), std::max(from, to)});
        };
        bool has_parts = points.size() > 2;
        for (std::size_t k = 0; has_parts && k + 1 < points.size(); ++k) has_parts = is_part(points[k], points[k + 1]);
        for (std::size_t k = 1; has_parts && k + 1 < points.size(); ++k)
            result.push_back({b, points[k - 1], points[k]});
    }
    return result;
}

}  // namespace clsdf
