#include "papers/scanned.hpp"
#include "support/hostile_meshes.hpp"

#include <clsdf/tuning.hpp>

#include <algorithm>
#include <cmath>

using namespace clsdf;
using namespace clsdf::test;

// They look at other triangles, and round the same triangle's distance a little otherwise.
BOOST_AUTO_TEST_CASE(bricks_and_slices_agree_within_the_accuracy) {
    std::size_t equal = 0, samples = 0;
    for (const char* name : {"sphere3", "knot", "stairs", "nested"}) {
        const Mesh mesh = tilted(make_shape(name));
        const Grid grid = grid_around(mesh, 40, 4);
        const Band band{2 * grid.voxel(), 4 * grid.voxel()};
        const Field bricks = compute(mesh, grid, band);
        const Field slices = scan_slices(mesh, grid, band).field;
        for (std::size_t at = 0; at < bricks.distance().size(); ++at) {
            const double a = bricks.distance()[at], b = slices.distance()[at];
            BOOST_REQUIRE(std::abs(a - b) <=
                          std::max(2 * aimed.voxels * grid.voxel(), 2 * aimed.ulp * std::abs(a) * 0x1p-23));
            equal += a == b;
        }
        samples += bricks.distance().size();
    }
    BOOST_TEST_MESSAGE(equal << " of " << samples << " values are the same to the last bit");
    BOOST_TEST(equal > samples / 2);
}

// Triangles count for fewer samples than those of the bricks they touch.
BOOST_AUTO_TEST_CASE(a_triangle_counts_for_the_samples_of_its_polyhedron_only) {
    const Mesh mesh = make_shape("sphere4");
    const Grid grid = grid_around(mesh, 60, 4);
    const TransformStatistics statistics = scan_slices(mesh, grid, Band::symmetric(3 * grid.voxel())).statistics;
    BOOST_TEST(statistics.work->samples_covered >= statistics.work->band_samples);
    BOOST_TEST(statistics.work->samples_covered < 2 * statistics.work->band_samples);
    BOOST_TEST(statistics.work->band_samples > 10000U);
}
