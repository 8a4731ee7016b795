#include <clsdf/topology.hpp>

#include "mesh/equal_vertices.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <tuple>

namespace clsdf {

namespace {

/// A face's use of an edge, filed under the lower of its two vertices.
struct EdgeUse {
    std::uint32_t other;     ///< the higher vertex
    std::uint32_t triangle;  ///< in the caller's order
    bool upward;             ///< runs from the lower vertex to the higher one
};

/// An edge as the report shows it, in the direction of the first triangle that uses it.
struct NotedEdge {
    std::size_t place;  ///< three times the triangle's index, plus the edge's place in it
    std::uint32_t from;
    std::uint32_t to;
};

NotedEdge noted_edge(const std::vector<Triangle>& triangles, const EdgeUse& use, std::uint32_t lower) {
    const std::uint32_t from = use.upward ? lower : use.other;
    const Triangle& triangle = triangles[use.triangle];
    const auto place = static_cast<std::size_t>(std::find(triangle.begin(), triangle.end(), from) - triangle.begin());
    return {3 * std::size_t{use.triangle} + place, from, use.upward ? use.other : lower};
}

/// Keeps the first five edges in the order of the triangles.
class FirstEdges {
public:
    void note(const NotedEdge& edge) {
        const auto before = [](const NotedEdge& a, const NotedEdge& b) { return a.place < b.place; };
        if (edges_.size() == limit && !before(edge, edges_.back())) return;
        edges_.insert(std::upper_bound(edges_.begin(), edges_.end(), edge, before), edge);
        if (edges_.size() > limit) edges_.pop_back();
    }

    std::vector<Topology::Edge> coordinates(const std::vector<Vec3>& vertices) const {
        std::vector<Topology::Edge> result;
        for (const NotedEdge& edge : edges_) result.push_back({vertices[edge.from], vertices[edge.to]});
        return result;
    }

private:
    static constexpr std::size_t limit = 5;
    std::vector<NotedEdge> edges_;
};

bool has_repeated_vertex(const Triangle& triangle) {
    return triangle[0] == triangle[1] || triangle[1] == triangle[2] || triangle[2] == triangle[0];
}

/// The mesh's triangles over vertices of which no two are equal, without those that repeat a vertex; the latter and
/// the vertices are counted in the report.
std::vector<Triangle> distinct_triangles(const Mesh& mesh, Topology& report) {
    const std::vector<std::uint32_t> first = first_equal_vertices(mesh.vertices());
    std::vector<bool> used(mesh.vertices().size(), false);
    std::vector<bool> represented(mesh.vertices().size(), false);
    std::vector<Triangle> result = mesh.triangles();
    for (Triangle& triangle : result)
        for (std::uint32_t& index : triangle) {
            if (!used[index]) {
                used[index] = true;
                if (represented[first[index]]) ++report.coincident_vertices;
                represented[first[index]] = true;
            }
            index = first[index];
        }
    report.unused_vertices = static_cast<std::size_t>(std::count(used.begin(), used.end(), false));
    return result;
}

/// The uses of edges, those of one lower vertex side by side: of vertex v from begin[v] to begin[v + 1].
struct EdgeUses {
    std::vector<std::size_t> begin;
    std::vector<EdgeUse> uses;
};

EdgeUses edge_uses(const std::vector<Triangle>& triangles, std::size_t vertex_count) {
    EdgeUses result;
    result.begin.assign(vertex_count + 2, 0);
    const auto for_each_edge = [&](const auto& visit) {
        for (std::size_t t = 0; t < triangles.size(); ++t) {
            if (has_repeated_vertex(triangles[t])) continue;
            for (std::size_t k = 0; k < 3; ++k) visit(t, triangles[t][k], triangles[t][(k + 1) % 3]);
        }
    };
    // Filed one place further on, so that filling turns each list's begin into the next one's.
    for_each_edge([&](std::size_t, std::uint32_t from, std::uint32_t to) { ++result.begin[std::min(from, to) + 2]; });
    for (std::size_t v = 2; v < result.begin.size(); ++v) result.begin[v] += result.begin[v - 1];
    result.uses.resize(result.begin.back());
    for_each_edge([&](std::size_t t, std::uint32_t from, std::uint32_t to) {
        result.uses[result.begin[std::min(from, to) + 1]++] = {std::max(from, to), static_cast<std::uint32_t>(t),
                                                               from < to};
    });
    result.begin.pop_back();
    return result;
}

void count_edges(const Mesh& mesh, const std::vector<Triangle>& triangles, Topology& report) {
    EdgeUses edges = edge_uses(triangles, mesh.vertices().size());
    FirstEdges open;
    FirstEdges unbalanced;
    for (std::uint32_t lower = 0; lower + 1 < edges.begin.size(); ++lower) {
        const auto end = edges.uses.begin() + static_cast<std::ptrdiff_t>(edges.begin[lower + 1]);
        auto use = edges.uses.begin() + static_cast<std::ptrdiff_t>(edges.begin[lower]);
        std::sort(use, end, [](const EdgeUse& a, const EdgeUse& b) {
            return std::tie(a.other, a.triangle) < std::tie(b.other, b.triangle);
        });
        while (use != end) {
            const EdgeUse first = *use;
            std::size_t upward = 0;
            std::size_t downward = 0;
            for (; use != end && use->other == first.other; ++use) ++(use->upward ? upward : downward);
            // An open edge, with an odd number of faces, is unbalanced as well.
            if (upward != downward) {
                const NotedEdge edge = noted_edge(triangles, first, lower);
                ++report.unbalanced_edges;
                unbalanced.note(edge);
                if ((upward + downward) % 2 != 0) {
                    ++report.open_edges;
                    open.note(edge);
                }
            }
            if (upward + downward > 2) ++report.non_manifold_edges;
        }
    }
    report.closed = report.open_edges == 0;
    report.balanced = report.unbalanced_edges == 0;
    report.first_open_edges = open.coordinates(mesh.vertices());
    report.first_unbalanced_edges = unbalanced.coordinates(mesh.vertices());
}

/// Whether the enclosed volume is negative by more than its rounding error.
bool encloses_negative_volume(const Mesh& mesh) {
    // Halves, because the difference of the largest numbers would overflow; the centre, because far from the origin
    // the volume would drown.
    const Box& box = mesh.box();
    Vec3 centre{};
    double half_side = 0;
    for (std::size_t axis = 0; axis < 3; ++axis) {
        centre[axis] = 0.5 * box.lower[axis] + 0.5 * box.upper[axis];
        half_side = std::max(half_side, 0.5 * box.upper[axis] - 0.5 * box.lower[axis]);
    }
    if (half_side == 0) return false;
    const auto local = [&](std::uint32_t index) {
        const Vec3& vertex = mesh.vertices()[index];
        return Vec3{(vertex[0] - centre[0]) / half_side, (vertex[1] - centre[1]) / half_side,
                    (vertex[2] - centre[2]) / half_side};
    };
    double volume = 0;
    double magnitude = 0;
    for (const Triangle& triangle : mesh.triangles()) {
        const Vec3 a = local(triangle[0]);
        const Vec3 b = local(triangle[1]);
        const Vec3 c = local(triangle[2]);
        for (std::size_t i = 0; i < 3; ++i) {
            const std::size_t j = (i + 1) % 3;
            const std::size_t k = (i + 2) % 3;
            volume += a[i] * (b[j] * c[k] - b[k] * c[j]);
            magnitude += std::abs(a[i]) * (std::abs(b[j] * c[k]) + std::abs(b[k] * c[j]));
        }
    }
    const double rounding = static_cast<double>(mesh.triangles().size() + 16) * std::numeric_limits<double>::epsilon();
    return volume < -rounding * magnitude;
}

}  // namespace

Topology describe_topology(const Mesh& mesh) {
    Topology report;
    const std::vector<Triangle> triangles = distinct_triangles(mesh, report);
    report.repeated_vertex_faces =
        static_cast<std::size_t>(std::count_if(triangles.begin(), triangles.end(), has_repeated_vertex));
    count_edges(mesh, triangles, report);
    report.inside_out = report.balanced && encloses_negative_volume(mesh);
    return report;
}

}  // namespace clsdf
