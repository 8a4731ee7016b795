#include "support/test_meshes.hpp"

#include <clsdf/mesh.hpp>
#include <clsdf/papers.hpp>

#include <boost/test/unit_test.hpp>

#include <cmath>

using namespace clsdf;

namespace {

/// A square pyramid without its base, apex at (0, 0, height), the square's corners at z = 0.
Mesh open_pyramid(double height) {
    return {{{0, 0, height}, {1, 0, 0}, {0, 1, 0}, {-1, 0, 0}, {0, -1, 0}},
            {{0, 1, 2}, {0, 2, 3}, {0, 3, 4}, {0, 4, 1}},
            "pyramid"};
}

void check_one_kind(const Mesh& mesh, EdgeKind edge, VertexKind vertex) {
    const Classification found = classify_convexity(mesh);
    BOOST_TEST(found.count(edge) == 3 * mesh.triangles().size() / 2);
    BOOST_TEST(found.count(vertex) == mesh.vertices().size());
}

}  // namespace

BOOST_AUTO_TEST_CASE(a_tetrahedron_is_convex_and_turned_inside_out_concave) {
    const Mesh solid = test::b1().mesh;
    check_one_kind(solid, EdgeKind::convex, VertexKind::convex);
    std::vector<Triangle> turned = solid.triangles();
    for (Triangle& triangle : turned) std::swap(triangle[1], triangle[2]);
    check_one_kind(Mesh(solid.vertices(), turned), EdgeKind::concave, VertexKind::concave);
}

BOOST_AUTO_TEST_CASE(the_diagonals_of_a_cube_are_flat) {
    const Classification found = classify_convexity(make_shape("cube"));
    BOOST_TEST(found.count(EdgeKind::convex) == 12U);
    BOOST_TEST(found.count(EdgeKind::flat) == 6U);
    BOOST_TEST(found.count(VertexKind::convex) == 8U);
}

BOOST_AUTO_TEST_CASE(a_step_has_saddle_vertices_where_its_inner_edge_ends) {
    const Classification found = classify_convexity(test::a1_step().mesh);
    BOOST_TEST(found.count(EdgeKind::concave) == 1U);
    BOOST_TEST(found.count(VertexKind::saddle) == 2U);
    BOOST_TEST(found.count(VertexKind::convex) == 10U);
}

BOOST_AUTO_TEST_CASE(the_last_bit_of_a_coordinate_decides) {
    const auto apex = [](double height) { return classify_convexity(open_pyramid(height)).vertices[0]; };
    BOOST_TEST((apex(0) == VertexKind::flat));
    BOOST_TEST((apex(std::numeric_limits<double>::denorm_min()) == VertexKind::convex));
    BOOST_TEST((apex(-std::numeric_limits<double>::denorm_min()) == VertexKind::concave));

    // The same far away, where the faces' frames cannot tell: one neighbour up and one down by the last bit.
    std::vector<Vec3> vertices = open_pyramid(0).vertices();
    for (Vec3& vertex : vertices)
        for (double& coordinate : vertex) coordinate += 1e6;
    const std::vector<Triangle> triangles = open_pyramid(0).triangles();
    BOOST_TEST((classify_convexity(Mesh(vertices, triangles)).vertices[0] == VertexKind::flat));
    vertices[1][2] = std::nextafter(1e6, 2e6);
    BOOST_TEST((classify_convexity(Mesh(vertices, triangles)).vertices[0] == VertexKind::concave));
    vertices[2][2] = std::nextafter(1e6, 0);
    BOOST_TEST((classify_convexity(Mesh(vertices, triangles)).vertices[0] == VertexKind::saddle));
}

BOOST_AUTO_TEST_CASE(boundaries_and_what_is_not_manifold_are_classes_of_their_own) {
    const Classification open = classify_convexity(open_pyramid(1));
    BOOST_TEST(open.count(EdgeKind::boundary) == 4U);
    BOOST_TEST(open.count(EdgeKind::convex) == 4U);
    BOOST_TEST(open.count(VertexKind::boundary) == 4U);
    BOOST_TEST(open.count(VertexKind::convex) == 1U);

    const Classification three_pages = classify_convexity(
        Mesh({{0, 0, 0}, {0, 0, 1}, {1, 0, 0}, {0, 1, 0}, {-1, 0, 0}}, {{0, 1, 2}, {0, 1, 3}, {0, 1, 4}}));
    BOOST_TEST(three_pages.count(EdgeKind::non_manifold) == 1U);
    BOOST_TEST(three_pages.count(EdgeKind::boundary) == 6U);
    BOOST_TEST(three_pages.count(VertexKind::non_manifold) == 2U);
    BOOST_TEST(three_pages.count(VertexKind::boundary) == 3U);

    const Classification turned =
        classify_convexity(Mesh({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, -1, 1}}, {{0, 1, 2}, {0, 1, 3}}));
    BOOST_TEST(turned.count(EdgeKind::unoriented) == 1U);
    BOOST_TEST(turned.count(VertexKind::non_manifold) == 2U);
}

BOOST_AUTO_TEST_CASE(two_fans_at_one_vertex_are_not_manifold) {
    // Two pyramids that share the apex only; then a closed and an open one, then two open ones.
    const std::vector<Vec3> vertices{{0, 0, 0}, {1, 0, -1}, {0, 1, -1}, {-1, -1, -1},
                                     {1, 0, 1}, {0, 1, 1},  {-1, -1, 1}};
    const Triangle lower[]{{0, 1, 2}, {0, 2, 3}, {0, 3, 1}};
    const Triangle upper[]{{0, 5, 4}, {0, 6, 5}, {0, 4, 6}};
    for (const std::size_t of_lower : {3U, 2U, 1U})
        for (const std::size_t of_upper : {0U, 1U, 2U, 3U})
            BOOST_TEST_CONTEXT(of_lower << " faces below, " << of_upper << " above") {
                std::vector<Triangle> triangles(lower, lower + of_lower);
                triangles.insert(triangles.end(), upper, upper + of_upper);
                const VertexKind expected = of_upper > 0   ? VertexKind::non_manifold
                                            : of_lower < 3 ? VertexKind::boundary
                                                           : VertexKind::convex;
                BOOST_TEST((classify_convexity(Mesh(vertices, triangles)).vertices[0] == expected));
            }
}

BOOST_AUTO_TEST_CASE(equal_vertices_are_one_and_faces_that_repeat_one_drop_out) {
    const Mesh cube = make_shape("cube");
    std::vector<Vec3> vertices;
    std::vector<Triangle> triangles;
    for (const Triangle& triangle : cube.triangles()) {
        const auto first = static_cast<std::uint32_t>(vertices.size());
        for (const std::uint32_t index : triangle) vertices.push_back(cube.vertices()[index]);
        triangles.push_back({first, first + 1, first + 2});
    }
    triangles.push_back({0, 0, 1});
    vertices.push_back({5, 5, 5});
    const Classification found = classify_convexity(Mesh(vertices, triangles));
    BOOST_TEST(found.count(EdgeKind::convex) == 12U);
    BOOST_TEST(found.count(EdgeKind::flat) == 6U);
    BOOST_TEST(found.count(VertexKind::convex) == 8U);
    BOOST_TEST(found.count(VertexKind::unused) == 1U);
    for (std::size_t i = 0; i + 1 < vertices.size(); ++i) BOOST_TEST((found.vertices[i] == VertexKind::convex));
}

BOOST_AUTO_TEST_CASE(faces_folded_onto_each_other_have_no_boundary) {
    const Classification found = classify_convexity(Mesh({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {{0, 1, 2}, {0, 2, 1}}));
    BOOST_TEST(found.count(EdgeKind::flat) == 3U);
    BOOST_TEST(found.count(VertexKind::flat) == 3U);
}

BOOST_AUTO_TEST_CASE(the_papers_sphere_has_no_saddle_and_its_torus_1788) {
    BOOST_TEST(classify_convexity(make_shape("sphere6")).count(VertexKind::convex) == 16386U);
    BOOST_TEST(classify_convexity(make_shape("torus")).count(VertexKind::saddle) == 1788U);
}
