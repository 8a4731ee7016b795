#include <clsdf/mesh.hpp>
#include <clsdf/mesh_files.hpp>

#include "support/hostile_meshes.hpp"
#include "support/throws.hpp"

#include <boost/test/unit_test.hpp>

#include <cmath>
#include <cstdint>
#include <vector>

using namespace clsdf;
using namespace clsdf::test;

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

BOOST_AUTO_TEST_CASE(a_plate_that_is_thinner_than_the_length_of_a_weld_is_told) {
    const Mesh thin = plate(0.001);
    const WeldReport flat = describe_weld(thin, weld(thin, 0.002));
    BOOST_TEST(flat.lost_faces == 8U);
    BOOST_TEST(flat.coinciding_faces == 4U);
    BOOST_TEST(std::abs(flat.volume_before - 0.004) < 1e-12);
    BOOST_TEST(flat.volume_after == 0);
    for (const char* fragment : {"faces lose their area", "to 0;", "flat", "give a smaller"})
        BOOST_TEST(flat.warning.find(fragment) != std::string::npos, "no '" << fragment << "' in " << flat.warning);
    const WeldReport kept = describe_weld(thin, weld(thin, 0.0005));
    BOOST_TEST(kept.lost_faces == 0U);
    BOOST_TEST(kept.coinciding_faces == 0U);
    BOOST_TEST(kept.volume_after == kept.volume_before);
    BOOST_TEST(kept.warning.empty());
}

BOOST_AUTO_TEST_CASE(faces_that_a_weld_takes_away_or_lays_on_others_are_counted) {
    // Two sheets 1e-3 apart, of the same triangles; a sliver; a face that was there twice before.
    const Mesh mesh({{0, 0, 0},
                     {1, 0, 0},
                     {0, 1, 0},
                     {0, 0, 1e-3},
                     {1, 0, 1e-3},
                     {0, 1, 1e-3},
                     {5, 0, 0},
                     {5, 1e-3, 0},
                     {6, 0, 0},
                     {9, 0, 0},
                     {9, 1, 0},
                     {8, 0, 0}},
                    {{0, 1, 2}, {3, 5, 4}, {6, 7, 8}, {9, 10, 11}, {9, 11, 10}, {0, 0, 1}});
    const WeldReport report = describe_weld(mesh, weld(mesh, 2e-3));
    BOOST_TEST(report.lost_faces == 1U);
    BOOST_TEST(report.coinciding_faces == 2U);
    BOOST_TEST(describe_weld(mesh, weld(mesh, 1e-4)).warning.empty());
    // A weld that takes slivers away and keeps the volume says so in other words.
    std::vector<Vec3> vertices = cube(1).vertices();
    std::vector<Triangle> triangles = cube(1).triangles();
    const auto [a, b, c] = triangles[0];
    const auto tip = static_cast<std::uint32_t>(vertices.size());
    vertices.push_back(vertices[a]);
    vertices.back()[0] *= 1 - 1e-9;
    triangles[0] = {tip, b, c};
    triangles.push_back({a, b, tip});
    triangles.push_back({c, a, tip});
    const Mesh cut(vertices, triangles);
    const WeldReport slivers = describe_weld(cut, weld(cut, 1e-6));
    BOOST_TEST(slivers.lost_faces == 2U);
    BOOST_TEST(slivers.warning.find("flat") == std::string::npos, slivers.warning);
    BOOST_TEST(slivers.warning.find("give a smaller length") != std::string::npos, slivers.warning);
    check_throws(ErrorCode::invalid_argument, {"6 triangles", "14"}, [&] { describe_weld(mesh, cut); });
}
