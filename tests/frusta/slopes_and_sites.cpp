#include "coverage.hpp"
#include "frusta/slopes.hpp"
#include "plan/joined_meshes.hpp"
#include "stress_points.hpp"
#include "support/random_meshes.hpp"
#include "support/test_meshes.hpp"
#include "topology/topology.hpp"

#include <clsdf/mesh.hpp>

#include <boost/multiprecision/cpp_int.hpp>
#include <boost/test/unit_test.hpp>

#include <algorithm>
#include <array>
#include <cstdint>
#include <ctime>
#include <iterator>
#include <memory>
#include <span>
#include <vector>

namespace clsdf::test {
namespace {

using engine::LatticeView;

constexpr double half_width = 4;

LeanedFrusta frusta_of(const Mesh& mesh) {
    return leaned_frusta(mesh, {});
}

/// In integers: a coordinate of some 1 is a multiple of 2^-100.
int exact_side(const Mesh& mesh, const Triangle& triangle, std::uint32_t opposite) {
    using Integer = boost::multiprecision::cpp_int;
    const auto from_first = [&](std::uint32_t vertex) {
        std::array<Integer, 3> difference;
        for (std::size_t axis = 0; axis < 3; ++axis)
            difference[axis] = Integer(std::ldexp(mesh.vertices()[vertex][axis], 100)) -
                               Integer(std::ldexp(mesh.vertices()[triangle[0]][axis], 100));
        return difference;
    };
    const auto a = from_first(triangle[1]);
    const auto b = from_first(triangle[2]);
    const auto c = from_first(opposite);
    const Integer volume =
        (a[1] * b[2] - a[2] * b[1]) * c[0] + (a[2] * b[0] - a[0] * b[2]) * c[1] + (a[0] * b[1] - a[1] * b[0]) * c[2];
    return volume.sign();
}

BOOST_AUTO_TEST_SUITE(slopes_and_sites)

BOOST_AUTO_TEST_CASE(the_side_of_a_plane_is_exact_where_rounding_would_decide) {
    std::array<std::size_t, 3> seen{};
    for (std::uint64_t seed = 1; seed <= 3000; ++seed) {
        BOOST_TEST_CONTEXT("seed " << seed) {
            Random random(seed);
            // Two triangles over an edge, the fourth vertex in the plane of the first three up to a few roundings.
            const Vec3 a = random.point(-1, 1);
            const Vec3 b = random.point(-1, 1);
            const Vec3 c = random.point(-1, 1);
            const double u = random.uniform(0.2, 2);
            const double v = random.uniform(-2, 2);
            Vec3 d{};
            for (std::size_t axis = 0; axis < 3; ++axis) {
                d[axis] = a[axis] + u * (a[axis] - c[axis]) + v * (b[axis] - a[axis]);
                if (random.index(3) == 0) d[axis] *= 1 + random.uniform(-1, 1) * std::pow(10, random.uniform(-17, -10));
            }
            Mesh mesh({a, b, c, d}, {{0, 1, 2}, {1, 0, 3}}, "two triangles");
            if (seed % 3 == 0) {  // exactly flat
                std::vector<Vec3> vertices = mesh.vertices();
                for (Vec3& vertex : vertices) vertex[2] = vertex[0];
                mesh = Mesh(vertices, mesh.triangles(), "flat");
            }
            const LatticeView lattice;
            const engine::MeshFaces faces{mesh.vertices(), mesh.triangles(), lattice};
            const int side = exact_side(mesh, mesh.triangles()[0], 3);
            BOOST_TEST(side_of_plane(faces, 0, {1, 0}) == side);
            ++seen.at(static_cast<std::size_t>(side) + 1);
        }
    }
    for (const std::size_t times : seen) BOOST_TEST(times > 300U);
}

// A part that is far smaller than the rest must not count as empty.
BOOST_AUTO_TEST_CASE(the_side_of_a_plane_is_exact_for_coordinates_of_all_magnitudes) {
    const LatticeView lattice;
    for (const double length : {1.0, 1e100, 1e160})
        for (const double height : {1e-200, -1e-200}) {
            const Mesh mesh({{0, 0, 0}, {length, 0, 0}, {0, length, 0}, {0, -length, height}}, {{0, 1, 2}, {1, 0, 3}},
                            "two triangles");
            const engine::MeshFaces faces{mesh.vertices(), mesh.triangles(), lattice};
            BOOST_TEST(side_of_plane(faces, 0, {1, 0}) == (height > 0 ? 1 : -1));
        }
}

BOOST_AUTO_TEST_CASE(convex_meshes_have_no_saddles) {
    const LeanedFrusta sphere = frusta_of(make_shape("sphere6"));
    BOOST_TEST(sphere.saddle_vertices == 0U);
    BOOST_TEST(sphere.point_sites == 0U);
    BOOST_TEST(sphere.boxes == 0U);
}

BOOST_AUTO_TEST_CASE(a_face_with_a_vertex_twice_is_not_its_own_neighbour) {
    // Between the vertices 0 and 1, back and forth, as few and as many faces as take either way through pair_edges().
    for (const std::uint32_t others : {0U, 20U}) {
        std::vector<Vec3> vertices{{0, 0, 0}, {1, 0, 0}};
        std::vector<Triangle> triangles{{0, 1, 0}};
        for (std::uint32_t i = 0; i < others; ++i) {
            const double angle = 0.3 * i;
            vertices.push_back({-1, std::cos(angle), std::sin(angle)});
            if (i > 0) triangles.push_back({0, 1 + i, 2 + i});
        }
        for (const Triangle& twice : {Triangle{0, 1, 0}, Triangle{0, 0, 1}, Triangle{1, 0, 0}}) {
            triangles.front() = twice;
            const Mesh mesh(vertices, triangles, "back and forth");
            const OneRings rings(mesh.triangles(), mesh.vertices().size());
            const LatticeView lattice;
            const engine::MeshFaces faces{mesh.vertices(), mesh.triangles(), lattice};
            const engine::PairedEdges edges = engine::pair_edges(mesh.triangles(), rings);
            const auto marks = engine::FaceMeasures(faces, rings, edges).measure(0).marks;
            for (std::uint32_t k = 0; k < 3; ++k) {
                const bool is_edge = twice[k] != twice[next_of_three(k)];
                const int expected = engine::edge_at_box | (is_edge ? engine::edge_non_manifold : 0);
                BOOST_TEST(static_cast<int>(marks[k]) == expected);
            }
        }
    }
}

BOOST_AUTO_TEST_CASE(a_tip_with_a_thousand_faces_is_covered) {
    for (const double wave : {0.0, 0.5, 5.0}) {
        BOOST_TEST_CONTEXT("wave " << wave) {
            const Mesh mesh = tip(1000, 7, wave);
            const CoverageTest test(mesh, {}, half_width, least_slack(half_width));
            Random random(5);
            Coverage coverage;
            for (int i = 0; i < 2000; ++i) {
                const Vec3 direction = random.direction();
                test.look(along({0, 0, 7}, random.uniform(0, half_width), direction), coverage);
            }
            BOOST_CHECK_MESSAGE(coverage.failures() == 0, coverage.text());
        }
    }
}

BOOST_AUTO_TEST_CASE(the_time_does_not_grow_with_the_square_of_what_meets) {
    const auto seconds = [](const Mesh& mesh) {
        const std::clock_t start = std::clock();  // of processor time: a busy machine does not count
        frusta_of(mesh);
        return static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC;
    };
    constexpr double enough = 5;
    constexpr std::uint32_t count = 200000;
    for (const double height : {7.0, 0.0, -7.0}) BOOST_TEST(seconds(tip(count, height, 1e-3)) < enough);

    // Each neighbour narrows the normal cone that the ones before it leave.
    std::vector<Vec3> vertices = tip(count, 0, 0).vertices();
    for (std::uint32_t i = 0; i < count; ++i)
        vertices[1 + i][2] = -10 * std::exp(-3.0 * i / count) + (i % 2 == 0 ? 0 : 1e-3);
    BOOST_TEST(seconds(Mesh(vertices, tip(count, 0, 0).triangles(), "spiral")) < enough);

    std::vector<Vec3> pages{{0, 0, -1}, {0, 0, 1}};
    std::vector<Triangle> triangles;
    std::vector<Triangle> cones;  // fans of three faces each, all at vertex 0
    for (std::uint32_t i = 0; i < count; ++i) {
        const double angle = 6.283185307179586 * i / count;
        pages.push_back({10 * std::cos(angle), 10 * std::sin(angle), i % 3 == 0 ? 0.0 : 0.1});
        triangles.push_back({0, 1, 2 + i});
        if (i % 3 == 2) cones.insert(cones.end(), {{0, i, i + 1}, {0, i + 1, i + 2}, {0, i + 2, i}});
    }
    BOOST_TEST(seconds(Mesh(pages, triangles, "book")) < enough);
    BOOST_TEST(seconds(Mesh(pages, cones, "cones")) < enough);
}

BOOST_AUTO_TEST_CASE(non_manifold_vertices_with_normals_have_a_point_site) {
    // Three faces at an edge: its two ends.
    const Mesh book({{0, 0, -5}, {0, 0, 5}, {10, 0, 0}, {-5, 8, 0}, {-5, -8, 0}}, {{0, 1, 2}, {0, 1, 3}, {0, 1, 4}},
                    "book");
    BOOST_TEST(frusta_of(book).point_sites == 2U);
}

BOOST_AUTO_TEST_CASE(sites_share_groups_of_records_with_those_of_their_block_alone) {
    Random random(7);
    const Mesh sphere = make_shape("sphere6");
    std::vector<Vec3> vertices = sphere.vertices();
    for (Vec3& vertex : vertices) vertex = along(vertex, 0.02, random.direction());
    const Mesh mesh(vertices, sphere.triangles(), "rough");
    const engine::MeshTopology topology(mesh);
    const std::vector<engine::SiteFrustum> all = engine::make_frusta(topology, mesh.vertices()).sites;
    // The second half: of its own blocks it has the groups that it has beside the first.
    std::vector<engine::SiteFrustum> half;
    std::ranges::copy_if(all, std::back_inserter(half), [&](const engine::SiteFrustum& site) {
        return site.vertex >= topology.faces.vertices.size() / 2 / engine::site_block * engine::site_block;
    });
    BOOST_REQUIRE((half.size() > 20 && half.size() + 20 < all.size()));
    const auto grouped = [](const std::vector<engine::SiteFrustum>& sites) {
        return engine::in_groups(sites, engine::site_blocks(sites, {}));
    };
    const std::vector<engine::SiteFrustum> of_all = grouped(all), of_half = grouped(half);
    BOOST_TEST(of_all.size() % engine::record_group == 0U);
    BOOST_TEST(static_cast<std::size_t>(std::ranges::count_if(of_all, engine::is_filling)) + all.size() ==
               of_all.size());
    BOOST_TEST(std::ranges::equal(std::span(of_all).last(of_half.size()), of_half,
                                  [](const engine::SiteFrustum& a, const engine::SiteFrustum& b) {
                                      return a.vertex == b.vertex && engine::is_filling(a) == engine::is_filling(b);
                                  }));
    // Alone and beside others.
    const auto count = static_cast<std::uint32_t>(topology.faces.vertices.size());
    std::vector<engine::SiteFrustum> twice = all;
    for (engine::SiteFrustum site : all) {
        site.vertex += count;
        twice.push_back(site);
    }
    const std::array<engine::JoinedPart, 2> joined{{{0, 0, count}, {0, 0, 2 * count}}};
    const auto of_two = engine::in_groups(twice, engine::site_blocks(twice, joined));
    BOOST_TEST(of_two.size() == 2 * of_all.size());
    BOOST_TEST(of_two[of_all.size()].vertex == of_all[0].vertex + count);
}

BOOST_AUTO_TEST_CASE(faces_that_fill_up_a_group_have_the_slopes_of_the_face_that_they_repeat) {
    // Three faces at an edge; whichever is last is one of them.
    const Mesh mesh({{0, 0, 0}, {0, 0, 1}, {1, 0.1, 0.3}, {-1, 1, 0.2}, {-0.7, -1, 0.4}},
                    {{0, 1, 2}, {0, 1, 3}, {1, 0, 4}}, "three faces");
    const auto topology = std::make_shared<const engine::MeshTopology>(mesh);
    const engine::Frusta alone = engine::make_frusta(*topology, mesh.vertices(), {});
    const std::vector<engine::MeshToJoin> meshes(3, {&mesh, topology});
    std::vector<Vec3> positions;
    for (std::size_t i = 0; i < meshes.size(); ++i)
        positions.insert(positions.end(), mesh.vertices().begin(), mesh.vertices().end());
    const engine::JoinedMeshes joined = engine::join_meshes(meshes, positions);
    const engine::Frusta all = engine::make_frusta(*joined.topology, joined.mesh.vertices(), {});
    const std::size_t of_mesh = all.slopes.size() / meshes.size();
    BOOST_REQUIRE(of_mesh > alone.slopes.size());
    for (std::size_t face = 0; face < all.slopes.size(); ++face) {
        const engine::FaceSlopes& expected = alone.slopes[std::min(face % of_mesh, alone.slopes.size() - 1)];
        BOOST_TEST((all.slopes[face].above == expected.above && all.slopes[face].below == expected.below),
                   "face " << face);
    }
}

BOOST_AUTO_TEST_SUITE_END()

}  // namespace
}  // namespace clsdf::test
