// Rays and pairs of points with open meshes, whose film has walls without a triangle; and with restricted transforms.
#include "support/exact_field.hpp"
#include "support/hostile_meshes.hpp"
#include "support/open_meshes.hpp"
#include "support/random_meshes.hpp"
#include "support/throws.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

using namespace clsdf;
using namespace clsdf::test;

namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();
constexpr std::size_t most = 6;

struct Found {
    explicit Found(std::size_t rays) : t(most * rays), triangles(most * rays), counts(rays) {}
    std::vector<double> t;
    std::vector<std::uint32_t> triangles, counts;

    RayTargets targets() { return {.most = most, .t = t, .triangles = triangles, .counts = counts}; }
};

Vec3 on_ray(const Vec3& from, double t, const Vec3& along) {
    return {from[0] + t * along[0], from[1] + t * along[1], from[2] + t * along[2]};
}

std::vector<std::uint8_t> sides_of(const DistanceTransform& transform, const std::vector<Vec3>& points) {
    std::vector<double> windings(points.size());
    transform.winding(points, windings);
    std::vector<std::uint8_t> sides;
    for (const double winding : windings) sides.push_back(std::abs(winding) > 0.5 ? 1 : 0);
    return sides;
}

std::vector<Mesh> open_meshes() {
    return {open_box({1, 1, 1}, {7, 6, 5}, 5), tilted(open_box({-1, -1, -1}, {1, 1, 1}, 0)),
            round_mesh(6, 2, {1, 2, 3}, true, "half a ball")};
}

}  // namespace

BOOST_AUTO_TEST_SUITE(film_of_rays)

BOOST_AUTO_TEST_CASE(walls_of_open_meshes_are_the_changes_of_the_side) {
    const std::uint64_t seed = std::random_device{}();
    BOOST_TEST_MESSAGE("seed " << seed);
    Random random(seed);
    for (const Mesh& mesh : open_meshes()) BOOST_TEST_CONTEXT(mesh.name()) {
            const DistanceTransform transform(test_device(), mesh, {.sign = SignRule::solid_angle});
            const double side = mesh.box().longest_side();
            constexpr std::size_t count = 300, samples = 60;
            std::vector<Vec3> origins, directions;
            for (std::size_t i = 0; i < count; ++i) {
                Vec3 origin = random.point(-side, side), direction{};
                for (std::size_t axis = 0; axis < 3; ++axis) {
                    const double lower = mesh.box().lower[axis], upper = mesh.box().upper[axis];
                    origin[axis] += (lower + upper) / 2;
                    if (i % 10 == 0) origin[axis] = mesh.vertices()[i % mesh.vertices().size()][axis];
                    direction[axis] = (random.uniform(lower, upper) - origin[axis]) * 0.3;
                }
                origins.push_back(origin);
                directions.push_back(direction);
            }
            Found found(count);
            transform.rays(origins, directions, {}, found.targets());
            std::vector<Vec3> points, films, before_films, behind_films;
            std::vector<std::uint8_t> expected;
            std::size_t with_triangle = 0, odd = 0;
            for (std::size_t i = 0; i < count; ++i) {
                BOOST_REQUIRE(found.counts[i] <= most);
                const std::span<const double> t(found.t.data() + most * i, found.counts[i]);
                BOOST_TEST(std::ranges::is_sorted(t));
                odd += found.counts[i] % 2;
                for (std::size_t k = 0; k < t.size(); ++k) {
                    if (found.triangles[most * i + k] != no_triangle) {
                        ++with_triangle;
                    } else if (t[k] > 1e-6) {  // not at an open edge
                        films.push_back(on_ray(origins[i], t[k], directions[i]));
                        before_films.push_back(on_ray(origins[i], t[k] - 1e-7, directions[i]));
                        behind_films.push_back(on_ray(origins[i], t[k] + 1e-7, directions[i]));
                    }
                }
                for (std::size_t n = 0; n < samples; ++n) {
                    const double at = random.uniform(0.001, 10);
                    if (std::ranges::any_of(t, [at](double wall) { return std::abs(at - wall) < 1e-4; })) continue;
                    const auto behind = std::ranges::count_if(t, [at](double wall) { return wall > at; });
                    points.push_back(on_ray(origins[i], at, directions[i]));
                    expected.push_back(behind % 2 != 0 ? 1 : 0);
                }
            }
            const std::vector<std::uint8_t> sides = sides_of(transform, points);
            std::size_t wrong = 0;
            for (std::size_t i = 0; i < sides.size(); ++i) wrong += sides[i] != expected[i];
            BOOST_TEST(wrong == 0U, wrong << " of " << sides.size() << " samples are on another side");
            BOOST_TEST_MESSAGE(films.size() << " walls of the film");
            const std::vector<std::uint8_t> before = sides_of(transform, before_films),
                                            behind = sides_of(transform, behind_films);
            std::vector<double> windings(films.size());
            transform.winding(films, windings);
            // Where a ray is nearly in the film, roundings decide on both sides.
            for (std::size_t i = 0; i < films.size(); ++i)
                BOOST_TEST((before[i] != behind[i] || std::abs(std::abs(windings[i]) - 0.5) < 1e-6));
            BOOST_TEST(films.size() > 20U);
            BOOST_TEST(with_triangle > 20U);
            BOOST_TEST(odd > 0U);

            // The first hits alone, any, and limits find the same.
            std::vector<double> first(count);
            std::vector<std::uint32_t> triangles(count);
            std::vector<std::uint8_t> any(count);
            transform.rays(origins, directions, {}, {.t = first, .triangles = triangles});
            for (std::size_t i = 0; i < count; ++i) {
                BOOST_TEST(first[i] == found.t[most * i]);
                BOOST_TEST(triangles[i] == found.triangles[most * i]);
            }
            const double limit = 3;
            transform.rays(origins, directions, {.limit = limit}, {.any = any});
            std::vector<std::uint32_t> counts(count);
            transform.rays(origins, directions, {.limit = limit}, {.counts = counts});
            for (std::size_t i = 0; i < count; ++i) {
                const auto up_to = std::ranges::count_if(std::span(found.t.data() + most * i, found.counts[i]),
                                                         [&](double t) { return t <= limit; });
                BOOST_TEST(counts[i] == up_to);
                BOOST_TEST(any[i] == (up_to > 0 ? 1 : 0));
            }
        }
}

BOOST_AUTO_TEST_CASE(a_lamp_changes_no_side_of_the_body_that_it_stands_on) {
    constexpr std::uint64_t seed = 31;
    BOOST_TEST_MESSAGE("seed " << seed);
    Random random(seed);
    constexpr std::size_t none = 6;
    const Mesh body = open_box({0, 0, 0}, {10, 10, 10}, none);
    // Open edges lie on rows of samples, and so do walls that are parallel to x; winding numbers are 1 or 2.
    const std::array<Mesh, 3> bodies{body, together({body, open_box({1, -1, -1}, {12, 11, 11}, none)}, "two boxes"),
                                     together({body, open_box({-3, -1, -1}, {9, 11, 11}, none)}, "two other boxes")};
    const Grid grid{{-2, -2, -2}, {1, 0.5, 0.5}, {16, 31, 29}, {}};
    std::size_t different = 0, odd = 0, on_walls = 0;
    for (const Mesh& alone : bodies) {
        const SampleSides sides = DistanceTransform(test_device(), alone).crossings(grid).inside;
        for (std::size_t lamp_side = 0; lamp_side < 6; ++lamp_side) {
            const std::size_t axis = lamp_side / 2;
            Vec3 lower{4, 4, 4}, upper{5, 5, 5};
            lower[axis] = lamp_side % 2 == 0 ? 10 : -1;
            upper[axis] = lower[axis] + 1;
            const Mesh mesh = together({alone, open_box(lower, upper, lamp_side)}, alone.name() + " with a lamp");
            const DistanceTransform transform(test_device(), mesh, {.sign = SignRule::solid_angle});
            const SampleSides with_lamp = transform.crossings(grid).inside;
            std::vector<Vec3> origins, directions;
            std::vector<bool> are_inside;
            for (std::int64_t k = 0; k < grid.size[2]; ++k)
                for (std::int64_t j = 0; j < grid.size[1]; ++j)
                    for (std::int64_t i = 0; i < grid.size[0]; ++i) {
                        const Vec3 at = grid.position(i, j, k);
                        bool is_in_lamp = true, is_on_wall = false;
                        for (std::size_t n = 0; n < 3; ++n) {
                            is_in_lamp = is_in_lamp && at[n] >= lower[n] && at[n] <= upper[n];
                            is_on_wall = is_on_wall || at[n] == 0 || at[n] == 10;
                        }
                        if (is_in_lamp) continue;
                        different += sides.is_inside({i, j, k}) != with_lamp.is_inside({i, j, k}) ? 1U : 0U;
                        if (!is_on_wall || random.index(8) != 0) continue;
                        origins.push_back(at);
                        directions.push_back(random.direction());
                        are_inside.push_back(with_lamp.is_inside({i, j, k}));
                    }
            std::vector<std::uint32_t> counts(origins.size());
            transform.rays(origins, directions, {}, {.counts = counts});
            for (std::size_t n = 0; n < counts.size(); ++n) odd += (counts[n] % 2 == 1) != are_inside[n] ? 1U : 0U;
            on_walls += origins.size();
        }
    }
    BOOST_TEST(different == 0U);
    BOOST_TEST(odd == 0U);
    BOOST_TEST(on_walls > 1000U);
}

BOOST_AUTO_TEST_CASE(pairs_see_each_other_without_a_wall_of_faces_or_film_between) {
    const std::uint64_t seed = std::random_device{}();
    BOOST_TEST_MESSAGE("seed " << seed);
    Random random(seed);
    for (const Mesh& mesh : open_meshes()) BOOST_TEST_CONTEXT(mesh.name()) {
            const DistanceTransform transform(test_device(), mesh, {.sign = SignRule::solid_angle});
            constexpr std::size_t count = 200, samples = 64;
            std::vector<Vec3> from, to, points;
            for (std::size_t i = 0; i < count; ++i)
                for (std::vector<Vec3>* ends : {&from, &to}) {
                    Vec3 p{};
                    for (std::size_t axis = 0; axis < 3; ++axis)
                        p[axis] = random.uniform(mesh.box().lower[axis] - 0.5, mesh.box().upper[axis] + 1);
                    ends->push_back(p);
                }
            for (std::size_t i = 0; i < count; ++i)
                for (std::size_t n = 0; n < samples; ++n) {
                    Vec3 p{};
                    const double part = static_cast<double>(n) / (samples - 1);
                    for (std::size_t axis = 0; axis < 3; ++axis)
                        p[axis] = from[i][axis] + part * (to[i][axis] - from[i][axis]);
                    points.push_back(p);
                }
            std::vector<std::uint8_t> visible(count), reverse(count);
            transform.visible(from, to, visible);
            transform.visible(to, from, reverse);
            BOOST_TEST((visible == reverse));
            const std::vector<std::uint8_t> sides = sides_of(transform, points);
            std::size_t wrong = 0, hidden = 0;
            for (std::size_t i = 0; i < count; ++i) {
                const std::span<const std::uint8_t> on_way(sides.data() + samples * i, samples);
                const bool has_change = std::ranges::adjacent_find(on_way, std::ranges::not_equal_to{}) != on_way.end();
                hidden += has_change;
                wrong += has_change && visible[i] == 1;  // a pair of walls may lie between two samples
            }
            BOOST_TEST(wrong == 0U);
            BOOST_TEST(hidden > 10U);
            BOOST_TEST(std::ranges::count(visible, 0) < static_cast<std::ptrdiff_t>(hidden + count / 10));
        }
}

BOOST_AUTO_TEST_CASE(rays_within_a_region_are_those_of_the_whole_transform) {
    const std::uint64_t seed = std::random_device{}();
    BOOST_TEST_MESSAGE("seed " << seed);
    Random random(seed);
    const Mesh mesh = tilted(make_shape("knot"));
    const DistanceTransform transform(test_device(), mesh);
    const Box all = mesh.box();
    Region region{.box = {}, .half_width = 1e-9, .spacing = 0};
    for (std::size_t axis = 0; axis < 3; ++axis) {
        region.box.lower[axis] = all.lower[axis] + 0.3 * (all.upper[axis] - all.lower[axis]);
        region.box.upper[axis] = all.lower[axis] + 0.8 * (all.upper[axis] - all.lower[axis]);
    }
    const DistanceTransform part = transform.restrict_to(region);
    constexpr std::size_t count = 1000;
    const double limit = 0.25;
    std::vector<Vec3> from, to, along;
    for (std::size_t i = 0; i < count; ++i) {
        Vec3 a{}, b{}, d{};
        for (std::size_t axis = 0; axis < 3; ++axis) {
            const double lower = region.box.lower[axis], upper = region.box.upper[axis], inner = 1e-9 * (upper - lower);
            a[axis] = random.uniform(lower + inner, upper - inner);
            b[axis] = random.uniform(lower + inner, upper - inner);
            d[axis] = (b[axis] - a[axis]) / limit;
        }
        from.push_back(a);
        to.push_back(b);
        along.push_back(d);
    }
    for (const Hits hits : {Hits::walls, Hits::faces}) {
        Found found(count), expected(count);
        part.rays(from, along, {hits, limit}, found.targets());
        transform.rays(from, along, {hits, limit}, expected.targets());
        BOOST_TEST((found.t == expected.t));
        BOOST_TEST((found.triangles == expected.triangles));
        BOOST_TEST((found.counts == expected.counts));
        BOOST_TEST(std::ranges::count_if(found.counts, [](std::uint32_t n) { return n > 0; }) > 50);
        std::vector<std::uint8_t> visible(count), of_whole(count);
        part.visible(from, to, visible, hits);
        transform.visible(from, to, of_whole, hits);
        BOOST_TEST((visible == of_whole));
    }
    std::vector<double> t(1);
    std::vector<std::uint8_t> seen(1);
    const std::vector<Vec3> one{from[0]}, far{{100, 0, 0}}, x{{1, 0, 0}};
    check_throws(ErrorCode::invalid_argument, {"no limit", "restricted"}, [&] { part.rays(one, x, {}, {.t = t}); });
    check_throws(ErrorCode::invalid_argument, {"ray 0", "restricted", "region"},
                 [&] { part.rays(one, x, {.limit = 100}, {.t = t}); });
    check_throws(ErrorCode::invalid_argument, {"pair 0", "restricted", "region"},
                 [&] { part.visible(one, far, seen); });
    const Mesh open = open_box({1, 1, 1}, {7, 6, 5}, 5);
    const DistanceTransform of_open = DistanceTransform(test_device(), open, {.sign = SignRule::solid_angle})
                                          .restrict_to({{{2, 2, 2}, {3, 3, 3}}, 0.5, 0});
    const std::vector<Vec3> within{{2.5, 2.5, 2.5}};
    check_throws(ErrorCode::unsupported, {"open edges", "restricted"},
                 [&] { of_open.rays(within, x, {.limit = 0.25}, {.t = t}); });
}

BOOST_AUTO_TEST_SUITE_END()
