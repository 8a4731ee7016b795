#include "support/exact_field.hpp"
#include "support/hostile_meshes.hpp"

#include <clsdf/tuning.hpp>

#include <algorithm>
#include <array>
#include <vector>

using namespace clsdf;
using namespace clsdf::test;

namespace {

constexpr std::array both_bodies{KernelBody::by_vector, KernelBody::by_group};

/// Each triangle in four.
Mesh divided(const Mesh& mesh) {
    std::vector<Vec3> vertices;
    std::vector<Triangle> triangles;
    const auto add = [&](const Vec3& a, const Vec3& b, const Vec3& c) {
        const auto first = static_cast<std::uint32_t>(vertices.size());
        vertices.insert(vertices.end(), {a, b, c});
        triangles.push_back({first, first + 1, first + 2});
    };
    for (const Triangle& t : mesh.triangles()) {
        const Vec3 &a = mesh.vertices()[t[0]], &b = mesh.vertices()[t[1]], &c = mesh.vertices()[t[2]];
        const auto between = [](const Vec3& p, const Vec3& q) {
            return Vec3{0.5 * (p[0] + q[0]), 0.5 * (p[1] + q[1]), 0.5 * (p[2] + q[2])};
        };
        const Vec3 ab = between(a, b), bc = between(b, c), ca = between(c, a);
        add(a, ab, ca);
        add(ab, b, bc);
        add(ca, bc, c);
        add(ab, bc, ca);
    }
    return {std::move(vertices), std::move(triangles), mesh.name() + " divided"};
}

}  // namespace

// Inside a cube of dyadic coordinates distances are exact in floats: samples on its diagonals, its medial planes and on
// the faces' own diagonals are as near to several triangles.
BOOST_AUTO_TEST_CASE(the_lowest_of_the_nearest_triangles_is_named) {
    const Grid grid = grid_at({0, 0, 0}, 0.125, 9);
    for (std::uint64_t seed = 1; seed <= 5; ++seed) BOOST_TEST_CONTEXT("seed " << seed) {
            Random random(seed);
            const Mesh mesh = reordered(cube(1), random);
            const Field expected = reference::reference_field(mesh, grid, Band::full());
            for (const KernelBody body : both_bodies) {
                const Field field = compute(mesh, grid, Band::full(), body);
                BOOST_TEST(field.triangle()[grid.offset(9, 9, 9)] == 0U);
                std::size_t inside = 0;
                for (std::size_t at = 0; at < field.distance().size(); ++at)
                    if (expected.distance()[at] < 0) {
                        ++inside;
                        BOOST_REQUIRE(field.distance()[at] == expected.distance()[at]);
                        BOOST_REQUIRE(field.triangle()[at] == expected.triangle()[at]);
                    }
                BOOST_TEST(inside == 15U * 15U * 15U);
            }
        }
}

// The same in a cube of 12,288 triangles: groups share their list, and faces that are equally near are in different
// shares.
BOOST_AUTO_TEST_CASE(the_lowest_of_the_nearest_triangles_is_named_among_shares) {
    Random random(1);
    Mesh fine = cube(1);
    for (int round = 0; round < 5; ++round) fine = divided(fine);
    const Mesh mesh = reordered(fine, random);
    const Grid grid = grid_at({0, 0, 0}, 0.125, 7);
    const Field expected = reference::reference_field(mesh, grid, Band::full());
    const Field field = compute(mesh, grid, Band::full(), KernelBody::by_group);
    BOOST_TEST((bits_of(field.distance()) == bits_of(expected.distance())));
    BOOST_TEST(std::ranges::equal(field.triangle(), expected.triangle()));
}

// Over a face both copies are looked at, and equally far to the last bit. Beside an edge or a vertex, which many
// triangles share anyhow, only one of them may be.
BOOST_AUTO_TEST_CASE(of_equal_triangles_the_first_is_named) {
    const Mesh once = tilted(make_shape("seashell"));
    const auto count = static_cast<std::uint32_t>(once.triangles().size());
    std::vector<Triangle> triangles = once.triangles();
    triangles.insert(triangles.end(), once.triangles().begin(), once.triangles().end());
    const Mesh twice(once.vertices(), triangles, "seashell twice");
    const Grid grid = grid_around(twice, 28, 4);
    const reference::Oracle oracle(once);
    for (const KernelBody body : both_bodies) {
        const Field field = compute(twice, grid, Band::symmetric(3 * grid.voxel()), body);
        check_exact(twice, field);
        std::size_t over_faces = 0;
        for (std::int64_t k = 0; k < grid.size[2]; ++k)
            for (std::int64_t j = 0; j < grid.size[1]; ++j)
                for (std::int64_t i = 0; i < grid.size[0]; ++i) {
                    const std::uint32_t triangle = field.triangle()[grid.offset(i, j, k)];
                    if (triangle == no_triangle) continue;
                    const reference::Nearest nearest = oracle.nearest(grid.position(i, j, k));
                    if (nearest.site != reference::Site::face) continue;
                    ++over_faces;
                    BOOST_REQUIRE(triangle < count);
                }
        BOOST_TEST(over_faces > 1000U);
    }
}

// Two of each: frames depend on the order of corners if edges are equally long.
BOOST_AUTO_TEST_CASE(of_triangles_with_their_corners_in_any_order_the_first_is_named) {
    for (const Triangle& other : {Triangle{0, 1, 2}, Triangle{1, 2, 0}, Triangle{2, 0, 1}, Triangle{2, 1, 0},
                                  Triangle{1, 0, 2}, Triangle{0, 2, 1}})
        for (const std::size_t count : {1U, 2U}) {
            std::vector<Triangle> triangles{{0, 1, 2}};
            triangles.insert(triangles.end(), count, other);
            const double a = 0.3712, b = a + 1.3;
            const Mesh mesh({{b, a, a}, {a, b, a}, {a, a, b}}, triangles, "equilateral");
            const Grid grid = grid_at({0.31, 0.33, 0.37}, 0.1137, 9);
            for (const KernelBody body : both_bodies) {
                const DistanceTransform transform(test_device(), mesh, {.sign = SignRule::none, .body = body});
                const Field field = transform.compute(grid, Band::full(), all_outputs());
                BOOST_TEST(std::ranges::count(field.triangle(), 0U) == std::ssize(field.triangle()));
                const Field at_points = query(transform, samples_of(grid));
                BOOST_TEST(std::ranges::count(at_points.triangle(), 0U) == std::ssize(at_points.triangle()));
                // The first triangle alone has the same weights of its vertices.
                const Mesh alone(mesh.vertices(), {{0, 1, 2}}, "alone");
                const DistanceTransform of_one(test_device(), alone, {.sign = SignRule::none, .body = body});
                const Field of_alone = query(of_one, samples_of(grid));
                BOOST_TEST(same_bytes(of_alone.slab(), at_points.slab(), Output::barycentric));
            }
        }
}

// Any triangle, and one with two equal sides; near the origin and far from it.
BOOST_AUTO_TEST_CASE(of_two_triangles_with_the_same_corners_the_first_is_named) {
    constexpr unsigned seed = 5;
    BOOST_TEST_INFO("seed " << seed);
    Random random(seed);
    for (std::size_t n = 0; n < 20; ++n) {
        const double far = n % 2 == 0 ? 0 : 1000.3;
        std::vector<Vec3> corners{{0.1 + far, 0.2, 0.3}, {1.1 + far, 0.2, 0.3}, {0.1 + far, 1.2, 0.3}};
        if (n >= 10)
            for (Vec3& corner : corners)
                corner = {random.uniform(-1, 1) + far, random.uniform(-1, 1), random.uniform(-1, 1)};
        const Triangle other = std::array{Triangle{1, 2, 0}, Triangle{2, 0, 1}, Triangle{2, 1, 0}, Triangle{1, 0, 2},
                                          Triangle{0, 2, 1}}[n % 5];
        const Mesh mesh(corners, {{0, 1, 2}, other}, "twins");
        const DistanceTransform transform(test_device(), mesh, {.sign = SignRule::none});
        const Grid grid = grid_at({far + 0.3, 0.3, 0.3}, 0.11, 8);
        const Field field = transform.compute(grid, Band::full(), Output::triangle);
        BOOST_TEST(std::ranges::count(field.triangle(), 0U) == std::ssize(field.triangle()));
        const Field at_points = query(transform, samples_of(grid));
        BOOST_TEST(std::ranges::count(at_points.triangle(), 0U) == std::ssize(at_points.triangle()));
    }
}

// Thousands of triangles are as near as rounding tells: any of the nearest is right, and always the same one.
BOOST_AUTO_TEST_CASE(the_centre_of_a_sphere_is_nearest_to_one_of_its_triangles) {
    const Mesh mesh = make_shape("sphere4");
    for (const KernelBody body : both_bodies) {
        const Field field = compute(mesh, grid_at({0, 0, 0}, 0.0625, 3), Band::full(), body);
        check_exact(mesh, field, guaranteed);
        BOOST_TEST(same_bytes(field, compute(mesh, field.grid, field.band, body)));
    }
}

// On the octahedron all planes are equally far from the centre, and their numbers are the same but for order and sign.
BOOST_AUTO_TEST_CASE(the_centre_of_an_octahedron_is_nearest_to_its_first_triangle) {
    Random random(3);
    const Mesh mesh = reordered(make_shape("sphere0"), random);
    for (const KernelBody body : both_bodies) {
        const Field field = compute(mesh, grid_at({0, 0, 0}, 0.125, 2), Band::full(), body);
        check_exact(mesh, field);
        BOOST_TEST(field.triangle()[field.grid.offset(2, 2, 2)] == 0U);
    }
}
