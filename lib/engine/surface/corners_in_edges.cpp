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

/// The vertices of `ends`, by which `index` is made, that lie in the edge from a to b, in their order.
void find_corners(const LocalFrame& frame, const BoxIndex& index, std::span<const std::uint32_t> ends, std::uint32_t a,
                  std::uint32_t b, double tolerance, std::vector<std::pair<double, std::uint32_t>>& corners) {
    const Vec3 from = frame.local(a), to = frame.local(b);
    corners.clear();
    Box box = empty_box;
    for (const Vec3& end : {from, to}) add(box, {end, end});
    index.any(widened(box, tolerance), [&](std::size_t n) {
        const std::uint32_t vertex = ends[n];
        if (vertex == a || vertex == b) return false;
        const auto [along, distance] = foot_of(from, to, frame.local(vertex));
        if (along > 0 && along < 1 && distance <= tolerance) corners.emplace_back(along, vertex);
        return false;
    });
    std::ranges::sort(corners);
}

}  // namespace

std::vector<ClosingTriangle> corners_in_edges(const Mesh& mesh, std::span<const Triangle> triangles) {
    const EdgeCounts edges = count_edges(triangles, mesh.vertices().size());
    // Edges that one face more uses in one direction than in the other one, and such a face.
    std::map<std::pair<std::uint32_t, std::uint32_t>, std::uint32_t> open;  // from, to
    std::vector<std::uint32_t> ends;
    for (const UnbalancedEdge& edge : edges.unbalanced)
        if (edge.net == 1 || edge.net == -1) {
            const auto way = edge.net > 0 ? std::pair(edge.lower, edge.higher) : std::pair(edge.higher, edge.lower);
            open.emplace(way, 0);
            ends.insert(ends.end(), {edge.lower, edge.higher});
        }
    if (open.empty()) return {};
    std::ranges::sort(ends);
    const auto repeated = std::ranges::unique(ends);
    ends.erase(repeated.begin(), repeated.end());
    for (std::uint32_t face = 0; face < triangles.size(); ++face) {
        if (has_repeated_vertex(triangles[face])) continue;
        for (std::size_t k = 0; k < 3; ++k)
            if (const auto found = open.find({triangles[face][k], triangles[face][(k + 1) % 3]}); found != open.end())
                found->second = face;
    }
    const LocalFrame frame(mesh);  // half of the longest side is 1
    const double tolerance = 2 * joining_tolerance;
    std::vector<Box> boxes;
    for (const std::uint32_t vertex : ends) boxes.push_back({frame.local(vertex), frame.local(vertex)});
    const BoxIndex index(boxes);
    // The corners in each edge in their order, and the parts between them. An edge is closed with those that have parts
    // in common with it, if fewer are open then.
    struct Divided {
        std::pair<std::uint32_t, std::uint32_t> way;
        std::uint32_t face;
        std::vector<std::uint32_t> points;  // from its start to its end
    };
    std::vector<Divided> divided;
    std::vector<std::pair<double, std::uint32_t>> corners;
    struct Part {
        int net = 0;
        std::uint32_t edge;  // one of those that have it
    };
    std::map<std::pair<std::uint32_t, std::uint32_t>, Part> parts;
    DisjointSets groups(open.size());
    for (const auto& [way, face] : open) {
        find_corners(frame, index, ends, way.first, way.second, tolerance, corners);
        const auto number = static_cast<std::uint32_t>(divided.size());
        Divided edge{way, face, {way.first}};
        for (const auto& [along, vertex] : corners) edge.points.push_back(vertex);
        edge.points.push_back(way.second);
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
            result.push_back({{edge.way.second, edge.points[k - 1], edge.points[k]}, edge.face});
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
    std::vector<std::uint32_t> ends;
    for (const Edge& edge : of_one_face) ends.insert(ends.end(), edge.begin(), edge.end());
    std::ranges::sort(ends);
    const auto repeated = std::ranges::unique(ends);
    ends.erase(repeated.begin(), repeated.end());
    std::vector<Edge> edges;  // that may have corners within
    for (const std::uint32_t lower : ends)
        for_each_edge_above(lower, [&](const Edge& edge, std::size_t) {
            if (std::ranges::binary_search(ends, edge[1])) edges.push_back(edge);
        });
    const LocalFrame frame(mesh);
    const double tolerance = 2 * joining_tolerance;
    std::vector<Box> boxes;
    for (const std::uint32_t vertex : ends) boxes.push_back({frame.local(vertex), frame.local(vertex)});
    const BoxIndex index(boxes);
    std::vector<Triangle> result;
    std::vector<std::pair<double, std::uint32_t>> corners;
    for (const auto& [a, b] : edges) {
        find_corners(frame, index, ends, a, b, tolerance, corners);
        if (corners.empty()) continue;
        corners.emplace_back(1, b);
        std::uint32_t last = a;
        const bool has_parts = std::ranges::all_of(corners, [&](const auto& corner) {
            const std::uint32_t from = std::exchange(last, corner.second);
            return std::ranges::binary_search(of_one_face, Edge{std::min(from, last), std::max(from, last)});
        });
        if (!has_parts) continue;
        last = a;
        for (std::size_t k = 0; k + 1 < corners.size(); ++k) {
            result.push_back({b, last, corners[k].second});
            last = corners[k].second;
        }
    }
    return result;
}

}  // namespace clsdf
