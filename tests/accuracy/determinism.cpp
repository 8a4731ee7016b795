#include "frusta/awkward_meshes.hpp"
#include "support/exact_field.hpp"
#include "support/hostile_meshes.hpp"

#include "device/context.hpp"

#include <clsdf/tuning.hpp>

#include <tbb/global_control.h>
#include <tbb/task_arena.h>

#include <array>
#include <cmath>
#include <limits>

using namespace clsdf;
using namespace clsdf::test;

namespace {

constexpr double infinite = std::numeric_limits<double>::infinity();
constexpr std::array both_bodies{KernelBody::by_vector, KernelBody::by_group};

Field compute_on(const Device& device, const Mesh& mesh, const Grid& grid, const Band& band, KernelBody body) {
    DistanceTransform transform(device, mesh, {.body = body});
    return transform.compute(grid, band, all_outputs());
}

const Mesh& noisy() {
    static const Mesh mesh = [] {
        Random random(11);
        return random_sphere(random, "sphere4", 0.1);
    }();
    return mesh;
}

/// Its first sample is negative on two axes and on no brick's corner.
Grid whole_grid(const Mesh& mesh, std::int64_t size, const Vec3& ratio = {1, 1, 1}) {
    Grid grid;
    grid.size = {size, size + 9, size - 5};
    grid.first = {-21, 3, -37};
    for (std::size_t axis = 0; axis < 3; ++axis) {
        const Box& box = mesh.box();
        grid.spacing[axis] = 1.15 * ratio[axis] * box.longest_side() / static_cast<double>(size);
        grid.origin[axis] =
            0.5 * (box.lower[axis] + box.upper[axis]) -
            grid.spacing[axis] * (static_cast<double>(grid.first[axis]) + 0.5 * static_cast<double>(grid.size[axis]));
    }
    return grid;
}

void check_parts(const Mesh& mesh, const Grid& grid, const Band& band, KernelBody body,
                 const std::vector<std::pair<Index3, Index3>>& parts) {
    const Field whole = compute(mesh, grid, band, body);
    for (const auto& [offset, size] : parts)
        BOOST_TEST_CONTEXT("part of " << size[0] << " x " << size[1] << " x " << size[2] << " from (" << offset[0]
                                      << ", " << offset[1] << ", " << offset[2] << "), widths " << band.inside
                                      << " and " << band.outside) {
            const Grid part = grid.part(offset, size);
            const Field alone = compute(mesh, part, band, body);
            const Field expected = part_of(whole, part);
            BOOST_TEST(same_bytes(alone, expected));
        }
}

}  // namespace

BOOST_AUTO_TEST_CASE(every_run_gives_the_same_bytes) {
    const Grid grid = whole_grid(noisy(), 56);
    for (const Band& band : {Band::symmetric(4 * grid.voxel()), Band::full()}) {
        const Field first = compute(noisy(), grid, band, KernelBody::by_vector);
        DistanceTransform transform(test_device(), noisy(), {.body = KernelBody::by_vector});
        for (int run = 0; run < 3; ++run) BOOST_TEST(same_bytes(first, transform.compute(grid, band, all_outputs())));
    }
}

// The distance depends neither on the other outputs nor on earlier computations.
BOOST_AUTO_TEST_CASE(other_outputs_and_other_grids_change_nothing) {
    const Grid grid = whole_grid(noisy(), 40);
    const Band band = Band::symmetric(4 * grid.voxel());
    for (const KernelBody body : both_bodies) {
        const Field first = compute(noisy(), grid, band, body);
        DistanceTransform transform(test_device(), noisy(), {.body = body});
        transform.compute(whole_grid(noisy(), 24), Band::full());
        BOOST_TEST((bits_of(first.distance()) == bits_of(transform.compute(grid, band).distance())));
        BOOST_TEST(same_bytes(first, transform.compute(grid, band, all_outputs(), {.count_work = true})));
    }
}

BOOST_AUTO_TEST_CASE(any_number_of_threads_gives_the_same_bytes) {
    const Device one = one_compute_unit();
    const auto check = [&](const Mesh& mesh, const Grid& grid, const Band& band, KernelBody body) {
        const Field expected = compute(mesh, grid, band, body);
        for (int run = 0; run < 2; ++run) BOOST_TEST(same_bytes(expected, compute_on(one, mesh, grid, band, body)));
    };
    const Grid grid = whole_grid(noisy(), 56);
    check(noisy(), grid, Band::symmetric(4 * grid.voxel()), KernelBody::by_vector);
    check(noisy(), grid, Band::full(), KernelBody::by_vector);
    const Grid small = whole_grid(noisy(), 24);
    check(noisy(), small, Band::symmetric(3 * small.voxel()), KernelBody::by_group);
    check(noisy(), small, Band::full(), KernelBody::by_group);
}

namespace {

/// Faces of a fan around one vertex, in an order that leaps to and fro.
Mesh fan(std::uint32_t count) {
    std::vector<Vec3> vertices{{0, 0, 0}};
    std::vector<Triangle> triangles;
    for (std::uint32_t i = 0; i < count; ++i) {
        const double angle = 6.283185307179586 * i / count;
        vertices.push_back({std::cos(angle), std::sin(angle), 0.1});
        const auto spoke = static_cast<std::uint32_t>(std::uint64_t{i} * 7919 % count);
        triangles.push_back({0, 1 + spoke, 1 + (spoke + 1) % count});
    }
    return {std::move(vertices), std::move(triangles), "fan"};
}

}  // namespace

// All threads share a vertex, or a few, or none.
BOOST_AUTO_TEST_CASE(any_number_of_the_hosts_threads_gives_the_same_bytes) {
    Random random(3);
    for (const Mesh& mesh : {make_shape("sphere6"), make_shape("noisy"), fan(20000), random_soup(random, 20, 5000),
                             random_soup(random, 40000, 5000)}) {
        const Grid grid = whole_grid(mesh, 24);
        const auto field_by = [&](std::size_t threads) {
            const tbb::global_control control(tbb::global_control::max_allowed_parallelism, threads);
            Field field;
            // Also more threads than cores.
            tbb::task_arena(static_cast<int>(threads)).execute([&] {
                field = compute(mesh, grid, Band::symmetric(2 * grid.voxel()), KernelBody::by_vector);
            });
            return field;
        };
        const Field expected = field_by(1);
        for (const std::size_t threads : {2U, 16U, 16U})
            BOOST_TEST(same_bytes(expected, field_by(threads)), mesh.name() << ", " << threads << " threads");
    }
}

BOOST_AUTO_TEST_CASE(a_part_has_the_bytes_of_the_whole) {
    const Grid grid = whole_grid(noisy(), 72);
    const double h = grid.voxel();
    // From bricks' corners, from coarse bricks' corners (samples -32 and 32 of the lattice), and from anywhere.
    const std::vector<std::pair<Index3, Index3>> parts{
        {{5, 5, 5}, {32, 24, 40}}, {{21, 29, 5}, {32, 32, 32}}, {{0, 0, 0}, {33, 41, 17}},  {{13, 17, 30}, {1, 50, 9}},
        {{1, 2, 3}, {70, 77, 60}}, {{44, 2, 50}, {28, 70, 17}}, {{20, 28, 36}, {7, 11, 13}}};
    for (const Band& band : {Band::symmetric(3 * h), Band{1 * h, 9 * h}, Band{infinite, 2 * h}, Band::full()})
        check_parts(noisy(), grid, band, KernelBody::by_vector, parts);
}

// With small triangles, bricks that follow each other along x are stored as runs: within a coarse brick, or the part of
// it in the part.
BOOST_AUTO_TEST_CASE(a_part_has_the_bytes_of_the_whole_wherever_its_runs_begin) {
    const Mesh ball = tilted(make_shape("sphere5"));
    Grid grid = whole_grid(ball, 64);
    const std::vector<std::pair<Index3, Index3>> parts{
        {{8, 0, 0}, {48, 64, 64}}, {{16, 8, 3}, {48, 40, 33}}, {{3, 0, 0}, {61, 64, 64}}, {{24, 5, 0}, {32, 59, 64}}};
    for (const std::int64_t first : {0, -32, 8}) {
        for (std::size_t axis = 0; axis < 3; ++axis) {
            const std::int64_t to = axis == 0 ? first : 0;
            grid.origin[axis] += grid.spacing[axis] * static_cast<double>(grid.first[axis] - to);
            grid.first[axis] = to;
            grid.size[axis] = 64;
        }
        check_parts(ball, grid, Band::symmetric(5 * grid.voxel()), KernelBody::by_vector, parts);
    }
}

BOOST_AUTO_TEST_CASE(a_part_with_unequal_spacing_has_the_bytes_of_the_whole) {
    const Grid grid = whole_grid(noisy(), 48, {1, 0.4, 2.2});
    for (const Band& band : {Band::symmetric(3 * grid.voxel()), Band::full()})
        check_parts(noisy(), grid, band, KernelBody::by_vector,
                    {{{5, 5, 5}, {32, 24, 32}}, {{3, 0, 21}, {40, 57, 1}}, {{11, 13, 17}, {9, 19, 23}}});
}

BOOST_AUTO_TEST_CASE(a_part_computed_by_groups_has_the_bytes_of_the_whole) {
    const Mesh mesh = tilted(make_shape("knot"));
    const Grid grid = whole_grid(mesh, 44);
    for (const Band& band : {Band::symmetric(3 * grid.voxel()), Band::full()})
        check_parts(mesh, grid, band, KernelBody::by_group,
                    {{{21, 5, 5}, {16, 24, 32}}, {{3, 4, 9}, {31, 17, 5}}, {{0, 0, 0}, {9, 53, 39}}});
}

// Parts with fewer coarse bricks on an axis than a group of them has, which begin anywhere among them.
BOOST_AUTO_TEST_CASE(thin_parts_of_a_large_lattice_have_the_bytes_of_the_whole) {
    Grid grid = whole_grid(noisy(), 150);
    grid.first = {-70, -41, 9};
    for (std::size_t axis = 0; axis < 3; ++axis)
        grid.origin[axis] = noisy().box().lower[axis] - grid.spacing[axis] * static_cast<double>(grid.first[axis] + 9);
    const std::vector<std::pair<Index3, Index3>> parts{{{0, 0, 0}, {150, 9, 145}},
                                                       {{90, 0, 0}, {8, 159, 145}},
                                                       {{30, 0, 40}, {64, 159, 96}},
                                                       {{100, 100, 0}, {1, 1, 145}},
                                                       {{11, 100, 50}, {99, 17, 33}}};
    for (const Band& band : {Band::symmetric(10 * grid.voxel()), Band::full()})
        check_parts(noisy(), grid, band, KernelBody::by_vector, parts);
    check_parts(noisy(), grid, Band::symmetric(3 * grid.voxel()), KernelBody::by_group, parts);
}

// Kernels make their records near the part only.
BOOST_AUTO_TEST_CASE(a_part_of_any_mesh_has_the_bytes_of_the_whole) {
    for (unsigned seed = 1; seed <= 30; ++seed) BOOST_TEST_CONTEXT("seed " << seed) {
            Random random(seed);
            const Mesh mesh = awkward_mesh(random);
            const Band band = Band::symmetric(0.05 * mesh.box().longest_side());
            Grid grid = Grid::around(mesh, 40, band);
            if (seed % 3 == 0) grid.spacing[seed % 2] *= 0.7;
            const auto& [nx, ny, nz] = grid.size;
            check_parts(mesh, grid, band, KernelBody::by_vector,
                        {{{nx / 4, ny / 4, nz / 4}, {nx / 4 + 1, ny / 4 + 1, nz / 4 + 1}}});
            reference::CheckOptions options;
            options.samples = 5000;
            BOOST_TEST(reference::check(mesh, compute(mesh, grid, band, KernelBody::by_vector), options).passed());
        }
}
