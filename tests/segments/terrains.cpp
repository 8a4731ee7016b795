// Links, crossings, rays and exact signs with the sign rule below: those of the closed mesh, whose walls and floor have
// no triangle.
#include "segments/segment_families.hpp"
#include "support/exact_field.hpp"
#include "support/hostile_meshes.hpp"
#include "support/random_meshes.hpp"
#include "support/throws.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

using namespace clsdf;
using namespace clsdf::test;

namespace {

struct Terrain {
    Mesh mesh;
    double floor;
    Grid grid;

    std::uint32_t count() const { return static_cast<std::uint32_t>(mesh.triangles().size()); }
};

/// Heights over a square of n x n cells, which are whole numbers, without one cell if it has a hole.
Mesh heights(Random& random, std::uint32_t n, bool has_hole) {
    std::vector<Vec3> vertices;
    for (std::uint32_t j = 0; j <= n; ++j)
        for (std::uint32_t i = 0; i <= n; ++i)
            vertices.push_back({static_cast<double>(i), static_cast<double>(j), 2.0 + random.index(3)});
    std::vector<Triangle> triangles;
    for (std::uint32_t j = 0; j < n; ++j)
        for (std::uint32_t i = 0; i < n; ++i) {
            if (has_hole && i == n / 2 && j == n / 2) continue;
            const std::uint32_t a = j * (n + 1) + i, b = a + 1, c = a + n + 1, d = c + 1;
            triangles.push_back({a, b, d});
            triangles.push_back({a, d, c});
        }
    return {vertices, triangles, has_hole ? "terrain with a hole" : "terrain"};
}

std::vector<Terrain> terrains(Random& random) {
    const Grid grid{{-1, -1, -1}, {0.5, 0.5, 0.5}, {15, 15, 14}, {}};
    const Mesh plain = heights(random, 5, false), hole = heights(random, 5, true);
    // Vertices of every face for itself, which differ by rounding.
    Mesh apart = unwelded(plain);
    std::vector<Vec3> positions = apart.vertices();
    for (Vec3& p : positions) p[0] += random.uniform(-1e-15, 1e-15);
    return {{plain, 0, grid},
            {hole, -0.25, grid},
            {Mesh(positions, apart.triangles(), "apart"), 0.5, grid},
            {hole, -1e5, {{-0.3, -0.4, -1.2}, {0.7, 0.6, 0.9}, {10, 11, 8}, {}}}};
}

DistanceTransform below(const Terrain& terrain) {
    return {test_device(), terrain.mesh, {.sign = SignRule::below, .floor = terrain.floor}};
}
DistanceTransform closed(const Terrain& terrain) {
    return {test_device(), close_down(terrain.mesh, terrain.floor), {.sign = SignRule::nonzero}};
}

/// The number in the terrain of a triangle of the closed mesh.
std::uint32_t number(const Terrain& terrain, std::uint32_t triangle) {
    return triangle < terrain.count() ? triangle : no_triangle;
}

void check_links(const Terrain& terrain, const Links& found, const Links& expected) {
    BOOST_TEST((found.samples == expected.samples));
    BOOST_TEST((found.directions == expected.directions));
    BOOST_TEST((found.q == expected.q));
    BOOST_TEST((found.counts == expected.counts));
    BOOST_TEST((found.inside.bits == expected.inside.bits));
    BOOST_REQUIRE(found.size() == expected.size());
    std::size_t wrong = 0, closing = 0;
    for (std::size_t n = 0; n < found.size(); ++n) {
        const std::uint32_t triangle = number(terrain, expected.triangles[n]);
        const auto flag = static_cast<unsigned>(expected.flags[n]) |
                          (triangle == no_triangle ? static_cast<unsigned>(SegmentFlag::closing) : 0U);
        wrong += found.triangles[n] != triangle || static_cast<unsigned>(found.flags[n]) != flag;
        closing += triangle == no_triangle;
    }
    BOOST_TEST(wrong == 0U);
    BOOST_TEST(closing > 0U);
    BOOST_TEST(closing < found.size());
}

struct Hits4 {
    explicit Hits4(std::size_t rays) : t(4 * rays), triangles(4 * rays), counts(rays) {}
    std::vector<double> t;
    std::vector<std::uint32_t> triangles, counts;

    RayTargets targets() { return {.most = 4, .t = t, .triangles = triangles, .counts = counts}; }
};

/// From points of the grid's box and its samples, along axes and anyhow.
void set_rays(Random& random, const Grid& grid, std::vector<Vec3>& origins, std::vector<Vec3>& directions) {
    for (std::size_t i = 0; i < 600; ++i) {
        Vec3 from{}, along{};
        for (std::size_t axis = 0; axis < 3; ++axis) {
            const auto n = static_cast<double>(random.index(static_cast<std::uint32_t>(grid.size[axis])));
            from[axis] = grid.origin[axis] + grid.spacing[axis] * (i % 3 == 0 ? n + random.uniform(0, 1) : n);
            along[axis] = i % 2 == 0 ? random.uniform(-1, 1) : static_cast<double>(random.index(3)) - 1;
        }
        if (along == Vec3{}) along[2] = -1;
        origins.push_back(from);
        directions.push_back(along);
    }
}

}  // namespace

BOOST_AUTO_TEST_SUITE(terrains_of_segments)

BOOST_AUTO_TEST_CASE(links_and_crossings_are_those_of_the_closed_mesh) {
    const std::uint64_t seed = std::random_device{}();
    BOOST_TEST_MESSAGE("seed " << seed);
    Random random(seed);
    for (const Terrain& terrain : terrains(random)) BOOST_TEST_CONTEXT(terrain.mesh.name()) {
            const DistanceTransform one = below(terrain), other = closed(terrain);
            const auto directions = stencil("D3Q27");
            check_links(terrain, one.links(terrain.grid, directions), other.links(terrain.grid, directions));
            check_links(terrain, one.links(terrain.grid, directions, {.with_between = true}),
                        other.links(terrain.grid, directions, {.with_between = true}));
            BOOST_TEST(one.count_links(terrain.grid, directions) == other.count_links(terrain.grid, directions));
            const Crossings edges = one.crossings(terrain.grid, {.with_counts = true}),
                            expected = other.crossings(terrain.grid, {.with_counts = true});
            for (std::size_t axis = 0; axis < 3; ++axis) {
                const EdgeCrossings &a = edges.axes.at(axis), &b = expected.axes.at(axis);
                BOOST_TEST((a.counts == b.counts));
                std::size_t wrong = 0;
                for (std::size_t n = 0; n < b.coordinates.size(); ++n)
                    wrong += (a.coordinates[n] != b.coordinates[n] && !std::isnan(b.coordinates[n])) ||
                             a.triangles[n] != number(terrain, b.triangles[n]);
                BOOST_TEST(wrong == 0U);
            }
            // The terrain's own faces alone.
            const Links faces = one.links(terrain.grid, directions, {.hits = Hits::faces});
            BOOST_TEST(std::ranges::count(faces.triangles, no_triangle) == 0);
            BOOST_TEST((faces.inside.bits == edges.inside.bits));
        }
}

BOOST_AUTO_TEST_CASE(rays_and_pairs_are_those_of_the_closed_mesh) {
    const std::uint64_t seed = std::random_device{}();
    BOOST_TEST_MESSAGE("seed " << seed);
    Random random(seed);
    for (const Terrain& terrain : terrains(random)) BOOST_TEST_CONTEXT(terrain.mesh.name()) {
            const DistanceTransform one = below(terrain), other = closed(terrain);
            std::vector<Vec3> origins, directions;
            set_rays(random, terrain.grid, origins, directions);
            for (const double limit : {std::numeric_limits<double>::infinity(), 2.5}) {
                Hits4 found(origins.size()), expected(origins.size());
                one.rays(origins, directions, {.limit = limit}, found.targets());
                other.rays(origins, directions, {.limit = limit}, expected.targets());
                for (std::uint32_t& triangle : expected.triangles) triangle = number(terrain, triangle);
                BOOST_TEST((found.t == expected.t));
                BOOST_TEST((found.triangles == expected.triangles));
                BOOST_TEST((found.counts == expected.counts));
                const auto walls = std::ranges::count_if(
                    found.t, [](double t) { return t < std::numeric_limits<double>::infinity(); });
                const auto without = walls - std::ranges::count_if(found.triangles, [](std::uint32_t triangle) {
                                         return triangle != no_triangle;
                                     });
                BOOST_TEST(without > 0);
                BOOST_TEST(without < walls);
            }
            std::vector<Vec3> ends = origins;
            std::ranges::reverse(ends);
            std::vector<std::uint8_t> visible(ends.size()), expected(ends.size());
            one.visible(origins, ends, visible);
            other.visible(origins, ends, expected);
            BOOST_TEST((visible == expected));
            BOOST_TEST(std::ranges::count(visible, 1) > 0);
        }
}

BOOST_AUTO_TEST_CASE(fields_have_the_exact_signs_of_the_closed_mesh) {
    const std::uint64_t seed = std::random_device{}();
    BOOST_TEST_MESSAGE("seed " << seed);
    Random random(seed);
    for (const Terrain& terrain : terrains(random)) BOOST_TEST_CONTEXT(terrain.mesh.name()) {
            const DistanceTransform one = below(terrain);
            const SampleSides sides = closed(terrain).links(terrain.grid, stencil("D3Q15")).inside;
            for (const Band& band : {Band::symmetric(1), Band::signs_only(), Band::full()}) {
                const Field field = one.compute(terrain.grid, band.with_exact_signs());
                const Grid part = terrain.grid.part({2, 3, 4}, {6, 5, 3});
                const Field of_part = one.compute(part, band.with_exact_signs());
                std::size_t wrong = 0, n = 0;
                for (std::int64_t z = 0; z < terrain.grid.size[2]; ++z)
                    for (std::int64_t y = 0; y < terrain.grid.size[1]; ++y)
                        for (std::int64_t x = 0; x < terrain.grid.size[0]; ++x)
                            wrong += (field.distance()[n++] < 0) != sides.is_inside({x, y, z});
                BOOST_TEST(wrong == 0U);
                n = 0;
                for (std::int64_t z = 0; z < 3; ++z)
                    for (std::int64_t y = 0; y < 5; ++y)
                        for (std::int64_t x = 0; x < 6; ++x)
                            wrong +=
                                of_part.distance()[n++] != field.distance()[terrain.grid.offset(x + 2, y + 3, z + 4)];
                BOOST_TEST(wrong == 0U);
            }
        }
}

BOOST_AUTO_TEST_CASE(moved_terrains_have_the_walls_of_their_positions_and_parts_those_of_the_whole) {
    Random random(7);
    Terrain terrain{heights(random, 5, true), -0.25, {{-1, -1, -1}, {0.5, 0.5, 0.5}, {15, 15, 14}, {}}};
    DistanceTransform transform = below(terrain);
    const auto directions = stencil("D3Q19");
    transform.links(terrain.grid, directions);
    std::vector<Vec3> origins, along;
    set_rays(random, terrain.grid, origins, along);
    Hits4 found(origins.size()), expected(origins.size());
    transform.rays(origins, along, {}, found.targets());
    std::vector<Vec3> positions = terrain.mesh.vertices();
    for (Vec3& p : positions) p = {p[0] * 0.75, p[1] + 0.5, p[2] * 0.5 + 0.25};
    transform.set_positions(positions);
    terrain.mesh = Mesh(positions, terrain.mesh.triangles(), "moved");
    const DistanceTransform other = closed(terrain);
    check_links(terrain, transform.links(terrain.grid, directions), other.links(terrain.grid, directions));
    transform.rays(origins, along, {}, found.targets());
    other.rays(origins, along, {}, expected.targets());
    BOOST_TEST((found.t == expected.t));

    const Grid part = terrain.grid.part({4, 2, 3}, {5, 7, 4});
    const Box region = part.grown(1).box();
    const DistanceTransform restricted =
        transform.restrict_to({.box = region, .half_width = 0.1, .spacing = part.voxel()});
    check_links(terrain, restricted.links(part, directions), other.links(part, directions));
    const Field field = restricted.compute(part, Band::symmetric(0.1).with_exact_signs());
    BOOST_TEST((bits_of(field.distance()) ==
                bits_of(transform.compute(part, Band::symmetric(0.1).with_exact_signs()).distance())));
    const Grid on_floor{{-0.5, -0.5, -0.25}, {0.5, 0.5, 0.5}, {3, 3, 3}, {}};
    const DistanceTransform low =
        transform.restrict_to({.box = on_floor.grown(1).box(), .half_width = 0.1, .spacing = 0.5});
    check_throws(ErrorCode::invalid_argument, {"restricted", "floor", "z = -0.25"},
                 [&] { low.links(on_floor, directions); });
    const std::vector<Vec3> from{{0, 0, 0}}, down{{0, 0, -1}};
    std::vector<double> t(1);
    check_throws(ErrorCode::invalid_argument, {"restricted", "floor", "z = -0.25"},
                 [&] { low.rays(from, down, {.limit = 0.5}, {.t = t}); });
}

BOOST_AUTO_TEST_SUITE_END()
