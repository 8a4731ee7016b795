// The kernels on a device that watches every access to memory: "oclgrind --data-races test_races". The simulated device
// is slow, so meshes and grids are small, but they have several coarse bricks, lists and work-groups.
#include "support/exact_field.hpp"
#include "support/hostile_meshes.hpp"

#include <array>

using namespace clsdf;
using namespace clsdf::test;

namespace {

constexpr std::array bodies{KernelBody::by_vector, KernelBody::by_group};

void check_on_simulator(const Mesh& mesh, const Grid& grid, const Band& band, TransformOptions options,
                        const Outputs& outputs = {}, const CallOptions& call = {}) {
    for (const KernelBody body : bodies) {
        options.body = body;
        DistanceTransform transform(test_device(), mesh, options);
        BOOST_TEST(check_exact(mesh, transform(grid, band, outputs, call), guaranteed).band_samples > 0U);
    }
}

/// `size` samples a side around a cube of side 2, the middle one at a corner of coarse bricks.
Grid around_cube(std::int64_t size, double h) {
    Grid grid = grid_at({0, 0, 0}, h, size / 2);
    for (std::size_t axis = 0; axis < 3; ++axis) {
        grid.first[axis] = -size / 2;
        grid.origin[axis] = 0;
    }
    return grid;
}

}  // namespace

BOOST_AUTO_TEST_CASE(a_band_over_eight_coarse_bricks) {
    check_on_simulator(cube(1), around_cube(10, 0.3), Band::symmetric(0.4), {},
                       {.triangle = true, .closest = true, .gradient = true, .barycentric = true});
}

BOOST_AUTO_TEST_CASE(every_sample_with_bounds_from_the_surface) {
    check_on_simulator(cube(1), around_cube(8, 0.4), Band::full(), {.sign = SignRule::parity});
}

BOOST_AUTO_TEST_CASE(counted_and_with_unequal_spacing) {
    Grid grid = around_cube(8, 0.4);
    grid.spacing[1] = 0.2;
    check_on_simulator(cube(1), grid, Band{0.5, 0.3}, {}, {}, {.count = true});
}
