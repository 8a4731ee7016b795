// Meshes with open edges: the sign by the winding number, with the rule solid_angle (docs/sign.md).

#include "support/open_meshes.hpp"
#include "support/exact_field.hpp"
#include "support/throws.hpp"

#include <clsdf/tuning.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>
#include <string>
#include <vector>

using namespace clsdf;
using namespace clsdf::test;

namespace {

constexpr TransformOptions by_solid_angle{.sign = SignRule::solid_angle};

std::vector<KernelBody> bodies() {
    if (!is_processor()) return {KernelBody::automatic};
    return {KernelBody::by_vector, KernelBody::by_group};
}

Grid lattice_of(std::int64_t size, const Vec3& spacing = {1, 1, 1}) {
    Grid grid;
    grid.spacing = spacing;
    grid.size = {size, size, size};
    return grid;
}

Mesh shaken(const Mesh& mesh, double length, Random& random) {
    return moved(mesh, [&](const Vec3& p) { return along(p, length * random.uniform(-1, 1), random.direction()); });
}

/// The contract of docs/accuracy.md, but for points beside open edges.
struct Signs {
    std::size_t wrong = 0, certain = 0, inside = 0;

    void add(const Mesh& mesh, const Vec3& point, double distance, double least_distance) {
        const double winding = winding_by_faces(mesh, point);
        if (std::abs(std::abs(winding) - 0.5) <= 1e-8 || std::abs(distance) <= least_distance) return;
        ++certain;
        const bool is_inside = std::abs(winding) > 0.5;
        inside += is_inside ? 1U : 0U;
        if (is_inside == std::signbit(distance)) return;
        if (++wrong < 4)
            BOOST_TEST_MESSAGE("  (" << point[0] << ", " << point[1] << ", " << point[2] << "): w " << winding
                                     << ", distance " << distance);
    }
};

Signs signs_of(const Mesh& mesh, const Field& field) {
    Signs signs;
    const std::vector<Vec3> samples = samples_of(field.grid);
    for (std::size_t i = 0; i < samples.size(); ++i)
        signs.add(mesh, samples[i], static_cast<double>(field.distance()[i]), 1e-6 * field.grid.voxel());
    return signs;
}

std::vector<float> winding_of(const DistanceTransform& transform, std::span<const Vec3> points) {
    std::vector<float> results(points.size());
    transform.winding(points, results);
    return results;
}

}  // namespace

BOOST_AUTO_TEST_CASE(samples_have_the_sign_of_the_solid_angles) {
    for (const KernelBody body : bodies())
        for (const Mesh& mesh : open_meshes(1)) BOOST_TEST_CONTEXT(mesh.name()) {
                const Field field = compute(mesh, lattice_of(15), Band::full(),
                                            TransformOptions{.sign = SignRule::solid_angle, .body = body});
                const Signs signs = signs_of(mesh, field);
                BOOST_TEST(signs.wrong == 0U);
                BOOST_TEST(signs.certain > 2000U);
                BOOST_TEST(signs.inside > 0U);
                BOOST_TEST(name_of(field.sign) == "solid-angle");
            }
}

BOOST_AUTO_TEST_CASE(vertices_beside_rows_of_samples_take_nothing_away) {
    constexpr std::uint64_t seed = 5;
    BOOST_TEST_MESSAGE("seed " << seed);
    Random random(seed);
    for (const double length : {1e-5, 2e-6, 1e-6, 5e-7, 1e-7, 1e-9})
        for (int i = 0; i < 3; ++i) {
            const Mesh mesh =
                shaken(i == 0 ? triangle_soup(16, true, random) : open_box({3, 3, 3}, {10, 9, 8}, random.index(6)),
                       length, random);
            BOOST_TEST_CONTEXT(mesh.name() << ", moved by " << length) {
                BOOST_TEST(signs_of(mesh, compute(mesh, lattice_of(14), Band::full(), by_solid_angle)).wrong == 0U);
            }
        }
}

// Samples of a block with so many loops near it are looked at one by one.
BOOST_AUTO_TEST_CASE(samples_among_hundreds_of_loops_have_the_sign_of_the_solid_angles) {
    constexpr std::uint64_t seed = 7;
    BOOST_TEST_MESSAGE("seed " << seed);
    Random random(seed);
    const Mesh mesh = triangle_soup(900, false, random);
    const Signs signs = signs_of(mesh, compute(mesh, lattice_of(15), Band::full(), by_solid_angle));
    BOOST_TEST(signs.wrong == 0U);
    BOOST_TEST(signs.inside > 100U);
    BOOST_TEST(signs.certain > signs.inside + 100);
}

BOOST_AUTO_TEST_CASE(spacings_may_be_unequal_and_lattices_far_away) {
    for (const Mesh& mesh : {cracked_box(), round_mesh(6, 5, {6, 6, 6}, true, "half sphere")}) {
        const Field unequal = compute(mesh, lattice_of(20, {0.75, 0.5, 1.25}), Band::full(), by_solid_angle);
        BOOST_TEST(signs_of(mesh, unequal).wrong == 0U);
        Grid grid = lattice_of(15);
        const Mesh far = shifted(mesh, {0x1p30, -0x1p31, 0x1p30});
        grid.origin = {0x1p30, -0x1p31, 0x1p30};
        BOOST_TEST(signs_of(far, compute(far, grid, Band::full(), by_solid_angle)).wrong == 0U);
        grid.origin = {0, 0, 0};
        grid.first = {1 << 27, -(1 << 27), 1 << 27};
        const Mesh at_far_samples = shifted(mesh, {0x1p27, -0x1p27, 0x1p27});
        BOOST_TEST(signs_of(at_far_samples, compute(at_far_samples, grid, Band::full(), by_solid_angle)).wrong == 0U);
    }
}

BOOST_AUTO_TEST_CASE(points_have_the_sign_of_the_solid_angles_and_few_the_bytes_of_many) {
    constexpr std::uint64_t seed = 3;
    BOOST_TEST_MESSAGE("seed " << seed);
    Random random(seed);
    for (const Mesh& mesh : open_meshes(2)) BOOST_TEST_CONTEXT(mesh.name()) {
            std::vector<Vec3> points;
            for (int i = 0; i < 250; ++i) points.push_back(random.point(-2, 16));
            for (int i = 0; i < 100; ++i) {  // planes and shadows
                Vec3 point = random.point(0, 14);
                for (double& x : point) x = std::floor(x);
                points.push_back(point);
            }
            for (int i = 0; i < 200; ++i) {  // beside edges, and behind them
                const Triangle& triangle = mesh.triangles()[random.index(mesh.triangles().size())];
                const Vec3 &a = mesh.vertices()[triangle[0]], &b = mesh.vertices()[triangle[1]];
                const double share = std::round(8 * random.uniform(0, 1)) / 8;
                Vec3 point{};
                for (std::size_t axis = 0; axis < 3; ++axis) point[axis] = a[axis] + share * (b[axis] - a[axis]);
                if (i % 2 == 0) point = along(point, std::pow(10, random.uniform(-7, 0)), random.direction());
                if (i % 4 == 1) point[0] += std::round(random.uniform(1, 8)) / 4;
                if (i % 4 == 3) {
                    point[0] += random.uniform(0.1, 3);
                    point[1] += std::pow(10, random.uniform(-16, -2));
                }
                points.push_back(point);
            }
            for (int i = 0; i < 10; ++i) points.push_back(along({6, 6, 6}, i % 2 == 0 ? 1e6 : 1e3, random.direction()));
            const DistanceTransform transform(test_device(), mesh, by_solid_angle);
            const Field many = query(transform, points);
            Signs signs;
            for (std::size_t i = 0; i < points.size(); ++i)
                signs.add(mesh, points[i], static_cast<double>(many.distance()[i]), 1e-6 * 8 / 256);
            BOOST_TEST(signs.wrong == 0U);
            BOOST_TEST(signs.inside > 0U);
            std::size_t different = 0;
            for (std::size_t begin = 0; begin < points.size(); begin += 50) {
                const auto some = std::span(points).subspan(begin, std::min<std::size_t>(50, points.size() - begin));
                const Field few = query(transform, some);
                for (std::size_t i = 0; i < some.size(); ++i)
                    different += std::bit_cast<std::uint32_t>(few.distance()[i]) !=
                                         std::bit_cast<std::uint32_t>(many.distance()[begin + i])
                                     ? 1U
                                     : 0U;
            }
            BOOST_TEST(different == 0U);
        }
}

BOOST_AUTO_TEST_CASE(points_on_a_line_through_the_film_have_the_same_sign_together_and_alone) {
    const Mesh mesh = round_mesh(6, 5, {6, 6, 6}, true, "half sphere");
    std::vector<Vec3> points;
    for (int i = 0; i <= 400; ++i) points.push_back({5.3, 6.4, 2 + 0.02 * i});
    const DistanceTransform transform(test_device(), mesh, by_solid_angle);
    const Field together = query(transform, points);
    std::size_t changes = 0;
    for (std::size_t i = 0; i < points.size(); ++i) {
        const Field alone = query(transform, std::span(points).subspan(i, 1));
        BOOST_TEST(alone.distance()[0] == together.distance()[i]);
        if (i > 0)
            changes += std::signbit(together.distance()[i]) != std::signbit(together.distance()[i - 1]) ? 1U : 0U;
    }
    BOOST_TEST(changes == 1U);  // the film; the surface lies farther up
}

BOOST_AUTO_TEST_CASE(points_near_each_other_have_the_sign_of_the_solid_angles_and_few_the_bytes_of_many) {
    constexpr std::uint64_t seed = 12;
    BOOST_TEST_MESSAGE("seed " << seed);
    Random random(seed);
    const Mesh sphere = round_mesh(20, 5, {6.5, 6.5, 6.5}, false, "sphere");
    for (const double share : {0.02, 0.33}) {
        const Mesh mesh =
            with_chosen_faces(sphere, "sphere with holes", [&](std::size_t) { return random.uniform(0, 1) > share; });
        std::vector<Vec3> points;
        for (int cloud = 0; cloud < 40; ++cloud) {
            const Vec3 middle = random.point(0, 13);
            for (int i = 0; i < 50; ++i)
                points.push_back(along(middle, std::pow(10, random.uniform(-3, 0.5)), random.direction()));
        }
        const DistanceTransform transform(test_device(), mesh, by_solid_angle);
        const Field many = query(transform, points);
        Signs signs;
        std::size_t different = 0;
        for (std::size_t i = 0; i < points.size(); ++i) {
            signs.add(mesh, points[i], static_cast<double>(many.distance()[i]), 1e-6 * 8 / 256);
            const Field alone = query(transform, std::span(points).subspan(i, 1));
            different += std::signbit(alone.distance()[0]) != std::signbit(many.distance()[i]) ? 1U : 0U;
        }
        BOOST_TEST(signs.wrong == 0U);
        BOOST_TEST(signs.inside > 100U);
        BOOST_TEST(different == 0U);
    }
}

BOOST_AUTO_TEST_CASE(parts_slabs_and_restricted_transforms_have_the_bytes_of_the_whole) {
    std::vector<Mesh> meshes = open_meshes(4);
    for (const Mesh& mesh : meshes) BOOST_TEST_CONTEXT(mesh.name()) {
            Grid grid = lattice_of(40, {0.35, 0.35, 0.35});
            const Band band = Band::symmetric(1.5);
            const DistanceTransform transform(test_device(), mesh, by_solid_angle);
            const Field whole = transform.compute(grid, band, all_outputs());
            for (const Index3& first : {Index3{0, 0, 0}, Index3{17, 3, 9}, Index3{22, 21, 5}}) {
                const Grid part = grid.part(first, {17, 13, 18});
                BOOST_TEST(same_bytes(transform.compute(part, band, all_outputs()), part_of(whole, part)));
                Region region;
                region.box = part.box();
                region.half_width = 1.5;
                region.spacing = 0.35;
                const DistanceTransform restricted = transform.restrict_to(region);
                BOOST_TEST(same_bytes(restricted.compute(part, band, all_outputs()), part_of(whole, part)));
                const std::vector<Vec3> points = samples_of(part);
                BOOST_TEST(same_bytes(query(restricted, points, 1.5), query(transform, points, 1.5)));
            }
        }
}

BOOST_AUTO_TEST_CASE(a_box_that_is_inside_or_outside_has_no_point_of_another_sign) {
    constexpr std::uint64_t seed = 9;
    BOOST_TEST_MESSAGE("seed " << seed);
    Random random(seed);
    std::size_t inside = 0, outside = 0;
    for (const Mesh& mesh : open_meshes(5)) BOOST_TEST_CONTEXT(mesh.name()) {
            std::vector<Box> boxes;
            for (int i = 0; i < 400; ++i) {
                const Vec3 lower = random.point(0, 14);
                const double side = std::pow(10, random.uniform(-3, 0.6));
                boxes.push_back({lower, {lower[0] + side, lower[1] + side, lower[2] + side}});
            }
            const DistanceTransform transform(test_device(), mesh, by_solid_angle);
            std::vector<BoxPlace> places(boxes.size());
            transform.classify(boxes, 0, places);
            for (std::size_t i = 0; i < boxes.size(); ++i) {
                if (places[i] == BoxPlace::within) continue;
                inside += places[i] == BoxPlace::inside ? 1U : 0U;
                outside += places[i] == BoxPlace::outside ? 1U : 0U;
                for (int k = 0; k < 9; ++k) {
                    Vec3 point{};
                    for (std::size_t axis = 0; axis < 3; ++axis)
                        point[axis] = k == 8 ? random.uniform(boxes[i].lower[axis], boxes[i].upper[axis])
                                      : (k >> axis) % 2 == 0 ? boxes[i].lower[axis]
                                                             : boxes[i].upper[axis];
                    const bool is_inside = std::abs(winding_by_faces(mesh, point)) >= 0.5;
                    BOOST_TEST(is_inside == (places[i] == BoxPlace::inside));
                }
            }
        }
    BOOST_TEST(inside > 200U);
    BOOST_TEST(outside > 2000U);
}

BOOST_AUTO_TEST_CASE(a_balanced_mesh_has_the_bytes_of_the_rule_nonzero) {
    for (const Mesh& mesh : {box({3, 3, 3}, {10, 9, 8}), overlapping_cubes(), reversed(cube(2)),
                             round_mesh(8, 5, {6.5, 6.5, 6.5}, false, "sphere")}) {
        const Grid grid = grid_around(mesh, 24, 3);
        const Band band = Band::symmetric(3 * grid.voxel());
        const DistanceTransform one(test_device(), mesh, by_solid_angle),
            other(test_device(), mesh, {.sign = SignRule::nonzero});
        BOOST_TEST(same_bytes(one.compute(grid, band, all_outputs()), other.compute(grid, band, all_outputs())));
        const std::vector<Vec3> points = samples_of(grid);
        BOOST_TEST(same_bytes(query(one, points), query(other, points)));
        BOOST_TEST(one.topology().tested_points == 0U);
    }
}

BOOST_AUTO_TEST_CASE(automatic_takes_the_rule_if_the_winding_number_is_clear) {
    const auto sign_of = [](const Mesh& mesh, std::string& warning) {
        CallOptions call;
        call.log = [&](const std::string& message) { warning = message; };
        return DistanceTransform(test_device(), mesh, {}, call).sign();
    };
    const Mesh sphere = round_mesh(16, 5, {6.5, 6.5, 6.5}, false, "sphere");
    const Mesh holed = with_chosen_faces(sphere, "holed sphere", [](std::size_t i) { return i != 100 && i != 101; });
    std::string warning;
    for (const Mesh& mesh : {holed, reversed(holed), cracked_box()}) {
        BOOST_TEST_CONTEXT(mesh.name()) {
            BOOST_TEST(name_of(sign_of(mesh, warning)) == "solid-angle");
            const Topology topology = describe_topology(mesh);
            BOOST_TEST(topology.tested_points == 1024U);
            BOOST_TEST(10 * topology.doubtful_points <= 1024U);
            BOOST_TEST(topology.inside_points > 100U);
            BOOST_TEST(topology.inside_out ==
                       (mesh.name() == reversed(holed).name() && warning.find("inside out") != std::string::npos));
            for (const std::string& words :
                 {std::to_string(topology.open_edges), std::string("% of 1024 points"), std::string("none")})
                BOOST_TEST(warning.find(words) != std::string::npos, warning << " lacks " << words);
        }
    }
    const Mesh sheet({{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}}, {{0, 1, 2}, {0, 2, 3}}, "sheet");
    const Mesh terrain({{0, 0, 0}, {2, 0, 1}, {2, 2, 0}, {0, 2, 1}, {1, 1, 2}},
                       {{0, 1, 4}, {1, 2, 4}, {2, 3, 4}, {3, 0, 4}}, "terrain");
    for (const Mesh& mesh : {sheet, terrain, open_box({3, 3, 3}, {10, 9, 8}, 5)}) {
        BOOST_TEST_CONTEXT(mesh.name()) {
            BOOST_TEST(name_of(sign_of(mesh, warning)) == "none");
            BOOST_TEST(warning.find("solid-angle") == std::string::npos, warning);
            BOOST_TEST(warning.find("close the surface") != std::string::npos, warning);
        }
    }
}

BOOST_AUTO_TEST_CASE(winding_numbers_are_those_of_the_solid_angles) {
    constexpr std::uint64_t seed = 11;
    BOOST_TEST_MESSAGE("seed " << seed);
    Random random(seed);
    for (const SignRule rule : {SignRule::solid_angle, SignRule::none})
        for (const Mesh& mesh : open_meshes(6)) {
            std::vector<Vec3> points;
            for (int i = 0; i < 100; ++i) points.push_back(random.point(0, 14));
            points.push_back({std::numeric_limits<double>::quiet_NaN(), 0, 0});
            points.push_back({1e300, 0, 0});
            const DistanceTransform transform(test_device(), mesh, {.sign = rule});
            const std::vector<float> results = winding_of(transform, points);
            std::vector<double> wide(points.size());
            transform.winding(points, wide);
            for (std::size_t i = 0; i < 100; ++i) {
                BOOST_TEST(std::abs(wide[i] - winding_by_faces(mesh, points[i])) < 1e-13);
                BOOST_TEST(results[i] == static_cast<float>(wide[i]));
            }
            BOOST_TEST(std::isnan(results[100]));
            BOOST_TEST(results[101] == 0);
        }
}

BOOST_AUTO_TEST_CASE(a_mesh_that_moves_has_the_sign_of_its_new_positions) {
    const Mesh mesh = open_box({3, 3, 3}, {10, 9, 8}, 1);
    const Mesh moved = shifted(tilted(mesh), {0.3, 1, -0.2});
    const Band band = Band::symmetric(2);
    DistanceTransform transform(test_device(), mesh, by_solid_angle);
    transform.compute(lattice_of(15), band);
    query(transform, samples_of(lattice_of(3)));
    transform.set_positions(moved.vertices());
    const DistanceTransform fresh(test_device(), moved, by_solid_angle);
    BOOST_TEST(same_bytes(transform.compute(lattice_of(15), band), fresh.compute(lattice_of(15), band)));
    const std::vector<Vec3> points = samples_of(lattice_of(15));
    BOOST_TEST(same_bytes(query(transform, points), query(fresh, points)));
    BOOST_TEST(winding_of(transform, points) == winding_of(fresh, points), boost::test_tools::per_element());
}

BOOST_AUTO_TEST_CASE(winding_numbers_are_found_in_steps_and_can_be_stopped) {
    const DistanceTransform transform(test_device(), without_triangle(make_shape("sphere4"), 7));
    const std::vector<Vec3> points(3000, Vec3{0.1, 0.2, 0.3});
    std::vector<double> results(points.size());
    std::vector<double> fractions;
    CallOptions call;
    call.progress = [&](const Progress& progress) { fractions.push_back(progress.fraction); };
    transform.winding(points, results, call);
    BOOST_TEST(fractions.size() > 3U);
    BOOST_TEST(std::ranges::is_sorted(fractions));
    BOOST_TEST(fractions.back() == 1.0);
    call.should_stop = [&] { return fractions.size() > 8; };
    check_throws(ErrorCode::cancelled, {}, [&] { transform.winding(points, results, call); });
    BOOST_TEST(fractions.size() < 12U);
}

BOOST_AUTO_TEST_CASE(the_reference_finds_nothing_wrong) {
    for (const Mesh& mesh : open_meshes(7)) {
        check_exact(mesh, compute(mesh, lattice_of(15), Band::symmetric(2), by_solid_angle), guaranteed);
    }
}
