#include "support/throws.hpp"

#include <clsdf/reference.hpp>
#include <clsdf/shapes.hpp>

#include <boost/test/unit_test.hpp>

using namespace clsdf;
using reference::find_self_intersections;

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

BOOST_AUTO_TEST_CASE(a_mesh_that_is_not_manifold_is_refused) {
    const Mesh pages({{0, 0, 0}, {0, 0, 1}, {1, 0, 0}, {0, 1, 0}, {-1, 0, 0}}, {{0, 1, 2}, {0, 1, 3}, {0, 1, 4}},
                     "pages");
    test::check_throws(ErrorCode::unsupported, {"pages", "oriented alike"}, [&] { find_self_intersections(pages); });
}
