#include "support/exact_field.hpp"
#include "support/hostile_meshes.hpp"
#include "support/throws.hpp"

#include "device/context.hpp"

#include <clsdf/tuning.hpp>

using namespace clsdf;
using namespace clsdf::test;

namespace {

/// The tests' device if its launches had to be as short as that.
Device with_launches_of(double seconds) {
    Device device = Device::strongest();
    // NOLINTNEXTLINE(cppcoreguidelines-pro-type-const-cast): work that takes long would take long to test
    const_cast<device::Context::Capabilities&>(device::context_of(device).capabilities()).launch_seconds = seconds;
    return device;
}

void check_short_launches(const Mesh& mesh, const Grid& grid, const Band& band) {
    for (const KernelBody body : {KernelBody::by_vector, KernelBody::by_group}) {
        const Field expected = compute(mesh, grid, band, body);
        DistanceTransform transform(with_launches_of(2e-5), mesh, {.body = body});
        BOOST_TEST(same_bytes(expected, transform.compute(grid, band, all_outputs())));
    }
}

}  // namespace

BOOST_AUTO_TEST_CASE(short_launches_compute_the_bytes_of_long_ones) {
    const Mesh knot = tilted(make_shape("knot"));
    const Grid grid = grid_around(knot, 60, 5);
    check_short_launches(knot, grid, Band::symmetric(4 * grid.voxel()));
    check_short_launches(knot, grid, Band::full());
}

// Work-items share triangles that many rows of samples meet.
BOOST_AUTO_TEST_CASE(a_triangle_of_many_rows_has_the_right_signs) {
    const Mesh solid = cube(1);
    const Grid grid = grid_at({0.01, 0.02, 0.03}, 2.2 / 150, 80).part({76, 0, 0}, {9, 161, 161});
    const Field field = compute(solid, grid, Band::symmetric(grid.voxel()));
    check_exact(solid, field);
    check_short_launches(solid, grid, Band::symmetric(grid.voxel()));
}

// More crossings than there is room for at first: four for each row, and 32 for each triangle or work-item.
BOOST_AUTO_TEST_CASE(a_surface_of_many_sheets_has_the_right_signs) {
    std::vector<Mesh> sheets;
    sheets.reserve(60);
    for (int i = 0; i < 60; ++i) sheets.push_back(cube(0.6 + 0.0062 * i));
    const Mesh onion = together(sheets, "cubes within cubes");
    const Grid grid = grid_at({0.01, 0.02, 0.03}, 0.1, 9);
    for (const KernelBody body : {KernelBody::by_vector, KernelBody::by_group})
        for (const SignRule rule : {SignRule::nonzero, SignRule::parity})
            check_exact(onion, compute(onion, grid, Band::symmetric(0.15), {.sign = rule, .body = body}), guaranteed);
    check_short_launches(onion, grid, Band::symmetric(0.15));
}

// They touch more coarse bricks than there is room for at first.
BOOST_AUTO_TEST_CASE(triangles_over_many_coarse_bricks_are_in_all_their_lists) {
    const Mesh beam = box({-2.5, -1.5, 0.5}, {2.5, 1.5, 720.5});
    Grid grid = grid_at({0, 0, 0}, 1, 4);
    grid.size[2] = 720;
    for (const Band& band : {Band::symmetric(2), Band::full()}) {
        for (const KernelBody body : {KernelBody::by_vector, KernelBody::by_group})
            check_exact(beam, compute(beam, grid, band, body), guaranteed);
        check_short_launches(beam, grid, band);
    }
}

BOOST_AUTO_TEST_CASE(the_setting_up_of_a_plan_is_cancelled) {
    const Mesh solid = cube(1);
    const Grid grid = grid_at({0, 0, 0}, 0.1, 15);
    DistanceTransform transform(test_device(), solid);
    int asked = 0, most = 0;
    const CallOptions call{.should_stop = [&] { return ++asked > most; }};
    for (; most < 3; ++most) {
        asked = 0;
        check_throws(ErrorCode::cancelled, {"cancelled"}, [&] { transform.plan(grid, Band::full(), {}, call); });
    }
    transform.plan(grid, Band::full());
}
