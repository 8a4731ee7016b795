// Random triangles over vertices many of which are equal, held against a description by maps and one vertex after the
// other.

#include <clsdf/topology.hpp>

#include "mesh/equal_vertices.hpp"
#include "support/random_meshes.hpp"
#include "support/same_topology.hpp"
#include "surface/topology.hpp"

#include <tbb/task_arena.h>
#include <boost/test/unit_test.hpp>

#include <algorithm>
#include <map>
#include <optional>
#include <set>

namespace clsdf {

namespace {

/// Points of a lattice of `side` points a side; zeros of both signs.
std::vector<Vec3> lattice_points(test::Random& random, std::size_t count, std::size_t side) {
    std::vector<Vec3> points(count);
    for (Vec3& point : points)
        for (double& x : point) {
            x = random.index(side);
            if (x == 0 && random.index(2) == 1) x = -0.0;
        }
    return points;
}

/// Triangles of vertices that are close in the list, so that they share edges.
std::vector<Triangle> random_triangles(test::Random& random, std::size_t count, std::size_t vertex_count) {
    std::vector<Triangle> triangles(count);
    for (Triangle& triangle : triangles) {
        const std::uint32_t begin = random.index(vertex_count - 3);
        for (std::uint32_t& index : triangle) index = begin + random.index(4);
    }
    return triangles;
}

std::vector<std::uint32_t> first_by_map(const std::vector<Vec3>& vertices) {
    std::map<Vec3, std::uint32_t> firsts;
    std::vector<std::uint32_t> result;
    for (std::uint32_t v = 0; v < vertices.size(); ++v) result.push_back(firsts.emplace(vertices[v], v).first->second);
    return result;
}

struct Uses {
    std::size_t upward = 0;
    std::size_t downward = 0;
    Topology::Edge first{};
    std::size_t place = 0;  // of the first use
};

using Edges = std::map<std::pair<std::uint32_t, std::uint32_t>, Uses>;

bool repeats(const Triangle& t) {
    return t[0] == t[1] || t[1] == t[2] || t[2] == t[0];
}

Edges edges_of(const std::vector<Triangle>& triangles, const std::vector<Vec3>& vertices) {
    Edges edges;
    std::size_t place = 0;
    for (const Triangle& t : triangles)
        for (std::size_t k = 0; k < 3 && !repeats(t); ++k, ++place) {
            const std::uint32_t from = t[k], to = t[(k + 1) % 3];
            Uses& uses = edges.try_emplace(std::minmax(from, to), Uses{0, 0, {vertices[from], vertices[to]}, place})
                             .first->second;
            ++(from < to ? uses.upward : uses.downward);
        }
    return edges;
}

bool are_balanced(const Edges& edges) {
    return std::ranges::all_of(edges, [](const auto& edge) { return edge.second.upward == edge.second.downward; });
}

bool are_closed(const Edges& edges) {
    return std::ranges::all_of(edges,
                               [](const auto& edge) { return (edge.second.upward + edge.second.downward) % 2 == 0; });
}

std::size_t unbalanced_edges(const Edges& edges) {
    return static_cast<std::size_t>(
        std::ranges::count_if(edges, [](const auto& edge) { return edge.second.upward != edge.second.downward; }));
}

/// Of faces with the same vertices the first counts, in the direction of most of them, or none: `cancelled`.
std::vector<Triangle> counted_once(const std::vector<Triangle>& triangles, std::size_t& uncounted, bool& has_odd,
                                   std::vector<Triangle>& cancelled) {
    std::map<Triangle, std::vector<std::size_t>> groups;
    for (std::size_t face = 0; face < triangles.size(); ++face) {
        if (repeats(triangles[face])) continue;
        Triangle sorted = triangles[face];
        std::sort(sorted.begin(), sorted.end());
        groups[sorted].push_back(face);
    }
    std::vector<Triangle> result(triangles.size(), Triangle{0, 0, 0});
    uncounted = 0;
    has_odd = false;
    for (const auto& [sorted, faces] : groups) {
        const Triangle& first = triangles[faces[0]];
        int net = 0;
        for (const std::size_t face : faces) {
            const Triangle& t = triangles[face];
            const bool is_same = (t[0] == first[0] && t[1] == first[1]) || (t[1] == first[0] && t[2] == first[1]) ||
                                 (t[2] == first[0] && t[0] == first[1]);
            net += is_same ? 1 : -1;
        }
        if (net > 0) result[faces[0]] = first;
        if (net < 0) result[faces[0]] = {first[0], first[2], first[1]};
        if (net == 0) cancelled.push_back(first);
        uncounted += faces.size() - (net != 0 ? 1U : 0U);
        has_odd = has_odd || faces.size() % 2 != 0;
    }
    return result;
}

/// Nothing if the surface is to be oriented, or faces that cancel each other may close it, which maps do not do.
std::optional<Topology> describe_by_map(const Mesh& mesh) {
    const std::vector<std::uint32_t> first = first_by_map(mesh.vertices());
    Topology report;
    std::set<std::uint32_t> used;
    std::set<std::uint32_t> represented;
    std::vector<Triangle> triangles;
    for (const Triangle& triangle : mesh.triangles()) {
        used.insert(triangle.begin(), triangle.end());
        Triangle t{};
        std::transform(triangle.begin(), triangle.end(), t.begin(), [&](std::uint32_t v) { return first[v]; });
        represented.insert(t.begin(), t.end());
        report.repeated_vertex_faces += repeats(t);
        triangles.push_back(t);
    }
    report.unused_vertices = mesh.vertices().size() - used.size();
    report.coincident_vertices = used.size() - represented.size();
    Edges edges = edges_of(triangles, mesh.vertices());
    for (const auto& [edge, uses] : edges) report.non_manifold_edges += uses.upward + uses.downward > 2;
    if (!are_balanced(edges)) {
        std::size_t uncounted = 0;
        bool has_odd = false;
        std::vector<Triangle> cancelled;
        const Edges once = edges_of(counted_once(triangles, uncounted, has_odd, cancelled), mesh.vertices());
        const Edges of_cancelled = edges_of(cancelled, mesh.vertices());
        const bool may_close = std::ranges::all_of(once, [&](const auto& edge) {
            return (edge.second.upward + edge.second.downward) % 2 == 0 || of_cancelled.contains(edge.first);
        });
        if (!are_closed(once) && may_close) return std::nullopt;
        if (unbalanced_edges(once) <= unbalanced_edges(edges) && (!are_closed(edges) || are_closed(once) || !has_odd)) {
            edges = once;
            report.uncounted_faces = uncounted;
        }
        if (!are_balanced(edges) && are_closed(edges)) return std::nullopt;
    }
    std::map<std::size_t, Topology::Edge> open;
    std::map<std::size_t, Topology::Edge> unbalanced;
    for (const auto& [edge, uses] : edges) {
        if (uses.upward != uses.downward) unbalanced[uses.place] = uses.first;
        if ((uses.upward + uses.downward) % 2 != 0) open[uses.place] = uses.first;
        report.boundary_edges += uses.upward + uses.downward == 1;
    }
    report.open_edges = open.size();
    report.unbalanced_edges = unbalanced.size();
    const auto first_five = [](const std::map<std::size_t, Topology::Edge>& from, std::vector<Topology::Edge>& to) {
        for (auto edge = from.begin(); edge != from.end() && to.size() < 5; ++edge) to.push_back(edge->second);
    };
    first_five(open, report.first_open_edges);
    first_five(unbalanced, report.first_unbalanced_edges);
    return report;
}

}  // namespace

BOOST_AUTO_TEST_CASE(soups_are_described_as_maps_describe_them) {
    for (const std::uint64_t seed : {1U, 2U, 3U, 4U, 5U, 6U})
        for (const std::size_t count : {5U, 300U, 40000U}) {
            BOOST_TEST_CONTEXT("seed " << seed << ", " << count << " vertices") {
                test::Random random(seed);
                // From nearly all vertices equal to nearly none.
                const std::size_t side = std::size_t{2} << (2 * (seed % 4));
                const Mesh mesh(lattice_points(random, count, side), random_triangles(random, 2 * count, count));
                BOOST_TEST(first_equal_vertices(mesh.vertices()) == first_by_map(mesh.vertices()),
                           boost::test_tools::per_element());
                const std::optional<Topology> expected = describe_by_map(mesh);
                if (!expected) continue;
                // The rule auto does more.
                for (const int threads : {1, 2, 16}) {
                    tbb::task_arena arena(threads);
                    const Topology found =
                        arena.execute([&] { return describe_mesh(mesh, SignRule::nonzero).topology; });
                    test::check_same_counts(found, *expected);
                }
            }
        }
}

}  // namespace clsdf
