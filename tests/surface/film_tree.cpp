// Open edges as points see them: the tree over a film is held against the sum over all open edges.

#include "surface/film_tree.hpp"
#include "support/open_meshes.hpp"
#include "surface/film_bounds.hpp"
#include "surface/loop_turns.hpp"
#include "surface/topology.hpp"

#include <boost/test/unit_test.hpp>

#include <cmath>
#include <cstdint>
#include <memory>
#include <vector>

namespace clsdf {

using namespace test;

namespace {

constexpr double unit = 1.0 / 16;

std::shared_ptr<const OpenBoundary> boundary_of(const Mesh& mesh) {
    return std::make_shared<const OpenBoundary>(open_loops_of(mesh, {}), mesh.vertices());
}

std::vector<Mesh> meshes_of(Random& random) {
    std::vector<Mesh> meshes = open_meshes(6);
    meshes.push_back(round_mesh(60, 5, {6, 6, 6}, true, "half sphere with 120 open edges"));
    const Mesh sphere = round_mesh(25, 5, {6.5, 6.5, 6.5}, false, "sphere");
    meshes.push_back(with_chosen_faces(sphere, "sphere with a third of 2400 faces missing",
                                       [&](std::size_t) { return random.uniform(0, 1) > 0.33; }));
    return meshes;
}

/// Anywhere, in the shadows of edges and vertices, beside edges, and far away.
std::vector<Vec3> points_about(const OpenBoundary& boundary, std::size_t count, Random& random) {
    std::vector<Vec3> points;
    for (std::size_t i = 0; i < count; ++i) {
        const Vec3& corner = boundary.corners[random.index(boundary.corners.size())];
        Vec3 point = random.point(-2, 16);
        switch (i % 5) {
            case 0:
                break;
            case 1:
                point[1] = corner[1];
                break;
            case 2:
                point = {point[0], corner[1], corner[2]};
                break;
            case 3:
                point = along(corner, std::pow(10, random.uniform(-6, 0)), random.direction());
                break;
            default:
                point = along(corner, std::pow(10, random.uniform(0, 5)), random.direction());
        }
        points.push_back(point);
    }
    return points;
}

/// The turns of a node's pieces one by one.
double turns_at(const OpenBoundary& boundary, const FilmNodes& nodes, const FilmNodes::Node& node, const Vec3& point) {
    Turns turns = no_turns();
    nodes.walk(
        [&](const FilmNodes::Node& below) {
            const auto corners = nodes.corners_of(below);
            if (below.is_leaf())
                turns = turned_by_loop(
                    turns, corners.size(), [&](std::size_t i) -> const Vec3& { return boundary.corners[corners[i]]; },
                    point, unit);
            return false;
        },
        static_cast<std::uint32_t>(&node - nodes.all().data()));
    return turns_of(turns);
}

}  // namespace

BOOST_AUTO_TEST_CASE(a_view_is_that_of_the_sum_over_all_open_edges) {
    constexpr std::uint64_t seed = 21;
    BOOST_TEST_MESSAGE("seed " << seed);
    Random random(seed);
    for (const Mesh& mesh : meshes_of(random)) BOOST_TEST_CONTEXT(mesh.name()) {
            const auto boundary = boundary_of(mesh);
            const FilmTree tree(boundary, unit);
            std::size_t different = 0, too_far = 0;
            for (const Vec3& point : points_about(*boundary, 2000, random)) {
                const FilmTree::View view = tree.look(point);
                const SolidAngle angle = angle_of(*boundary, point, unit);
                different += view.rounded != angle.rounded ? 1U : 0U;
                too_far += view.to_half > distance_to_half(angle.turns) ? 1U : 0U;
            }
            BOOST_TEST(different == 0U);
            BOOST_TEST(too_far == 0U);
        }
}

BOOST_AUTO_TEST_CASE(the_winding_number_changes_within_a_ball_by_no_more_than_its_bound) {
    constexpr std::uint64_t seed = 22;
    BOOST_TEST_MESSAGE("seed " << seed);
    Random random(seed);
    std::size_t bounded = 0;
    for (const Mesh& mesh : meshes_of(random)) BOOST_TEST_CONTEXT(mesh.name()) {
            const auto boundary = boundary_of(mesh);
            const FilmTree tree(boundary, unit);
            std::size_t greater = 0;
            for (const Vec3& point : points_about(*boundary, 500, random)) {
                const double radius = std::pow(10, random.uniform(-4, 0.5)),
                             bound = tree.change_within(point, radius / unit);
                if (!(bound < 0.5)) continue;
                ++bounded;
                const double change = angle_of(*boundary, along(point, radius, random.direction()), unit).turns -
                                      angle_of(*boundary, point, unit).turns;  // and a whole number, in shadows
                greater += std::abs(change - std::nearbyint(change)) > bound + 1e-12 ? 1U : 0U;
            }
            BOOST_TEST(greater == 0U);
        }
    BOOST_TEST(bounded > 5000U);
}

BOOST_AUTO_TEST_CASE(a_film_far_from_a_ball_is_a_linear_function_there_within_its_bound) {
    constexpr std::uint64_t seed = 23;
    BOOST_TEST_MESSAGE("seed " << seed);
    Random random(seed);
    std::size_t bounded = 0;
    for (const Mesh& mesh : meshes_of(random)) BOOST_TEST_CONTEXT(mesh.name()) {
            const auto boundary = boundary_of(mesh);
            const FilmNodes nodes(boundary->corners, boundary->begins);
            std::size_t greater = 0;
            for (const Vec3& centre : points_about(*boundary, 400, random)) {
                const FilmNodes::Node& node = nodes.all()[random.index(nodes.all().size())];
                const double radius = std::pow(10, random.uniform(-3, 0.5));
                const auto [turns, change] = FilmNodes::linear(node, centre, radius);
                if (!(change.beside < 0.5)) continue;
                ++bounded;
                const Vec3 point = along(centre, radius, random.direction());
                const Vec3 moved{point[0] - centre[0], point[1] - centre[1], point[2] - centre[2]};
                // And a whole number, in shadows.
                const auto off = [&](double expected) {
                    const double difference = turns_at(*boundary, nodes, node, point) - expected;
                    return std::abs(difference - std::nearbyint(difference));
                };
                greater += off(turns + dot(change.gradient, moved)) > change.beside + 1e-11 ? 1U : 0U;
                greater += off(turns) > change.most + 1e-11 ? 1U : 0U;
            }
            BOOST_TEST(greater == 0U);
        }
    BOOST_TEST(bounded > 1000U);
}

BOOST_AUTO_TEST_CASE(an_expansion_is_off_by_no_more_than_its_bound) {
    constexpr std::uint64_t seed = 24;
    BOOST_TEST_MESSAGE("seed " << seed);
    Random random(seed);
    std::size_t bounded = 0, near_bound = 0;
    for (const Mesh& mesh : meshes_of(random)) BOOST_TEST_CONTEXT(mesh.name()) {
            const auto boundary = boundary_of(mesh);
            const FilmNodes nodes(boundary->corners, boundary->begins);
            std::size_t greater = 0, different = 0;
            for (std::size_t i = 0; i < 2000; ++i) {
                const FilmNodes::Node& node = nodes.all()[random.index(nodes.all().size())];
                if (node.expansion == FilmNodes::no_expansion) continue;
                ++bounded;
                const double distance = node.radius / film_reach * (1 + std::pow(10, random.uniform(-3, 1)));
                const Vec3 point = along(node.centre, distance, random.direction());
                const auto from_centre = [&](double x) {
                    return Vec3{node.centre[0] - x, node.centre[1] - point[1], node.centre[2] - point[2]};
                };
                const FilmExpansion& expansion = nodes.expansion_of(node);
                const double turns = expansion.at(from_centre(point[0]));
                // And a whole number, in shadows.
                const double difference = turns - turns_at(*boundary, nodes, node, point),
                             off = std::abs(difference - std::nearbyint(difference)),
                             error = FilmNodes::error_of(node, distance);
                greater += off > error + 1e-11 ? 1U : 0U;
                near_bound += off > 0.1 * error ? 1U : 0U;
                constexpr double step = 0.25;
                const double y = node.centre[1] - point[1];
                const auto rows = expansion.at<2, 4>(from_centre(point[0] - 2 * step), {y + 1, y}, step);
                different += std::abs(rows[1][2] - turns) > 1e-12 ? 1U : 0U;
            }
            BOOST_TEST(greater == 0U);
            BOOST_TEST(different == 0U);
        }
    BOOST_TEST(bounded > 5000U);
    BOOST_TEST(near_bound > 100U);  // the bound is not much too wide
}

}  // namespace clsdf
