#include "support/exact_field.hpp"
#include "support/float_width.hpp"
#include "support/hostile_meshes.hpp"
#include "support/shared_lists.hpp"
#include "support/test_meshes.hpp"

#include "layout.h"

#include <clsdf/tuning.hpp>

#include <algorithm>
#include <cmath>

using namespace clsdf;
using namespace clsdf::test;

namespace {

void check_agreement(const Field& one, const Field& other) {
    const double voxel = one.grid.voxel();
    for (std::size_t i = 0; i < one.distance().size(); ++i) {
        const double a = one.distance()[i], b = other.distance()[i];
        const double ulp = std::abs(a) * 0x1p-23;
        BOOST_REQUIRE(std::abs(a - b) <= std::max(2 * guaranteed.voxels * voxel, 2 * guaranteed.ulp * ulp));
        BOOST_REQUIRE((std::signbit(a) == std::signbit(b) || std::abs(a) < guaranteed.voxels * voxel));
    }
}

/// A field by the group body is exact, and agrees with that of the vector body.
void check_by_group(const Mesh& mesh, const Grid& grid, const Band& band, const Accuracy& accuracy = guaranteed) {
    const Field field = compute(mesh, grid, band, KernelBody::by_group);
    BOOST_TEST(check_exact(mesh, field, accuracy).band_samples > 0U);
    check_agreement(field, compute(mesh, grid, band, KernelBody::by_vector));
}

}  // namespace

BOOST_AUTO_TEST_CASE(groups_compute_every_counterexample_exactly) {
    for (const Counterexample& example : all_counterexamples()) {
        const Band band = Band::symmetric(example.half_width);
        check_by_group(example.mesh, Grid::around(example.mesh, 26, band), band);
        const Vec3& known = example.samples.front().position;
        check_by_group(example.mesh, grid_at(known, example.half_width / 8, 7), band);
    }
}

BOOST_AUTO_TEST_CASE(groups_compute_shapes_exactly) {
    for (const char* name : {"torus", "seashell", "stairs", "needle", "nested", "noisy"}) {
        const Mesh mesh = make_shape(name);
        const Grid grid = grid_around(mesh, 28, 3);
        check_by_group(mesh, grid, Band{2 * grid.voxel(), 3 * grid.voxel()});
    }
    const Mesh knot = tilted(make_shape("knot"));
    check_by_group(knot, grid_around(knot, 24, 2), Band::full());
}

// A list longer than a group's memory holds at a time.
BOOST_AUTO_TEST_CASE(groups_compute_long_lists_exactly) {
    const Mesh mesh = scaled(make_shape("sphere4"), 5);
    check_by_group(mesh, grid_at({0, 0, 0}, 1, 10), Band::symmetric(4));
}

// Eight groups share the list. Every triangle is there twice, and the first one is named.
BOOST_AUTO_TEST_CASE(groups_share_long_lists) {
    const Mesh once = scaled(make_shape("sphere5"), 5);
    std::vector<Triangle> triangles = once.triangles();
    triangles.insert(triangles.end(), once.triangles().begin(), once.triangles().end());
    const Mesh twice(once.vertices(), triangles, "sphere twice");
    const Grid grid = grid_at({0, 0, 0}, 1, 10);
    const Band band = Band::symmetric(3);
    check_by_group(twice, grid, band);

    const DistanceTransform transform(test_device(), twice, {.body = KernelBody::by_group});
    const Field whole = transform.compute(grid, band, all_outputs());
    BOOST_TEST(std::ranges::none_of(whole.triangle(),
                                    [&](std::uint32_t t) { return t != no_triangle && t >= once.triangles().size(); }));
    BOOST_TEST((bits_of(transform.compute(grid, band).distance()) == bits_of(whole.distance())));
    // The second part is far from most triangles: its list is shorter, and has fewer shares.
    for (const Grid& part : {grid.part({4, 9, 2}, {7, 3, 12}), grid.part({16, 8, 8}, {5, 5, 5})}) {
        const Field expected = part_of(whole, part);
        BOOST_TEST(same_bytes(transform.compute(part, band, all_outputs()), expected));
        const DistanceTransform near = transform.restrict_to({part.box(), band.outside, grid.voxel()});
        BOOST_TEST(same_bytes(near.compute(part, band, all_outputs()), expected));
    }
    TransformStatistics counted;
    const Field again = transform.compute(grid, band, {}, {.count_work = true}, &counted);
    const auto in_band = std::ranges::count_if(whole.triangle(), [](std::uint32_t t) { return t != no_triangle; });
    BOOST_TEST(counted.work->band_samples == static_cast<std::size_t>(in_band));
    BOOST_TEST((bits_of(again.distance()) == bits_of(whole.distance())));
}

// Eight lists of eight shares each; the second device has room for the minima of one list at a time.
BOOST_AUTO_TEST_CASE(groups_share_lists_one_after_the_other_if_memory_is_short) {
    const Mesh mesh = tilted(make_shape("sphere2"));
    Grid grid = grid_at({0, 0, 0}, 0.1, 12);
    grid.first = {-12, -12, -12};  // the middle one is at a corner of coarse bricks
    grid.origin = {0, 0, 0};
    const Band band = Band::symmetric(0.3);
    const Field field = DistanceTransform(test_device(), mesh, {.body = KernelBody::by_group}).compute(grid, band);
    check_exact(mesh, field, guaranteed);
    for (const std::size_t allocation : {std::size_t{1} << 28, std::size_t{1} << 20})
        BOOST_TEST((bits_of(distances_by_shares(with_largest_allocation(allocation), mesh, grid, band)) ==
                    bits_of(field.distance())));
}

BOOST_AUTO_TEST_CASE(groups_compute_large_triangles_and_unequal_spacing_exactly) {
    const Mesh large({{0.3, -0.2, 0.4}, {8e5, 3e5, 5e5}, {-2e5, 6e5, 7e5}}, {{0, 1, 2}}, "large triangle");
    check_by_group(large, grid_at({0, 0, 0}, 1, 6), Band::symmetric(3), aimed);
    const Mesh torus = tilted(make_shape("torus"));
    Grid grid = grid_around(torus, 30, 2);
    grid.spacing[2] *= 9;
    grid.size[2] = 4;
    check_by_group(torus, grid, Band::symmetric(3 * grid.voxel()), aimed);
}

// Processors of 256 bits compute eight samples at a time, narrower ones as well.
BOOST_AUTO_TEST_CASE(vectors_of_eight_compute_exactly) {
    for (const unsigned width : {8U, 4U}) {
        const Device narrow = with_float_width(width);
        const auto check = [&](const Mesh& mesh, const Grid& grid, const Band& band, bool count = false) {
            DistanceTransform transform(narrow, mesh, {.body = KernelBody::by_vector});
            const Field field = transform.compute(grid, band, Output::triangle, {.count_work = count});
            BOOST_TEST(check_exact(mesh, field, guaranteed).band_samples > 0U);
            check_agreement(field, compute(mesh, grid, band));
            Grid part = grid.part({3, 5, 1}, {grid.size[0] - 6, grid.size[1] - 5, grid.size[2] - 3});
            check_exact(mesh, transform.compute(part, band), guaranteed);
        };
        for (const Counterexample& example : all_counterexamples()) {
            const Band band = Band::symmetric(example.half_width);
            check(example.mesh, Grid::around(example.mesh, 36, band), band);
        }
        const Mesh knot = tilted(make_shape("knot"));
        check(knot, grid_around(knot, 36, 3), Band::full(), true);
        Grid grid = grid_around(knot, 60, 2);
        grid.spacing[0] *= 5;
        grid.size[0] = 12;
        check(knot, grid, Band::symmetric(3 * grid.voxel()));
    }
}

// Lists of coarse bricks that are taken in parts, between which minima wait in memory.
BOOST_AUTO_TEST_CASE(vectors_compute_long_lists_exactly) {
    const Mesh mesh = tilted(make_shape("sphere6"));
    const Grid grid = grid_around(mesh, 40, 3);
    for (const Band& band : {Band::symmetric(2.5 * grid.voxel()), Band::full()}) {
        const Field field = compute(mesh, grid, band, KernelBody::by_vector);
        BOOST_TEST(check_exact(mesh, field, guaranteed).band_samples > 0U);
        DistanceTransform narrow(with_float_width(8), mesh, {.body = KernelBody::by_vector});
        TransformStatistics statistics;
        const Field by_eight = narrow.compute(grid, band, Output::triangle, {.count_work = true}, &statistics);
        check_exact(mesh, by_eight, guaranteed);
        check_agreement(field, by_eight);
        BOOST_TEST(statistics.work->coarse_pairs > CLSDF_LIST_PART * statistics.work->coarse_bricks);
    }
}

// Each polyhedron is in the list of every coarse brick that has a sample of it.
BOOST_AUTO_TEST_CASE(soups_over_many_coarse_bricks_are_exact_by_every_body) {
    for (const unsigned seed : {1U, 2U}) BOOST_TEST_CONTEXT("seed " << seed) {
            Random random(seed);
            const Mesh mesh = seed % 2 == 0 ? random_sphere(random, "sphere2", 0.2) : random_soup(random, 60, 80);
            Grid grid;
            grid.size = {70, 90, 80};
            for (std::size_t axis = 0; axis < 3; ++axis) {
                grid.spacing[axis] = random.uniform(1, 1.5) * mesh.box().longest_side() / 64;
                grid.first[axis] = static_cast<std::int64_t>(random.index(200)) - 100;
                grid.origin[axis] =
                    mesh.box().lower[axis] - grid.spacing[axis] * static_cast<double>(grid.first[axis] + 7);
            }
            for (const Band& band :
                 {Band::symmetric(3 * grid.voxel()), Band::symmetric(12 * grid.voxel()), Band::full()}) {
                std::vector<Field> fields;
                for (const unsigned width : {16U, 8U})
                    fields.push_back(DistanceTransform(with_float_width(width), mesh, {.body = KernelBody::by_vector})
                                         .compute(grid, band));
                fields.push_back(
                    DistanceTransform(test_device(), mesh, {.body = KernelBody::by_group}).compute(grid, band));
                for (const reference::CheckReport& report : reference::check(mesh, fields)) BOOST_TEST(report.passed());
            }
        }
}
