#include <clsdf/mesh.hpp>
#include <clsdf/mesh_files.hpp>

#include <boost/test/unit_test.hpp>

using namespace clsdf;

BOOST_AUTO_TEST_CASE(a_shape_has_no_defects_and_its_parts_are_counted) {
    BOOST_TEST(find_defects(make_shape("torus")).components == 1U);
    const Defects found = find_defects(make_shape("nested"));
    BOOST_TEST(found.components == 3U);
    BOOST_TEST(found.zero_area_faces == 0U);
    BOOST_TEST(found.duplicate_faces == 0U);
}

BOOST_AUTO_TEST_CASE(faces_without_area_are_told_exactly) {
    const auto count = [](const Vec3& last) {
        return find_defects(Mesh({{0.1, 0.1, 0.1}, {0.2, 0.2, 0.2}, last}, {{0, 1, 2}})).zero_area_faces;
    };
    BOOST_TEST(count({0.7, 0.7, 0.7}) == 1U);
    BOOST_TEST(count({0.7, 0.7, 0.7000000000000001}) == 0U);
    BOOST_TEST(count({0.1, 0.1, 0.1}) == 0U);  // repeats a vertex, which is another defect
}

BOOST_AUTO_TEST_CASE(a_face_is_a_duplicate_in_any_order_and_with_equal_vertices) {
    const Mesh mesh({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {-0.0, 0, 0}, {5, 5, 5}, {6, 5, 5}, {5, 6, 5}},
                    {{0, 1, 2}, {2, 1, 3}, {1, 2, 0}, {4, 5, 6}});
    const Defects found = find_defects(mesh);
    BOOST_TEST(found.duplicate_faces == 2U);
    BOOST_TEST(found.components == 2U);
}
