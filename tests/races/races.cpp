// The kernels on a device that watches every access to memory: "oclgrind --data-races test_races". The simulated device
// is slow, so meshes and grids are small, but they have several coarse bricks, lists and work-groups.
#include "support/exact_field.hpp"
#include "support/hostile_meshes.hpp"
#include "support/point_contract.hpp"
#include "support/random_meshes.hpp"
#include "support/shared_lists.hpp"
#include "support/test_meshes.hpp"

#include "checks/known_targets.hpp"
#include "checks/known_topology.hpp"
#include "checks/self_test.hpp"
#include "device/buffer_pool.hpp"
#include "device/context.hpp"
#include "frusta/kernel_frusta.hpp"
#include "launch/programs.hpp"
#include "launch/radix_sort.hpp"

#include <clsdf/fractions.hpp>
#include <clsdf/outer.hpp>
#include <clsdf/papers.hpp>
#include <clsdf/tuning.hpp>

#include <algorithm>
#include <array>
#include <cstdlib>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

using namespace clsdf;
using namespace clsdf::test;

namespace {

constexpr std::array bodies{KernelBody::by_vector, KernelBody::by_group};

void check_on_simulator(const Mesh& mesh, const Grid& grid, const Band& band, TransformOptions options,
                        OutputSet outputs = {}, const CallOptions& call = {}) {
    for (const KernelBody body : bodies) {
        options.body = body;
        DistanceTransform transform(test_device(), mesh, options);
        BOOST_TEST(check_exact(mesh, transform.compute(grid, band, outputs, call), guaranteed).band_samples > 0U);
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

/// Four faces around a vertex, which leave directions out.
Mesh gap() {
    return {{{0, 0, 0}, {-42, 3, -100}, {53, 45, -67}, {62, 11, 74}, {-75, -33, 51}},
            {{0, 1, 2}, {0, 2, 3}, {0, 3, 4}, {0, 4, 1}},
            "gap"};
}

}  // namespace

BOOST_AUTO_TEST_CASE(a_band_over_eight_coarse_bricks) {
    check_on_simulator(cube(1), around_cube(10, 0.3), Band::symmetric(0.4), {},
                       Output::triangle | Output::closest | Output::gradient | Output::barycentric | Output::offset);
}

BOOST_AUTO_TEST_CASE(every_sample_with_bounds_from_the_surface) {
    check_on_simulator(cube(1), around_cube(8, 0.4), Band::full(), {.sign = SignRule::parity});
}

BOOST_AUTO_TEST_CASE(counted_and_with_unequal_spacing) {
    Grid grid = around_cube(8, 0.4);
    grid.spacing[1] = 0.2;
    check_on_simulator(cube(1), grid, Band{0.5, 0.3}, {}, {}, {.count_work = true});
}

BOOST_AUTO_TEST_CASE(boxes_of_a_plan_with_strides) {
    const Grid grid = around_cube(10, 0.3);
    const Band band = Band::symmetric(0.4);
    // Two boxes that share samples, side by side in the rows of one array.
    const std::array boxes{grid.block({-5, -5, -5}, {6, 5, 4}), grid.block({-2, -3, -4}, {7, 5, 4})};
    constexpr std::ptrdiff_t row = 13 * sizeof(float), slice = 5 * row;
    const device::Context& context = device::context_of(test_device());
    const cl::CommandQueue queue(context.context(), context.device());
    for (const KernelBody body : bodies) {
        const cl::Buffer memory(context.context(), CL_MEM_READ_WRITE, 4 * slice);
        const DistanceTransform transform(test_device(), cube(1), {.body = body});
        std::vector<Request> requests;
        for (std::size_t n = 0; n < 2; ++n) {
            OutputArray target(memory());
            target.offset = n * 6 * sizeof(float);
            target.strides = {sizeof(float), row, slice};
            requests.push_back({boxes[n], band, target});
        }
        Plan plan = transform.plan(requests);
        plan.enqueue(queue());
        queue.finish();
        std::vector<float> values(4 * slice / sizeof(float));
        queue.enqueueReadBuffer(memory, CL_TRUE, 0, 4 * slice, values.data());
        const Field field = transform.compute(grid, band);
        for (std::size_t n = 0; n < 2; ++n)
            for (std::int64_t k = 0; k < 4; ++k)
                for (std::int64_t j = 0; j < 5; ++j)
                    for (std::int64_t i = 0; i < boxes[n].size[0]; ++i) {
                        const auto at = static_cast<std::size_t>(13 * (5 * k + j) + i) + 6 * n;
                        const Index3 first = boxes[n].first;
                        const std::size_t of_field = grid.offset(first[0] + i + 5, first[1] + j + 5, first[2] + k + 5);
                        BOOST_TEST(values[at] == field.distance()[of_field]);
                    }
    }
}

BOOST_AUTO_TEST_CASE(a_mesh_that_moves_and_another_lattice) {
    const Mesh mesh = cube(1);
    std::vector<Vec3> moved = mesh.vertices();
    for (Vec3& p : moved) p[0] *= 1.25;
    for (const KernelBody body : bodies) {
        DistanceTransform transform(test_device(), mesh, {.body = body});
        transform.compute(around_cube(4, 0.6), Band::symmetric(0.5));
        transform.set_positions(moved);
        const Field field = transform.compute(around_cube(6, 0.55), Band::symmetric(0.5));
        BOOST_TEST(check_exact(Mesh(moved, mesh.triangles(), "moved"), field, guaranteed).band_samples > 0U);
    }
}

// The library's own test of its kernels for many points, which compares the results. (The simulator cannot run the
// search for points one by one: its compiler leaves a declaration in the code that the simulator does not know.)
BOOST_AUTO_TEST_CASE(many_points) {
    unsetenv("CLSDF_SELF_TEST");
    const engine::Programs programs(device::context_of(test_device()), KernelBody::by_vector);
    BOOST_TEST(checks::ensure_tested(test_device(),
                                     checks::point_subject(test_device(), programs, checks::PointKernels::of_many)));
    setenv("CLSDF_SELF_TEST", "0", 1);
}

// The library's own test of the kernels that store links.
BOOST_AUTO_TEST_CASE(links_of_a_plan) {
    unsetenv("CLSDF_SELF_TEST");
    const engine::Programs programs(device::context_of(test_device()), KernelBody::by_vector);
    BOOST_TEST(checks::ensure_tested(test_device(), checks::stored_links_subject(test_device(), programs)));
    setenv("CLSDF_SELF_TEST", "0", 1);
}

// The order of points, the tree, the search and the outputs; the centre is as near to more faces than a list holds.
// After a small move the tree is fitted, after a large one made anew.
BOOST_AUTO_TEST_CASE(points_on_a_gpu_before_and_after_moves) {
    Mesh mesh = make_shape("sphere2");
    Random random(5);
    std::vector<Vec3> points(130);
    for (Vec3& p : points) p = random.point(-1.2, 1.2);
    points[17] = {0, 0, 0};
    DistanceTransform transform(test_device(), mesh, {.sign = SignRule::parity, .body = KernelBody::by_group});
    for (int step = 0; step < 3; ++step) {
        const Field field = query(transform, points);
        const PointContract contract(mesh, transform.sign(), std::numeric_limits<double>::infinity());
        for (std::size_t i = 0; i < points.size(); ++i) {
            const std::string fault = contract.fault(points[i], field, i);
            BOOST_TEST(fault.empty(), "step " << step << ", point " << i << ": " << fault);
        }
        mesh = step == 0 ? scaled(mesh, 1.1) : moved(mesh, [&](const Vec3&) { return random.point(-1, 1); });
        transform.set_positions(mesh.vertices());
    }
}

// Results with strides; a tree of one leaf; then signs that the host decides, because a coordinate is beyond the range
// of kernels.
BOOST_AUTO_TEST_CASE(points_in_memory_of_a_gpu) {
    const device::Context& context = device::context_of(test_device());
    const cl::CommandQueue queue(context.context(), context.device());
    for (const double x : {0.0, 1e-100}) {
        const Mesh mesh({{x, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}}, {{0, 2, 1}, {0, 1, 3}, {0, 3, 2}, {1, 2, 3}},
                        "tetrahedron");
        const DistanceTransform transform(test_device(), mesh, {.body = KernelBody::by_group});
        std::vector<Vec3> points;
        for (int i = 0; i < 130; ++i) points.push_back({0.1 * (i % 4) + 0.05, 0.1 * (i / 4 % 4) + 0.04, 0.01 * i});
        const Field expected = query(transform, points);
        cl::Buffer from(context.context(), CL_MEM_READ_WRITE, points.size() * sizeof(Vec3));
        cl::Buffer to(context.context(), CL_MEM_READ_WRITE, points.size() * 2 * sizeof(float));
        queue.enqueueWriteBuffer(from, CL_TRUE, 0, points.size() * sizeof(Vec3), points.data());
        OutputArray target(to());
        target.strides[0] = 2 * sizeof(float);
        transform.query(InputArray(from(), ElementType::float64, points.size()),
                        std::numeric_limits<double>::infinity(), {{Output::distance, target}});
        std::vector<float> found(2 * points.size());
        queue.enqueueReadBuffer(to, CL_TRUE, 0, found.size() * sizeof(float), found.data());
        for (std::size_t i = 0; i < points.size(); ++i) BOOST_TEST(found[2 * i] == expected.distance()[i]);
    }
}

BOOST_AUTO_TEST_CASE(keys_in_several_tiles_are_sorted) {
    device::Context& context = device::context_of(test_device());
    const auto pool = std::make_shared<device::BufferPool>(device::shared_context_of(test_device()));
    const engine::Programs programs(context, KernelBody::by_group);
    std::vector<std::uint32_t> keys(5000), order(keys.size());
    for (std::size_t i = 0; i < keys.size(); ++i) keys[i] = static_cast<std::uint32_t>(i * 40503 % 4096);
    const device::BufferPool::Lease on_device = pool->lease(keys.size() * sizeof(cl_uint), "test");
    const device::BufferPool::Lease sorted = pool->lease(keys.size() * sizeof(cl_uint), "test");
    context.queue().enqueueWriteBuffer(*on_device, CL_TRUE, 0, keys.size() * sizeof(cl_uint), keys.data());
    engine::sort_by_keys({context, pool, programs}, *on_device, keys.size(), 12, *sorted);
    context.queue().enqueueReadBuffer(*sorted, CL_TRUE, 0, keys.size() * sizeof(cl_uint), order.data());
    BOOST_TEST(std::ranges::is_sorted(order, {}, [&](std::uint32_t i) { return std::pair(keys[i], i); }));
}

// Two tiles of corners, and edges of all kinds.
BOOST_AUTO_TEST_CASE(a_topology_is_that_of_the_host) {
    device::Context& context = device::context_of(test_device());
    const auto pool = std::make_shared<device::BufferPool>(device::shared_context_of(test_device()));
    const engine::Programs programs(context, KernelBody::by_group);
    Mesh mesh = together({make_shape("sphere3"), unwelded(cube(2)), fins(), moebius_strip(20)}, "edges of all kinds");
    const auto difference = checks::topology_difference(engine::DeviceSetUp({context, pool, programs}), mesh);
    BOOST_TEST(!difference.has_value(), difference.value_or(""));
}

// Vertices with and without a gap, one of more faces than kernels take, edges of all kinds, edges flat up to rounding.
// Only the test disguise_races has the kernels: the simulator calls itself a processor.
BOOST_AUTO_TEST_CASE(completed_frusta_of_a_gpu) {
    device::Context& context = device::context_of(test_device());
    const auto pool = std::make_shared<device::BufferPool>(device::shared_context_of(test_device()));
    const engine::Programs programs(context, KernelBody::by_group);
    if (programs.mesh_lanes() != 1) return;
    const engine::DeviceSetUp job({context, pool, programs});
    const Mesh mesh = together({gap(), shifted(tip(8, 7, 0.5), {300, 0, 0}), shifted(tip(13, 0.5, 5), {330, 0, 0}),
                                shifted(fins(), {300, 30, 0}), shifted(tilted(make_shape("sphere1")), {330, 30, 0})},
                               "fans");
    const engine::MeshTopology topology(mesh);
    engine::Frusta host = engine::make_frusta(topology, mesh.vertices());
    host.sites = engine::in_groups(host.sites, engine::site_blocks(host.sites, {}));
    std::optional<engine::MadeTopology> made = engine::make_device_topology(job, mesh);
    BOOST_REQUIRE(made.has_value());
    engine::KeptValues kept;
    engine::HomedTopology on_device(kept, engine::MadeOf::triangles, engine::UsedBy::grids, nullptr, nullptr);
    on_device.set(nullptr, made->topology);
    const engine::MadeFrusta kernels =
        frusta_by_kernels(job, on_device, std::make_shared<const device::BufferPool::Lease>(std::move(made->positions)),
                          mesh.box(), nullptr);
    BOOST_TEST(kernels.faces.part != nullptr);
    BOOST_TEST(!kernels.left.gaps.empty());
    BOOST_TEST(std::ranges::equal(kernels.faces.found->sites, host.sites, {}, &engine::SiteFrustum::vertex,
                                  &engine::SiteFrustum::vertex));
}

BOOST_AUTO_TEST_CASE(links_and_exact_signs_of_a_gpu) {
    const Mesh mesh = together({tilted(make_shape("sphere1")), shifted(cube(1), {1.5, 0, 0})}, "ball and box");
    const Grid grid = around_cube(10, 0.3);
    const std::vector<LinkDirection> directions = stencil("D3Q19");
    Band band = Band::symmetric(0.5);
    band.has_exact_signs = true;
    const DistanceTransform host(test_device(), mesh, {.body = KernelBody::by_vector}),
        gpu(test_device(), mesh, {.body = KernelBody::by_group});
    const Links expected = host.links(grid, directions), found = gpu.links(grid, directions);
    BOOST_TEST(found.size() > 500U);
    BOOST_TEST((found.samples == expected.samples && found.directions == expected.directions));
    BOOST_TEST((found.q == expected.q && found.triangles == expected.triangles && found.counts == expected.counts));
    BOOST_TEST((found.inside.bits == expected.inside.bits));
    const Field field = gpu.compute(grid, band);
    for (std::size_t n = 0; n < grid.sample_count(); ++n)
        BOOST_TEST((field.distance()[n] < 0) == found.inside.is_inside(n));
}

BOOST_AUTO_TEST_CASE(cut_cells_in_memory_of_one) {
    const device::Context& context = device::context_of(test_device());
    const cl::CommandQueue queue(context.context(), context.device());
    const OuterSurface surface = outer(tilted(cube(1)));
    const Grid grid = around_cube(4, 0.8);
    const Fractions expected = fractions(surface, grid);
    const std::size_t rows = expected.cells.size();
    const cl::Buffer cells(context.context(), CL_MEM_READ_WRITE, 3 * rows * sizeof(std::int32_t)),
        volume(context.context(), CL_MEM_READ_WRITE, rows * sizeof(double));
    std::size_t count = 0;
    fractions(test_device(), surface, grid, {.room = rows, .cells = cells(), .volume = volume()}, count);
    BOOST_REQUIRE(count == rows);
    std::vector<std::int32_t> found_cells(3 * rows);
    std::vector<double> found_volume(rows);
    queue.enqueueReadBuffer(cells, CL_TRUE, 0, found_cells.size() * sizeof(std::int32_t), found_cells.data());
    queue.enqueueReadBuffer(volume, CL_TRUE, 0, rows * sizeof(double), found_volume.data());
    for (std::size_t n = 0; n < rows; ++n) {
        BOOST_TEST(found_volume[n] == expected.cells[n].volume);
        for (std::size_t axis = 0; axis < 3; ++axis)
            BOOST_TEST(found_cells[3 * n + axis] == expected.cells[n].cell[axis]);
    }
}

BOOST_AUTO_TEST_CASE(groups_that_share_a_list) {
    const Grid grid = around_cube(8, 0.4);
    const Band band = Band::symmetric(0.5);
    const DistanceTransform transform(test_device(), cube(1), {.body = KernelBody::by_group});
    BOOST_TEST((bits_of(distances_by_shares(test_device(), cube(1), grid, band)) ==
                bits_of(transform.compute(grid, band).distance())));
}

BOOST_AUTO_TEST_CASE(methods_of_the_papers) {
    const Grid grid = around_cube(8, 0.4);
    for (const Scan scan : {Scan::slices, Scan::brute_force})
        for (const KernelBody body : bodies) {
            const DistanceTransform transform = make_transform(test_device(), cube(1), {.scan = scan}, {.body = body});
            const Field field = transform.compute(grid, Band::symmetric(0.5));
            BOOST_TEST(check_exact(cube(1), field, guaranteed).band_samples > 0U);
        }
}
