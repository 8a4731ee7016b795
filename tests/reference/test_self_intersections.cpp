#include "support/random_meshes.hpp"

#include <clsdf/mesh.hpp>
#include <clsdf/reference.hpp>

#include <boost/test/unit_test.hpp>

#include <algorithm>

using namespace clsdf;
using reference::find_self_intersections;
using Pairs = std::vector<reference::TrianglePair>;

namespace {

/// The mesh and a copy of it, moved along x.
Mesh with_copy(const Mesh& mesh, double x) {
    std::vector<Vec3> vertices = mesh.vertices();
    std::vector<Triangle> triangles = mesh.triangles();
    const auto count = static_cast<std::uint32_t>(vertices.size());
    for (std::size_t i = 0; i < count; ++i)
        vertices.push_back({vertices[i][0] + x, vertices[i][1] + x / 3, vertices[i][2] + x / 5});
    for (const auto& [a, b, c] : mesh.triangles()) triangles.push_back({a + count, b + count, c + count});
    return {std::move(vertices), std::move(triangles), "twice"};
}

double volume(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d) {
    const auto minus = [&](const Vec3& p) { return Vec3{p[0] - a[0], p[1] - a[1], p[2] - a[2]}; };
    const Vec3 u = minus(b);
    const Vec3 v = minus(c);
    const Vec3 w = minus(d);
    return u[0] * (v[1] * w[2] - v[2] * w[1]) - u[1] * (v[0] * w[2] - v[2] * w[0]) + u[2] * (v[0] * w[1] - v[1] * w[0]);
}

/// Whether an edge of the first goes through the inside of the second; in general position, and false for triangles
/// with repeated vertices.
bool pierce(const Mesh& mesh, std::uint32_t first, std::uint32_t second) {
    const Triangle& one = mesh.triangles()[first];
    const Triangle& other = mesh.triangles()[second];
    const auto contains = [](const Triangle& triangle, std::uint32_t vertex) {
        return std::find(triangle.begin(), triangle.end(), vertex) != triangle.end();
    };
    for (const Triangle& triangle : {one, other})
        if (triangle[0] == triangle[1] || triangle[1] == triangle[2] || triangle[2] == triangle[0]) return false;
    const auto at = [&](std::uint32_t vertex) { return mesh.vertices()[vertex]; };
    if (std::is_permutation(one.begin(), one.end(), other.begin())) return true;
    for (std::size_t k = 0; k < 3; ++k) {
        const std::uint32_t from = one[k];
        const std::uint32_t to = one[(k + 1) % 3];
        if (contains(other, from) || contains(other, to)) continue;
        const Vec3 a = at(other[0]);
        const Vec3 b = at(other[1]);
        const Vec3 c = at(other[2]);
        if (volume(a, b, c, at(from)) * volume(a, b, c, at(to)) >= 0) continue;
        const double turn = volume(at(from), at(to), a, b);
        if (turn * volume(at(from), at(to), b, c) > 0 && turn * volume(at(from), at(to), c, a) > 0) return true;
    }
    return false;
}

}  // namespace

BOOST_AUTO_TEST_CASE(solids_intersect_where_they_overlap) {
    const Mesh cube = make_shape("cube");
    BOOST_TEST(find_self_intersections(cube).empty());
    BOOST_TEST(find_self_intersections(with_copy(cube, 2)).empty());
    const std::vector<reference::TrianglePair> pairs = find_self_intersections(with_copy(cube, 0.5));
    BOOST_TEST(!pairs.empty());
    for (const auto& [one, other] : pairs) {
        BOOST_TEST(one < cube.triangles().size());
        BOOST_TEST(other >= cube.triangles().size());
    }
    BOOST_TEST(find_self_intersections(make_shape("nested")).empty());
}

BOOST_AUTO_TEST_CASE(a_mesh_need_not_be_manifold) {
    const std::vector<Vec3> vertices{{0, 0, 0}, {0, 0, 1}, {1, 0, 0}, {0, 1, 0}, {-1, 0, 0}};
    // Three pages of a book.
    BOOST_TEST(find_self_intersections(Mesh(vertices, {{0, 1, 2}, {0, 1, 3}, {0, 1, 4}})).empty());
    // The same face again, whichever way it is turned.
    const Mesh twice(vertices, {{0, 1, 2}, {0, 1, 3}, {2, 0, 1}, {1, 0, 2}});
    BOOST_TEST((find_self_intersections(twice) == Pairs{{0, 2}, {0, 3}, {2, 3}}));
}

// The first is (0, 0), (2, 0), (0, 2) in the plane z = 0.
BOOST_AUTO_TEST_CASE(triangles_that_share_vertices_intersect_beyond_them) {
    const auto intersect = [](const Vec3& a, const Vec3& b, const Vec3& c) {
        const Mesh mesh({{0, 0, 0}, {2, 0, 0}, {0, 2, 0}, a, b, c}, {{0, 1, 2}, {3, 4, 5}});
        const Mesh turned({{0, 2, 0}, {0, 0, 0}, {2, 0, 0}, c, b, a}, {{3, 4, 5}, {0, 1, 2}});
        const bool found = !find_self_intersections(mesh).empty();
        BOOST_TEST(found == !find_self_intersections(turned).empty());
        return found;
    };
    // An edge:
    BOOST_TEST(!intersect({0, 0, 0}, {2, 0, 0}, {0, 0, 1}));
    BOOST_TEST(!intersect({0, 0, 0}, {2, 0, 0}, {0, 1, 1e-300}));
    BOOST_TEST(!intersect({0, 0, 0}, {2, 0, 0}, {1, -1, 0}));
    BOOST_TEST(intersect({0, 0, 0}, {2, 0, 0}, {1, 3, 0}));
    BOOST_TEST(intersect({2, 0, 0}, {0, 2, 0}, {-1, -1, 0}));
    // A vertex:
    BOOST_TEST(!intersect({0, 0, 0}, {-1, 0, 1}, {0, -1, 1}));
    BOOST_TEST(!intersect({0, 0, 0}, {-1, 0, 0}, {0, -1, 0}));
    BOOST_TEST(!intersect({0, 0, 0}, {1, 1, 1}, {1, 1, 2}));
    BOOST_TEST(intersect({0, 0, 0}, {1, 1, 1}, {1, 1, -1}));          // through the edge opposite to it
    BOOST_TEST(intersect({0, 0, 0}, {0.5, 0.5, 1}, {0.5, 0.5, -1}));  // through the inside
    BOOST_TEST(intersect({0, 0, 0}, {4, 1, 1}, {4, 1, -1}));          // the other one's edge is nearer
    BOOST_TEST(intersect({0, 0, 0}, {1, 0, 0}, {-1, 0, 1}));          // along an edge
    BOOST_TEST(intersect({0, 0, 0}, {3, 1, 0}, {1, 3, 0}));           // in one plane
    BOOST_TEST(intersect({0, 0, 0}, {0.5, 0.25, 0}, {0.25, 0.5, 0}));
    // None:
    BOOST_TEST(!intersect({5, 0, 0}, {6, 0, 0}, {5, 1, 0}));
    BOOST_TEST(intersect({1, 0, 0}, {1, -1, 0}, {1, -1, 1}));  // a vertex on an edge
    BOOST_TEST(!intersect({1, -1e-300, 0}, {1, -1, 0}, {1, -1, 1}));
}

BOOST_AUTO_TEST_CASE(a_face_without_area_is_paired_with_itself) {
    const std::vector<Vec3> vertices{{0, 0, 0}, {2, 0, 0}, {0, 2, 0}, {1, 1, -1}, {1, 1, 1}, {1, 1, 0}, {0, 0, 0}};
    const Mesh mesh(vertices, {{0, 1, 2}, {3, 4, 5}, {0, 1, 1}, {0, 1, 6}});
    BOOST_TEST((find_self_intersections(mesh) == Pairs{{1, 1}}));
}

// Whether two triangles meet is a question of the edges of either and the inside of the other.
BOOST_AUTO_TEST_CASE(the_pairs_of_a_soup_are_those_whose_edges_pierce) {
    std::size_t found = 0;
    for (std::uint64_t seed = 1; seed <= 20; ++seed) BOOST_TEST_CONTEXT("seed " << seed) {
            test::Random random(seed);
            const Mesh mesh = test::random_soup(random, 40, 60);
            Pairs expected;
            for (std::uint32_t i = 0; i < mesh.triangles().size(); ++i)
                for (std::uint32_t j = i + 1; j < mesh.triangles().size(); ++j)
                    if (pierce(mesh, i, j) || pierce(mesh, j, i)) expected.emplace_back(i, j);
            BOOST_TEST((find_self_intersections(mesh) == expected));
            found += expected.size();
        }
    BOOST_TEST(found > 500U);
}
