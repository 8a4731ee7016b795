// Bounds on the calls and bytes of a computation on a GPU, for any mesh and for this one.
#include "disguise/as_gpu.hpp"
#include "support/device_memory.hpp"
#include "support/exact_field.hpp"
#include "support/hostile_meshes.hpp"

#include <clsdf/papers.hpp>

#include "bricks/brick_scan.hpp"
#include "core/parallel.hpp"
#include "device/context.hpp"
#include "disguise/disguise.hpp"
#include "frusta/frusta.hpp"
#include "frusta/records.hpp"
#include "point_order.h"

#include <algorithm>
#include <cmath>
#include <random>
#include <span>

using namespace clsdf;
using namespace clsdf::test;

BOOST_TEST_GLOBAL_FIXTURE(AsGpu);

BOOST_AUTO_TEST_CASE(the_device_is_a_gpu_with_memory_of_its_own) {
    const device::Context& context = device::context_of(test_device());
    BOOST_REQUIRE(disguise::counts().all_calls > 0U);  // else the library is not between this program and the loader
    BOOST_TEST(!context.capabilities().is_processor);
    BOOST_TEST(context.capabilities().float_width == 1U);
    BOOST_TEST((context.device().getInfo<CL_DEVICE_TYPE>() == CL_DEVICE_TYPE_GPU));

    // The device gets the host's writes to mapped memory when it is unmapped, not before.
    const cl::CommandQueue& queue = context.queue();
    std::array<cl_uint, 16> host{};
    host.fill(7);
    const cl::Buffer buffer(context.context(), CL_MEM_READ_WRITE | CL_MEM_USE_HOST_PTR, sizeof host, host.data());
    queue.enqueueFillBuffer(buffer, cl_uint{5}, 0, sizeof host);
    queue.finish();
    BOOST_TEST(host[3] == 7U);
    auto* const mapped =
        static_cast<cl_uint*>(queue.enqueueMapBuffer(buffer, CL_TRUE, CL_MAP_READ | CL_MAP_WRITE, 0, sizeof host));
    BOOST_TEST(mapped == host.data());
    BOOST_TEST(host[3] == 5U);
    mapped[3] = 9;
    std::array<cl_uint, 16> read{};
    queue.enqueueReadBuffer(buffer, CL_TRUE, 0, sizeof read, read.data());
    BOOST_TEST(read[3] == 5U);
    queue.enqueueUnmapMemObject(buffer, mapped);
    queue.enqueueReadBuffer(buffer, CL_TRUE, 0, sizeof read, read.data());
    BOOST_TEST(read[3] == 9U);
}

BOOST_AUTO_TEST_CASE(a_field_on_a_gpu_is_exact) {
    const Field field = compute(mesh(), grid(), band());
    BOOST_TEST(check_exact(mesh(), field, guaranteed).band_samples > 0U);
    BOOST_TEST(disguise::counts().kernels["bricks_by_group"].launches > 0U);
}

BOOST_AUTO_TEST_CASE(calls_of_a_kept_transform_stay_within_their_bounds) {
    const DistanceTransform transform(test_device(), mesh());
    std::vector<float> distance(grid().sample_count());
    const auto counts_of = [&](const Band& band) {
        disguise::restart();
        transform.compute(grid(), band, distance);
        const disguise::Counts counts = disguise::counts();
        BOOST_TEST_MESSAGE(disguise::to_json(counts));
        BOOST_TEST(counts.programs_built == 0U);
        // The host reads the field, totals, and where lists start.
        BOOST_TEST(counts.bytes_down >= distance.size() * sizeof(float));
        BOOST_TEST(counts.bytes_down <= distance.size() * sizeof(float) + 1024U);
        return counts;
    };
    const Band other = Band::symmetric(2 * grid().voxel());
    transform.compute(grid(), band(), distance);
    transform.compute(grid(), other, distance);

    // The same grid and band: no list is made again.
    const disguise::Counts again = counts_of(band());
    BOOST_TEST(!again.kernels.contains("coarse_pairs"));
    BOOST_TEST(again.blocking_waits <= 2U);
    BOOST_TEST(again.allocations <= 1U);
    BOOST_TEST(again.bytes_up == 0U);

    // The same lattice: lists and sign, no polyhedra. The host writes the order of the lists.
    disguise::Counts same_lattice = counts_of(Band::symmetric(2.5 * grid().voxel()));
    BOOST_TEST(same_lattice.kernels["coarse_pairs"].runs == 1U);
    BOOST_TEST(same_lattice.blocking_waits <= 3U);
    BOOST_TEST(same_lattice.launches <= 17U);
    BOOST_TEST(same_lattice.fills <= 7U + same_lattice.first_uses);
    BOOST_TEST(same_lattice.bytes_up <= 1024U);
}

BOOST_AUTO_TEST_CASE(of_many_patches_only_their_own_samples_come_to_the_host) {
    const Grid lattice = grid_around(mesh(), 96, 3);
    const Band narrow = Band::symmetric(3 * lattice.voxel());
    constexpr std::int64_t side = 6;
    std::vector<Request> requests;
    for (std::int64_t z = 0; z + side <= lattice.size[2]; z += 17)
        for (std::int64_t y = 0; y + side <= lattice.size[1]; y += 19)
            requests.push_back({lattice.part({y % (lattice.size[0] - side), y, z}, {side, side, side}), narrow, {}});
    const std::size_t samples = side * side * side;
    std::vector<float> distance(requests.size() * samples);
    std::vector<double> gradient(3 * distance.size());
    for (std::size_t n = 0; n < requests.size(); ++n)
        requests[n].targets = {{Output::distance, distance.data() + n * samples},
                               {Output::gradient, gradient.data() + 3 * n * samples}};
    const DistanceTransform transform(test_device(), mesh());
    transform.compute(requests);
    std::ranges::fill(distance, -7.0F);
    std::ranges::fill(gradient, -7.0);
    disguise::restart();
    transform.compute(requests);
    const disguise::Counts counts = disguise::counts();
    BOOST_TEST_MESSAGE(disguise::to_json(counts));
    const std::size_t asked_for = distance.size() * sizeof(float) + gradient.size() * sizeof(double);
    BOOST_TEST(counts.bytes_down <= asked_for + asked_for / 10 + 1024U);
    std::vector<float> alone(samples);
    std::vector<double> gradient_alone(3 * samples);
    for (std::size_t n = 0; n < requests.size(); ++n) {
        transform.compute(requests[n].grid, narrow,
                          {{Output::distance, alone.data()}, {Output::gradient, gradient_alone.data()}});
        const auto at = static_cast<std::ptrdiff_t>(n * samples);
        BOOST_TEST(std::ranges::equal(alone, std::span(distance).subspan(n * samples, samples)));
        BOOST_TEST(std::equal(gradient_alone.begin(), gradient_alone.end(), gradient.begin() + 3 * at,
                              [](double a, double b) { return a == b || (std::isnan(a) && std::isnan(b)); }));
    }

    // A first call, of a mesh that the device has, also brings the boxes of clusters.
    for (std::size_t n = 0; n < requests.size(); ++n)
        requests[n].targets = {{Output::distance, distance.data() + n * samples}};
    for (int round = 0; round < 2; ++round) {  // programs are tested in the first one
        const DistanceTransform other(test_device(), mesh());
        other.compute(grid(), band(), OutputSet());
        disguise::restart();
        other.compute(requests);
    }
    BOOST_TEST(disguise::counts().bytes_down <= 1.1 * static_cast<double>(distance.size() * sizeof(float)) + 4096);
    // One by one they need a part of the mesh each.
    const DistanceTransform other(test_device(), mesh());
    other.compute(grid(), band(), OutputSet());
    disguise::restart();
    for (const Request& request : requests) other.compute(request);
    BOOST_TEST(disguise::counts().kernels.contains("sweep_clusters"));
    const Field whole = transform.compute(lattice, narrow);
    for (std::size_t n = 0; n < requests.size(); ++n) {
        const Index3& first = requests[n].grid.first;
        std::size_t sample = n * samples;
        for (std::int64_t z = first[2]; z < first[2] + side; ++z)
            for (std::int64_t y = first[1]; y < first[1] + side; ++y)
                for (std::int64_t x = first[0]; x < first[0] + side; ++x) {
                    const auto place = static_cast<std::size_t>((z * lattice.size[1] + y) * lattice.size[0] + x);
                    BOOST_TEST(distance[sample++] == whole.distance()[place]);
                }
    }

    // With strides, too.
    std::vector<float> spread(2 * distance.size(), -7.0F);
    constexpr std::ptrdiff_t stride = 2 * sizeof(float);
    for (std::size_t n = 0; n < requests.size(); ++n)
        requests[n].targets = {{Output::distance, OutputArray(spread.data() + 2 * n * samples,
                                                              {stride, stride * side, stride * side * side})}};
    disguise::restart();
    transform.compute(requests);
    const std::size_t of_distances = distance.size() * sizeof(float);
    BOOST_TEST(disguise::counts().bytes_down <= of_distances + of_distances / 10 + 1024U);
    for (std::size_t i = 0; i < distance.size(); ++i) {
        BOOST_TEST(spread[2 * i] == distance[i]);
        BOOST_TEST(spread[2 * i + 1] == -7.0F);
    }
}

BOOST_AUTO_TEST_CASE(a_first_call_waits_for_open_vertices_lists_and_the_field_only) {
    DistanceTransform(test_device(), mesh()).compute(grid(), band());  // programs are built and tested
    std::vector<float> distance(grid().sample_count());
    disguise::restart();
    DistanceTransform transform(test_device(), mesh());
    transform.compute(grid(), band(), distance);
    const disguise::Counts counts = disguise::counts();
    BOOST_TEST_MESSAGE(disguise::to_json(counts));
    BOOST_TEST(counts.programs_built == 0U);
    // The four waits of docs/gpu.md, and the read of a field too small for pinned memory, which blocks after the last
    // of them.
    BOOST_TEST(counts.blocking_waits <= 5U);
    BOOST_TEST(counts.launches <= 64U);
    // The mesh's arrays, the order of the coarse lists, and the slopes and the records that the host writes.
    BOOST_TEST(counts.bytes_up <= 12 * mesh().triangles().size() + 24 * mesh().vertices().size() + 65536);
    // The field, and little of the mesh.
    BOOST_TEST(counts.bytes_down <= distance.size() * sizeof(float) + 112 * mesh().triangles().size() / 2 + 65536);
    BOOST_TEST(counts.kernels.contains("face_slopes"));
    BOOST_TEST(!counts.kernels.contains("face_records"));
}

BOOST_AUTO_TEST_CASE(vertices_that_move_go_to_the_device_and_nothing_else_of_the_mesh) {
    DistanceTransform transform(test_device(), mesh());
    std::vector<float> distance(grid().sample_count());
    transform.compute(grid(), band(), distance);
    disguise::restart();
    transform.set_positions(mesh().vertices());
    transform.compute(grid(), band(), distance);
    const disguise::Counts counts = disguise::counts();
    BOOST_TEST_MESSAGE(disguise::to_json(counts));
    // And of the vertices of a block, if it has point sites, a group of their records.
    const std::size_t blocks = mesh().vertices().size() / engine::site_block + 1;
    const std::size_t group_bytes = engine::record_group * sizeof(Polyhedron);
    BOOST_TEST(counts.bytes_up <= 24 * mesh().vertices().size() + blocks * group_bytes + 1024);
    BOOST_TEST(counts.blocking_waits <= 4U);
}

// The host sees neither points nor results.
BOOST_AUTO_TEST_CASE(points_and_results_in_memory_of_the_device_stay_there) {
    constexpr std::size_t count = 20000;
    std::mt19937 random(5);
    std::uniform_real_distribution<double> part(-0.1, 1.1);
    std::vector<Vec3> points(count);
    const Box box = mesh().box();
    for (Vec3& p : points)
        for (std::size_t axis = 0; axis < 3; ++axis)
            p[axis] = box.lower[axis] + part(random) * (box.upper[axis] - box.lower[axis]);
    const device::Context& context = device::context_of(test_device());
    const cl::Buffer from(context.context(), CL_MEM_READ_WRITE | CL_MEM_COPY_HOST_PTR, count * sizeof(Vec3),
                          points.data());
    const DeviceMemory to(test_device().context(), count);
    const DistanceTransform transform(test_device(), mesh());
    const InputArray positions(from(), ElementType::float64, count);
    for (int call = 0; call < 2; ++call) {
        disguise::restart();
        transform.query(positions, 1.0, {{Output::distance, to.handle()}});
    }
    const disguise::Counts counts = disguise::counts();
    BOOST_TEST_MESSAGE(disguise::to_json(counts));
    // Kernels count all crossings. The host sees how many points are not usable, and how many signs are open.
    BOOST_TEST(counts.bytes_down == sizeof(PointCells));
    BOOST_TEST(counts.bytes_up == 0U);
    BOOST_TEST(counts.launches <= 40U);
    BOOST_TEST(counts.blocking_waits == 1U);
    BOOST_TEST(counts.allocations == 0U);
    std::vector<float> distance(count);
    transform.query(points, 1.0, distance);
    BOOST_TEST((to.read(context.queue()) == bits_of(distance)));

    // A run of a plan: packed, and by way of memory of the plan.
    PointPlan plan = transform.plan_points(count, 1.0);
    for (const std::size_t skipped : {0U, 1U}) {
        const DeviceMemory memory(test_device().context(), skipped + count);
        OutputArray target = memory.handle();
        target.offset = skipped * sizeof(float);
        context.queue().enqueueFillBuffer(cl::Buffer(memory.handle(), true), cl_uint{0}, 0, sizeof(float));
        context.queue().finish();
        disguise::restart();
        cl_event done = nullptr;
        plan.enqueue(nullptr, positions, target, {}, &done);
        const disguise::Counts of_run = disguise::counts();
        cl::Event(done).wait();
        BOOST_TEST_MESSAGE(disguise::to_json(of_run));
        BOOST_TEST(of_run.blocking_waits == 0U);
        BOOST_TEST(of_run.bytes_up == 0U);
        BOOST_TEST(of_run.bytes_down == 0U);
        BOOST_TEST(of_run.allocations == 0U);
        BOOST_TEST(of_run.first_uses == 0U);
        BOOST_TEST(of_run.launches <= 40U);
        std::vector<std::uint32_t> bits = memory.read(context.queue());
        bits.erase(bits.begin(), bits.begin() + static_cast<std::ptrdiff_t>(skipped));
        BOOST_TEST((bits == bits_of(distance)));
    }
}

// The exact sides of samples stay on the device, and so do the crossings that they are made of.
BOOST_AUTO_TEST_CASE(exact_signs_are_made_on_the_device) {
    const DistanceTransform transform(test_device(), mesh());
    std::vector<float> distance(grid().sample_count()), usual(grid().sample_count());
    transform.compute(grid(), band(), usual);
    transform.compute(grid(), band().with_exact_signs(), distance);
    // The same lattice: sign and lists alone are made.
    const Band other = Band::symmetric(2 * grid().voxel()).with_exact_signs();
    disguise::restart();
    transform.compute(grid(), other, distance);
    disguise::Counts counts = disguise::counts();
    BOOST_TEST_MESSAGE(disguise::to_json(counts));
    BOOST_TEST(counts.kernels["exact_crossings"].runs >= 1U);
    BOOST_TEST(counts.kernels["exact_rows"].runs == 1U);
    BOOST_TEST(!counts.kernels.contains("sign_rows"));
    BOOST_TEST(counts.bytes_up <= 4096U);  // coordinates of samples, and the order of the lists
    BOOST_TEST(counts.bytes_down <= distance.size() * sizeof(float) + 1024U);
    BOOST_TEST(counts.blocking_waits <= 4U);
}

// The host gets the rows of links, or, for a plan, their number.
BOOST_AUTO_TEST_CASE(the_host_gets_the_rows_of_links_alone) {
    const DistanceTransform transform(test_device(), mesh());
    const std::vector<LinkDirection> directions = stencil("D3Q19");
    const std::size_t samples = grid().sample_count();
    transform.links(grid(), directions);
    disguise::restart();
    const Links links = transform.links(grid(), directions);
    disguise::Counts counts = disguise::counts();
    BOOST_TEST_MESSAGE(disguise::to_json(counts));
    const std::size_t row_bytes = 12 + 1 + 8 + 4 + 4 + 1;
    BOOST_TEST(links.size() > 1000U);
    BOOST_TEST(counts.kernels["solve_links"].runs == 1U);
    BOOST_TEST(counts.bytes_down >= row_bytes * links.size() + samples / 8);
    BOOST_TEST(counts.bytes_down <= row_bytes * links.size() + samples / 8 + 1024U);
    BOOST_TEST(counts.bytes_up <= 8192U);
    BOOST_TEST(counts.launches <= 40U);

    disguise::restart();
    BOOST_TEST(transform.count_links(grid(), directions) == links.size());
    counts = disguise::counts();
    BOOST_TEST(!counts.kernels.contains("solve_links"));
    BOOST_TEST(counts.bytes_down <= 128U);

    LinkPlan plan = transform.plan_links(grid(), directions, links.size());
    disguise::restart();
    plan.update(transform);
    counts = disguise::counts();
    BOOST_TEST_MESSAGE(disguise::to_json(counts));
    BOOST_TEST(counts.kernels["solve_links"].runs == 1U);
    BOOST_TEST(counts.bytes_down <= 256U);
    BOOST_TEST(counts.bytes_up <= 8192U);

    const device::Context& context = device::context_of(test_device());
    const DeviceMemory floats(test_device().context(), links.size());
    std::vector<float> expected;
    for (const double q : links.q) expected.push_back(as_float_part(q));
    const LinkTargets targets{.room = links.size(), .q = {floats.handle(), ElementType::float32}};
    disguise::restart();
    std::size_t count = 0;
    transform.links(grid(), directions, targets, count);
    BOOST_TEST(count == links.size());
    BOOST_TEST(disguise::counts().bytes_down <= 256U);
    BOOST_TEST((floats.read(context.queue()) == bits_of(expected)));
    context.queue().enqueueFillBuffer(cl::Buffer(floats.handle(), true), cl_uint{0}, 0, sizeof(float));
    context.queue().finish();
    disguise::restart();
    cl_event done = nullptr;
    plan.enqueue(nullptr, targets, {}, {}, &done);
    counts = disguise::counts();
    cl::Event(done).wait();
    BOOST_TEST(counts.bytes_down + counts.bytes_up == 0U);
    BOOST_TEST(counts.blocking_waits == 0U);
    BOOST_TEST((floats.read(context.queue()) == bits_of(expected)));
}

// Beside the bricks go down a mark for each brick of the grid and the number of each that has values.
BOOST_AUTO_TEST_CASE(the_host_gets_little_more_than_the_bricks_of_a_sparse_field) {
    const DistanceTransform transform(test_device(), mesh());
    const Grid fine = grid_around(mesh(), 200, 5);
    const Band narrow = Band::symmetric(3 * fine.voxel());
    for (const OutputSet outputs : {OutputSet(), OutputSet(Output::gradient)}) {
        transform.compute_sparse(fine, narrow, outputs);
        disguise::restart();
        const SparseField field = transform.compute_sparse(fine, narrow, outputs);
        const disguise::Counts counts = disguise::counts();
        std::size_t bytes = field.bricks.size() * sizeof(Index3);
        for (const OutputInfo& info : output_table()) bytes += field.bytes(info.output).size();
        BOOST_TEST(field.bricks.size() * 20 < fine.sample_count() / 100);
        BOOST_TEST(counts.bytes_down >= field.bytes(Output::distance).size());
        BOOST_TEST(static_cast<double>(counts.bytes_down) <= 1.1 * static_cast<double>(bytes));
    }
}

// NVIDIA's GPUs have 65,535 groups along y and z at most.
BOOST_AUTO_TEST_CASE(a_grid_of_many_slices_or_rows_is_computed_in_several_launches) {
    const Mesh beam = box({0, 0, 0}, {0.5, 0.5, 7000});
    Grid narrow;
    narrow.spacing = {0.1, 0.1, 0.1};
    narrow.origin = {-0.1, -0.1, -0.1};
    narrow.size = {8, 8, 70003};
    for (const Scan scan : {Scan::bricks, Scan::slices, Scan::brute_force})
        for (const bool is_turned : {false, true}) {
            Grid grid = narrow;
            if (is_turned) std::swap(grid.size[1], grid.size[2]);
            const Mesh mesh = is_turned ? moved(beam, [](const Vec3& v) { return Vec3{v[0], v[2], v[1]}; }) : beam;
            BOOST_TEST_CONTEXT(name_of(scan) << ", turned: " << is_turned)
            check_exact(mesh, make_transform(test_device(), mesh, {.scan = scan}).compute(grid, Band::symmetric(0.15)),
                        guaranteed);
        }
}

BOOST_AUTO_TEST_CASE(a_launch_of_bricks_has_at_most_two_to_the_thirty_work_items) {
    engine::CoarseLists lists;
    lists.order.resize((1U << 18) + 1);
    lists.lengths.assign(lists.order.size(), 1);
    lists.pairs = lists.order.size();
    const std::vector<engine::BrickLaunch> launches = engine::launches_of(lists, {1e9});
    BOOST_TEST_REQUIRE(launches.size() == 3U);
    cl_uint begin = 0;
    for (const auto& launch : launches) {
        BOOST_TEST(launch.begin == begin);
        BOOST_TEST(std::uint64_t{launch.end - launch.begin} * 64 * 128 <= std::uint64_t{1} << 30);
        begin = launch.end;
    }
    BOOST_TEST(begin == lists.order.size());
}
