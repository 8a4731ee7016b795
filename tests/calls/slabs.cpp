#include "support/exact_field.hpp"
#include "support/hostile_meshes.hpp"
#include "support/throws.hpp"

#include "coarse.h"

#include <clsdf/tuning.hpp>

#include <algorithm>

using namespace clsdf;
using namespace clsdf::test;

namespace {

const Mesh& mesh() {
    static const Mesh shape = [] {
        Random random(5);
        return random_sphere(random, "sphere3", 0.2);
    }();
    return shape;
}

Grid around_mesh(std::int64_t first_z) {
    Grid grid = grid_around(mesh(), 84, 4);
    grid.origin[2] -= grid.spacing[2] * static_cast<double>(first_z);
    grid.first[2] = first_z;
    return grid;
}

std::size_t slice_bytes(const Grid& grid, std::size_t sample_bytes) {
    return static_cast<std::size_t>(grid.size[0] * grid.size[1]) * sample_bytes;
}

}  // namespace

BOOST_AUTO_TEST_CASE(progress_and_counts_run_over_all_slabs) {
    const Grid grid = around_mesh(0);
    const Band band = Band::symmetric(4 * grid.voxel());
    TransformStatistics at_once, by_slabs;
    DistanceTransform(test_device(), mesh()).compute(grid, band, Output::distance, {.count_work = true}, &at_once);
    std::vector<double> seen;
    DistanceTransform(with_largest_allocation(33 * slice_bytes(grid, sizeof(float))), mesh())
        .compute(grid, band, Output::distance,
                 {.progress = when_computing([&](double fraction) { seen.push_back(fraction); }), .count_work = true},
                 &by_slabs);
    BOOST_TEST(seen.size() >= 3U);
    BOOST_TEST(seen.front() == 0);
    BOOST_TEST(seen.back() == 1);
    BOOST_TEST(std::is_sorted(seen.begin(), seen.end()));
    BOOST_TEST(by_slabs.work->band_samples == at_once.work->band_samples);
    BOOST_TEST(by_slabs.work->lanes_evaluated == at_once.work->lanes_evaluated);
}

// The memory of the lists is known only when they are made. If they do not fit, the slab is divided.
BOOST_AUTO_TEST_CASE(a_slab_whose_lists_do_not_fit_is_divided) {
    const Mesh fine = make_shape("sphere5");
    const Grid grid = grid_around(fine, 100, 4);
    const Band band = Band::symmetric(16 * grid.voxel());
    const Field whole = compute(fine, grid, band);
    TransformStatistics unlimited;
    DistanceTransform(test_device(), fine).compute(grid, band, all_outputs(), {}, &unlimited);
    BOOST_REQUIRE(unlimited.slabs == 1U);
    // The polyhedra fit, but with less and less other memory the whole field does not.
    const std::size_t polyhedra = fine.triangles().size() * sizeof(Polyhedron);
    std::size_t slabs = 1;
    for (std::size_t percent = 95; slabs == 1; percent -= 5) {
        BOOST_REQUIRE(percent > 0);
        const std::size_t memory = polyhedra + (unlimited.device_bytes - polyhedra) * percent / 100;
        DistanceTransform transform(test_device().limited({.memory = memory}), fine);
        TransformStatistics statistics;
        BOOST_TEST(same_bytes(whole, transform.compute(grid, band, all_outputs(), {}, &statistics)));
        BOOST_TEST(statistics.device_bytes <= memory);
        slabs = statistics.slabs;
    }
    // Nothing can be divided here.
    DistanceTransform hopeless(test_device().limited({.memory = polyhedra / 2}), fine);
    check_throws(ErrorCode::out_of_memory, {"polyhedra", std::to_string(polyhedra / 2)},
                 [&] { hopeless.compute(grid, band); });
}

BOOST_AUTO_TEST_CASE(what_does_not_fit_a_device_is_named) {
    const Mesh large = make_shape("sphere5");
    DistanceTransform transform(with_largest_allocation(1 << 20), large);
    check_throws(ErrorCode::out_of_memory, {"bytes", "1048576"},
                 [&] { transform.compute(grid_around(large, 32, 3), Band::symmetric(0.1)); });
}
