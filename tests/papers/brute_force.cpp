#include "papers/scanned.hpp"
#include "support/hostile_meshes.hpp"
#include "support/random_meshes.hpp"
#include "support/throws.hpp"

#include <clsdf/tuning.hpp>

using namespace clsdf;
using namespace clsdf::test;

namespace {

DistanceTransform transform_of(const Mesh& mesh, KernelBody body = KernelBody::automatic) {
    return make_transform(test_device(), mesh, {.scan = Scan::brute_force}, {.body = body});
}

Mesh noisy() {
    Random random(17);
    return tilted(random_sphere(random, "sphere3", 0.15));
}

}  // namespace

BOOST_AUTO_TEST_CASE(every_sample_is_right) {
    Random random(23);
    for (const Mesh& mesh : {cube(1), noisy(), without_triangle(cube(1), 3), random_slivers(random, 30)})
        for (const KernelBody body : both_bodies) {
            const DistanceTransform transform = transform_of(mesh, body);
            Grid grid = grid_around(mesh, 37, 3);
            for (const Band& band : {Band::symmetric(3 * grid.voxel()), Band::full()})
                check_exact(mesh, transform.compute(grid, band, Output::triangle));
            grid.spacing[2] *= 40;  // so unequal that distances take double
            grid.size[2] = 3;
            check_exact(mesh, transform.compute(grid, Band::full(), Output::triangle));
        }
}

BOOST_AUTO_TEST_CASE(a_part_has_the_bytes_of_the_whole_and_every_sample_counts) {
    const Mesh mesh = noisy();
    Grid grid = grid_around(mesh, 44, 4);
    grid.first = {-13, 3, -21};
    for (std::size_t axis = 0; axis < 3; ++axis)
        grid.origin[axis] -= static_cast<double>(grid.first[axis]) * grid.spacing[axis];
    const Band band{2 * grid.voxel(), 5 * grid.voxel()};
    for (const KernelBody body : both_bodies) {
        const DistanceTransform transform = transform_of(mesh, body);
        TransformStatistics statistics;
        const Field whole = transform.compute(grid, band, Output::triangle, {.count_work = true}, &statistics);
        BOOST_TEST(same_bytes(whole, transform.compute(grid, band, Output::triangle)));
        BOOST_TEST(statistics.work->band_samples ==
                   scan_slices(mesh, grid, band, {}, body).statistics.work->band_samples);
        BOOST_TEST(statistics.work->lanes_evaluated >= grid.sample_count() * mesh.triangles().size());
        const Index3 offset{5, 9, 11};
        const Field part = transform.compute(grid.part(offset, {17, 12, 21}), band, Output::triangle);
        std::size_t differences = 0;
        for (std::int64_t k = 0; k < part.grid.size[2]; ++k)
            for (std::int64_t j = 0; j < part.grid.size[1]; ++j)
                for (std::int64_t i = 0; i < part.grid.size[0]; ++i) {
                    const std::size_t here = part.grid.offset(i, j, k);
                    const std::size_t there = grid.offset(i + offset[0], j + offset[1], k + offset[2]);
                    differences += part.distance()[here] != whole.distance()[there] ||
                                           part.triangle()[here] != whole.triangle()[there]
                                       ? 1U
                                       : 0U;
                }
        BOOST_TEST(differences == 0U);
    }
}

// Minima of many launches: some bricks and some triangles each.
BOOST_AUTO_TEST_CASE(many_launches_find_one_minimum) {
    const Mesh mesh = make_shape("sphere5");
    const Grid grid = grid_around(mesh, 60, 3);
    const Band band = Band::symmetric(3 * grid.voxel());
    std::size_t launches = 0;
    const Field field = transform_of(mesh).compute(grid, band, Output::triangle,
                                                   {.progress = when_computing([&](double) { ++launches; })});
    BOOST_TEST(launches > 2U);
    check_exact(mesh, field);
}

BOOST_AUTO_TEST_CASE(what_it_does_not_know_is_refused) {
    const Mesh mesh = cube(1);
    const Grid grid = grid_around(mesh, 16, 3);
    check_throws(ErrorCode::unsupported, {"brute force", "gradient"},
                 [&] { transform_of(mesh).compute(grid, Band::full(), Output::gradient); });
    check_throws(ErrorCode::unsupported, {"brute-force", "mauch"}, [&] {
        make_transform(test_device(), mesh, {.polyhedra = Polyhedra::mauch, .scan = Scan::brute_force});
    });
}
