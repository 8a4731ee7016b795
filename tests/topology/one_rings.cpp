#include "support/random_meshes.hpp"
#include "topology/topology.hpp"

#include <clsdf/mesh.hpp>

#include <boost/test/unit_test.hpp>

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <map>
#include <vector>

namespace clsdf::test {
namespace {

BOOST_AUTO_TEST_SUITE(one_rings)

BOOST_AUTO_TEST_CASE(corners_come_by_face_however_many_threads_file_them) {
    Random random(1);
    const Mesh mesh = random_soup(random, 200, 50000);
    const OneRings rings(mesh.triangles(), mesh.vertices().size());
    std::size_t corners = 0;
    for (std::size_t vertex = 0; vertex < rings.vertex_count(); ++vertex) {
        std::uint32_t last = 0;
        for (std::size_t i = 0; i < rings.size(vertex); ++i) {
            const Corner corner = rings.corner(vertex, i);
            BOOST_REQUIRE(mesh.triangles()[corner.face][corner.vertex] == vertex);
            BOOST_REQUIRE((i == 0 || corner.packed() > last));
            BOOST_REQUIRE(rings.place(vertex, corner) == i);
            last = corner.packed();
            ++corners;
        }
    }
    BOOST_TEST(corners == 3 * mesh.triangles().size());
}

BOOST_AUTO_TEST_CASE(every_edge_knows_the_face_across) {
    Random random(2);
    // Edges of one face, of two of either orientation, and of more; vertices with few faces and with many; and one
    // where just one face arrives along each edge that leaves.
    const Mesh three({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}}, {{0, 1, 3}, {0, 1, 2}, {0, 2, 1}}, "three");
    for (const Mesh& mesh :
         {make_shape("knot"), random_soup(random, 40, 200), random_soup(random, 2000, 9000), three}) {
        std::map<std::array<std::uint32_t, 2>, std::vector<Corner>> faces_at;
        for (std::uint32_t face = 0; face < mesh.triangles().size(); ++face)
            for (std::uint32_t k = 0; k < 3; ++k) {
                const auto ends = std::minmax(mesh.triangles()[face][k], mesh.triangles()[face][next_of_three(k)]);
                faces_at[{ends.first, ends.second}].push_back({face, k});
            }
        const OneRings rings(mesh.triangles(), mesh.vertices().size());
        const engine::PairedEdges edges = engine::pair_edges(mesh.triangles(), rings);
        for (const auto& [ends, faces] : faces_at) {
            for (const Corner& edge : faces) {
                const int marks = edges.faces[edge.face].marks[edge.vertex];
                if (ends[0] == ends[1]) {
                    BOOST_TEST(marks == engine::edge_at_box);
                } else if (faces.size() == 2 && faces[0].face != faces[1].face) {
                    const Corner& other = edge.face == faces[0].face ? faces[1] : faces[0];
                    const bool oriented =
                        mesh.triangles()[edge.face][edge.vertex] != mesh.triangles()[other.face][other.vertex];
                    BOOST_TEST(marks == (oriented ? 0 : engine::edge_unoriented));
                    BOOST_TEST(edges.faces[edge.face].across[edge.vertex] == other.packed());
                } else {
                    BOOST_TEST(marks == (faces.size() == 1 ? engine::edge_open : engine::edge_non_manifold));
                }
            }
        }
    }
}

BOOST_AUTO_TEST_CASE(a_vertex_has_a_fan_for_each_cone_that_ends_there) {
    // Two pyramids, tip to tip.
    Mesh mesh({{0, 0, 0}, {4, 0, 5}, {0, 4, 5}, {-4, -4, 5}, {4, 0, -5}, {0, 4, -5}, {-4, -4, -5}},
              {{0, 2, 1}, {0, 3, 2}, {0, 1, 3}, {1, 2, 3}, {0, 4, 5}, {0, 5, 6}, {0, 6, 4}, {4, 6, 5}}, "pyramids");
    const OneRings rings(mesh.triangles(), mesh.vertices().size());
    BOOST_TEST(rings.size(0) == 6U);
    const engine::PairedEdges edges = engine::pair_edges(mesh.triangles(), rings);
    engine::VertexFans fans;
    fans.build(mesh.triangles(), edges.faces, rings, 0);
    BOOST_REQUIRE(fans.fan_count() == 2U);
    for (std::size_t fan = 0; fan < 2; ++fan) {
        BOOST_TEST(fans.start(fan + 1) - fans.start(fan) == 3U);
        for (std::size_t i = fans.start(fan); i < fans.start(fan + 1); ++i)
            BOOST_TEST((fans.faces()[i].neighbour <= 3) == (fan == 0));
    }
}

BOOST_AUTO_TEST_SUITE_END()

}  // namespace
}  // namespace clsdf::test
