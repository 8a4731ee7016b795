// Random triangles over vertices many of which are equal, held against a description by maps and one vertex after the
// other.

#include <clsdf/topology.hpp>

#include "mesh/topology.hpp"
#include "support/random_meshes.hpp"
#include "support/same_topology.hpp"

#include <tbb/task_arena.h>
#include <boost/test/unit_test.hpp>

#include <algorithm>
#include <map>
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

Topology describe_by_map(const Mesh& mesh) {
    const std::vector<std::uint32_t> first = first_by_map(mesh.vertices());
    Topology report;
    std::set<std::uint32_t> used;
    std::set<std::uint32_t> represented;
    std::map<std::pair<std::uint32_t, std::uint32_t>, Uses> edges;
    std::size_t place = 0;
    for (const Triangle& triangle : mesh.triangles()) {
        used.insert(triangle.begin(), triangle.end());
        Triangle t{};
        std::transform(triangle.begin(), triangle.end(), t.begin(), [&](std::uint32_t v) { return first[v]; });
        represented.insert(t.begin(), t.end());
        const bool repeats = t[0] == t[1] || t[1] == t[2] || t[2] == t[0];
        report.repeated_vertex_faces += repeats;
        for (std::size_t k = 0; k < 3 && !repeats; ++k, ++place) {
            const std::uint32_t from = t[k];
            const std::uint32_t to = t[(k + 1) % 3];
            Uses& uses =
                edges
                    .try_emplace(std::minmax(from, to), Uses{0, 0, {mesh.vertices()[from], mesh.vertices()[to]}, place})
                    .first->second;
            ++(from < to ? uses.upward : uses.downward);
        }
    }
    report.unused_vertices = mesh.vertices().size() - used.size();
    report.coincident_vertices = used.size() - represented.size();
    std::map<std::size_t, Topology::Edge> open;
    std::map<std::size_t, Topology::Edge> unbalanced;
    for (const auto& [edge, uses] : edges) {
        report.non_manifold_edges += uses.upward + uses.downward > 2;
        if (uses.upward != uses.downward) unbalanced[uses.place] = uses.first;
        if ((uses.upward + uses.downward) % 2 != 0) open[uses.place] = uses.first;
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
                const Topology expected = describe_by_map(mesh);
                for (const int threads : {1, 2, 16}) {
                    tbb::task_arena arena(threads);
                    const Topology found = arena.execute([&] { return describe_topology(mesh); });
                    test::check_same_counts(found, expected);
                }
            }
        }
}

}  // namespace clsdf
