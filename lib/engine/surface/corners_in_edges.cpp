#include "surface/corners_in_edges.hpp"

#include "mesh/box_index.hpp"
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
    std::vector<ClosingTriangle> result;
    std::vector<std::pair<double, std::uint32_t>> corners;
    for (const auto& [way, face] : open) {
        const Vec3 from = frame.local(way.first), to = frame.local(way.second);
        corners.clear();
        Box box = empty_box;
        for (const Vec3& end : {from, to}) add(box, {end, end});
        index.any(widened(box, tolerance), [&](std::size_t n) {
            const std::uint32_t vertex = ends[n];
            if (vertex == way.first || vertex == way.second) return false;
            const auto [along, distance] = foot_of(from, to, frame.local(vertex));
            if (along > 0 && along < 1 && distance <= tolerance) corners.emplace_back(along, vertex);
            return false;
        });
        if (corners.empty()) continue;
        std::ranges::sort(corners);
        // The others run the other way: from `to` to the last corner, and on to `from`.
        const auto has_parts = [&] {
            std::uint32_t last = way.first;
            for (const auto& [along, vertex] : corners) {
                if (!open.contains({vertex, last})) return false;
                last = vertex;
            }
            return open.contains({way.second, last});
        };
        if (!has_parts()) continue;
        std::uint32_t last = way.first;
        for (const auto& [along, vertex] : corners) {
            result.push_back({{way.second, last, vertex}, face});
            last = vertex;
        }
    }
    return result;
}

}  // namespace clsdf
