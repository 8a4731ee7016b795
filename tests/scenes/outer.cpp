// The outer surface of the bodies of a scene, against that of one mesh, and against the scene where that is exact.
#include "random_scenes.hpp"

#include "support/hostile_meshes.hpp"
#include "support/throws.hpp"

#include <clsdf/fractions.hpp>

#include <boost/test/unit_test.hpp>

#include <cmath>
#include <set>
#include <vector>

using namespace clsdf;
using namespace clsdf::test;

namespace {

Pose at(const Vec3& translation) {
    return {.translation = translation};
}

constexpr Pose quarter_turn{{{{0, -1, 0}, {1, 0, 0}, {0, 0, 1}}}, {0.5, 0, 0}};

}  // namespace

BOOST_AUTO_TEST_CASE(bodies_that_overlap_have_the_outer_surface_of_their_mesh) {
    Scene scene(test_device());
    const std::uint32_t first = scene.add(cube(1));
    scene.add_instance(first, at({1.25, 0.5, 0.25}));
    const SceneSurface found = scene.outer();
    const OuterSurface expected = outer(together({cube(1), shifted(cube(1), {1.25, 0.5, 0.25})}, "two"));
    BOOST_TEST((found.surface.mesh.vertices() == expected.mesh.vertices()));
    BOOST_TEST((found.surface.mesh.triangles() == expected.mesh.triangles()));
    const auto faces = static_cast<std::uint32_t>(cube(1).triangles().size());
    for (std::size_t i = 0; i < expected.faces.size(); ++i)
        BOOST_TEST(found.bodies[i] * faces + found.surface.faces[i] == expected.faces[i]);
    // The overlap is 0.75 x 1.5 x 1.75.
    BOOST_TEST(std::abs(found.surface.volume - (16 - 0.75 * 1.5 * 1.75)) < 1e-14);
}

BOOST_AUTO_TEST_CASE(distances_to_it_are_those_of_the_scene_where_these_are_the_unions) {
    Scene scene(test_device());
    scene.add(make_shape("sphere4"));
    scene.add(cube(0.6), quarter_turn);
    scene.add_instance(0, at({0.9, 0.4, 0.1}));
    Random random(5);
    std::vector<Vec3> points;
    for (int i = 0; i < 4000; ++i)
        points.push_back({random.uniform(-1.5, 2.5), random.uniform(-1.5, 2), random.uniform(-1.5, 1.5)});
    const PointValues of_scene = query(scene, points);
    const SceneSurface surface = scene.outer();
    const DistanceTransform transform(test_device(), surface.surface.mesh);
    std::vector<double> distance(points.size());
    transform.query(points, Band::full().outside, {{Output::distance, std::span(distance)}});
    std::size_t deeper = 0, inside = 0;
    for (std::size_t i = 0; i < points.size(); ++i) {
        BOOST_TEST(std::signbit(of_scene.distance[i]) == std::signbit(distance[i]));
        inside += distance[i] < 0 ? 1U : 0U;
        if (of_scene.is_own[i] != 0) {
            BOOST_TEST(std::abs(of_scene.distance[i] - distance[i]) < 1e-12);
        } else {
            BOOST_TEST(distance[i] < of_scene.distance[i] + 1e-12);
            deeper += distance[i] < of_scene.distance[i] - 1e-6 ? 1U : 0U;
        }
    }
    BOOST_TEST(inside > 500U);
    BOOST_TEST(deeper > 10U);
}

BOOST_AUTO_TEST_CASE(each_body_has_its_own_rule_and_those_that_are_off_do_not_count) {
    Scene scene(test_device());
    scene.add(reversed(cube(1)));
    scene.add(together({cube(1), cube(0.5)}, "hollow"), at({1.75, 0, 0}), SignRule::parity);
    const std::uint32_t off = scene.add(cube(3));
    scene.set_active(off, false);
    const SceneSurface found = scene.outer();
    // The cavity reaches from 1.25 to 2.25, which the first cube does not.
    BOOST_TEST(std::abs(found.surface.volume - (8 + 8 - 0.25 * 4 - 1)) < 1e-14);
    BOOST_TEST((std::set<std::uint32_t>(found.bodies.begin(), found.bodies.end()) == std::set<std::uint32_t>{0, 1}));
    // Cells count once what is in both.
    const Fractions cells = fractions(found.surface, grid_at({-1.6, -1.6, -1.6}, 0.3, 20));
    double volume = 0;
    for (const std::uint8_t byte : cells.full)
        for (unsigned bit = 0; bit < 8; ++bit) volume += byte >> bit & 1U;
    for (const CellFraction& cell : cells.cells) volume += cell.volume;
    BOOST_TEST(std::abs(volume * 0.3 * 0.3 * 0.3 - 14) < 1e-12);
}

BOOST_AUTO_TEST_CASE(what_has_no_outer_surface_is_named) {
    Scene scene(test_device());
    check_throws(ErrorCode::invalid_argument, {"no bodies"}, [&] { scene.outer(); });
    scene.add(cube(1));
    scene.add(Mesh({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {{0, 1, 2}}, "sheet"));
    check_throws(ErrorCode::unsupported, {"body 1"}, [&] { scene.outer(); });
}
