// Bounds on the calls and bytes of a computation on a GPU, for any mesh and for this one.
#include "disguise/as_gpu.hpp"
#include "support/device_memory.hpp"
#include "support/exact_field.hpp"
#include "support/hostile_meshes.hpp"
#include "support/throws.hpp"

#include <clsdf/papers.hpp>
#include <clsdf/tuning.hpp>

#include "bricks/brick_scan.hpp"
#include "core/parallel.hpp"
#include "device/buffer_pool.hpp"
#include "device/context.hpp"
#include "disguise/disguise.hpp"
#include "point_order.h"

#include <algorithm>
#include <cmath>
#include <random>
#include <set>
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

BOOST_AUTO_TEST_CASE(a_large_field_comes_in_pieces_through_pinned_memory) {
    const Grid fine = grid_around(mesh(), 170, 3);
    const Band narrow = Band::symmetric(2 * fine.voxel());
    const DistanceTransform transform(test_device(), mesh());
    std::vector<float> whole(fine.sample_count());
    const std::size_t pieces = chunk_count(whole.size() * sizeof(float), device::PinnedCopies::piece_bytes);
    BOOST_REQUIRE(pieces > 4U);
    transform.compute(fine, narrow, whole);
    std::fill(whole.begin(), whole.end(), -7.0F);
    disguise::restart();
    transform.compute(fine, narrow, whole);
    const disguise::Counts counts = disguise::counts();
    BOOST_TEST_MESSAGE(disguise::to_json(counts));
    // The lower half comes while the upper one is computed.
    BOOST_TEST(counts.pinned_reads >= pieces);
    BOOST_TEST(counts.pinned_reads <= pieces + 1);
    BOOST_TEST(counts.kernels.at("bricks_by_group").launches == 2U);
    BOOST_TEST(counts.kernels.at("fill_empty_bricks").launches == 2U);
    BOOST_TEST(counts.blocking_waits <= 2U);
    BOOST_TEST(counts.bytes_down <= whole.size() * sizeof(float) + 1024U);
    BOOST_TEST(counts.allocations == 0U);
    // Parts of it are small enough for the driver.
    const std::int64_t depth = fine.size[2];
    for (std::int64_t begin = 0; begin < depth; begin += 16) {
        const Grid part =
            fine.part({0, 0, begin}, {fine.size[0], fine.size[1], std::min<std::int64_t>(16, depth - begin)});
        std::vector<float> distance(part.sample_count());
        transform.compute(part, narrow, distance);
        BOOST_TEST(std::equal(distance.begin(), distance.end(), whole.begin() + begin * (fine.size[0] * fine.size[1])));
    }
}

BOOST_AUTO_TEST_CASE(without_pinned_memory_the_driver_copies) {
    const device::Context& context = device::context_of(test_device());
    std::vector<unsigned char> written(2 * device::PinnedCopies::piece_bytes + 65539), read(written.size());
    for (std::size_t i = 0; i < written.size(); ++i) written[i] = static_cast<unsigned char>(i * 2654435761U >> 13);
    const cl::Buffer buffer(context.context(), CL_MEM_READ_WRITE | CL_MEM_COPY_HOST_PTR, written.size(),
                            written.data());
    device::PinnedCopies reads(context.context(), context.device());
    disguise::restart({.call = "clEnqueueMapBuffer", .number = 1});
    for (const std::uint64_t pinned : {0U, 3U}) {
        std::fill(read.begin(), read.end(), 0);
        reads.read(context.queue(), buffer, 0, read.size(), reinterpret_cast<std::byte*>(read.data()), {});
        BOOST_TEST((read == written));
        BOOST_TEST(disguise::counts().pinned_reads == pinned);
    }
    disguise::restart();
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

BOOST_AUTO_TEST_CASE(a_new_transform_finds_the_memory_of_the_one_before) {
    compute(mesh(), grid(), band());
    compute(mesh(), grid(), band());
    disguise::restart();
    compute(mesh(), grid(), band());
    const disguise::Counts counts = disguise::counts();
    BOOST_TEST_MESSAGE(disguise::to_json(counts));
    // The order of the coarse lists alone is copied when its buffer is made.
    BOOST_TEST(counts.allocations <= 1U);
    BOOST_TEST(counts.first_uses <= 1U);
    // Of another size: its small buffers lie in the memory of the ones before.
    disguise::restart();
    compute(mesh(), grid_around(mesh(), 32, 4), band());
    BOOST_TEST(disguise::counts().allocations <= 1U);
}

// Fresh ones take page faults.
BOOST_AUTO_TEST_CASE(arrays_of_a_call_serve_the_next_one) {
    const Device device = Device::automatic();
    const DistanceTransform transform(device, mesh());
    device.release_memory();
    const std::size_t before = transform.memory().shared_host_bytes;
    std::vector<const float*> arrays;
    for (int call = 0; call < 2; ++call)
        transform.compute(grid(), band(), Output::distance,
                          [&](const Grid&, const FieldSlab& slab) { arrays.push_back(slab.distance().data()); });
    BOOST_REQUIRE(arrays.size() == 2U);
    BOOST_TEST(arrays[0] == arrays[1]);
    BOOST_TEST(transform.memory().shared_host_bytes >= before + grid().sample_count() * sizeof(float));
    device.release_memory();
    BOOST_TEST(transform.memory().shared_host_bytes == 0U);
}

BOOST_AUTO_TEST_CASE(memory_that_is_given_back_is_made_anew) {
    const Device device = Device::automatic();
    std::vector<float> first(grid().sample_count()), again(first.size());
    {
        const DistanceTransform transform(device, mesh());
        transform.compute(grid(), band(), first);
        const KeptMemory memory = transform.memory();
        BOOST_TEST(memory.shared_host_bytes > 0U);
        BOOST_TEST(memory.shared_device_bytes > 0U);
    }
    const std::size_t released = device.release_memory();
    BOOST_TEST(released > std::size_t{1} << 24);
    BOOST_TEST(device.release_memory() == 0U);
    disguise::restart();
    const DistanceTransform transform(device, mesh());
    transform.compute(grid(), band(), again);
    BOOST_TEST(disguise::counts().first_uses > 0U);
    BOOST_TEST((again == first));
    // While a transform has a part of it, the rest of a block stays.
    device.release_memory();
    BOOST_TEST(transform.memory().shared_host_bytes == 0U);
    BOOST_TEST(transform.memory().device_bytes > 0U);
}

BOOST_AUTO_TEST_CASE(a_field_is_read_into_pinned_memory_of_the_caller_at_once) {
    const Grid fine = grid_around(mesh(), 170, 3);
    const Band narrow = Band::symmetric(2 * fine.voxel());
    const DistanceTransform transform(test_device(), mesh());
    std::vector<float> distance(fine.sample_count());
    transform.compute(fine, narrow, distance);
    const device::Context& context = device::context_of(test_device());
    const std::size_t bytes = distance.size() * sizeof(float);
    const cl::Buffer buffer(context.context(), CL_MEM_READ_WRITE | CL_MEM_ALLOC_HOST_PTR, bytes);
    auto* const memory =
        static_cast<float*>(context.queue().enqueueMapBuffer(buffer, CL_TRUE, CL_MAP_READ | CL_MAP_WRITE, 0, bytes));
    OutputArray target(memory);
    target.is_pinned = true;
    disguise::restart();
    transform.compute(fine, narrow, target);
    const disguise::Counts counts = disguise::counts();
    BOOST_TEST_MESSAGE(disguise::to_json(counts));
    BOOST_TEST(counts.transfers_down == 2U);  // the halves
    BOOST_TEST(counts.pinned_reads == 0U);
    BOOST_TEST(counts.pageable_bytes == 0U);
    BOOST_TEST(std::ranges::equal(distance, std::span(memory, distance.size())));
    context.queue().enqueueUnmapMemObject(buffer, memory);
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
    BOOST_TEST(counts.bytes_up <= 24 * mesh().vertices().size() + 4096);
    BOOST_TEST(counts.blocking_waits <= 4U);
}

// The lengths of the lists change in each step, but their buffers are an eighth longer than they need to be. So a step
// allocates only the buffer for the order of the coarse bricks.
BOOST_AUTO_TEST_CASE(a_body_that_turns_finds_the_memory_of_the_step_before) {
    const Mesh body = make_shape("stairs");
    const Grid around = grid_around(body, 90, 12);
    const Band narrow = Band::symmetric(3 * around.voxel());
    DistanceTransform transform(test_device(), body);
    std::vector<float> distance(around.sample_count());
    std::set<std::size_t> lengths;
    const auto step = [&](int number) {
        const double angle = 0.01 * number, c = std::cos(angle), s = std::sin(angle);
        transform.set_motion({{{c, -s, 0}, {s, c, 0}, {0, 0, 1}}}, {});
        disguise::restart();
        lengths.insert(transform.compute(around, narrow, distance).work->coarse_pairs);
    };
    for (int number = 0; number < 3; ++number) step(number);
    lengths.clear();
    for (int number = 3; number < 20; ++number) {
        step(number);
        const disguise::Counts counts = disguise::counts();
        BOOST_TEST(counts.allocations <= 1U);
        BOOST_TEST(counts.allocated_bytes <= 4096U);
    }
    BOOST_TEST(lengths.size() > 10U);
    BOOST_TEST(static_cast<double>(*lengths.rbegin()) < 1.125 * static_cast<double>(*lengths.begin()));
}

BOOST_AUTO_TEST_CASE(the_lattice_that_was_used_last_is_kept) {
    const std::size_t records = 280 * mesh().triangles().size();
    const DistanceTransform transform(test_device(), mesh(),
                                      {.kept_bytes = 52 * mesh().triangles().size() + 5 * records / 2});
    /// Whether the lattice's records were still there.
    const auto finds = [&](int resolution) {
        const Grid at = grid_around(mesh(), resolution, 3);
        std::vector<float> distance(at.sample_count());
        disguise::restart();
        transform.compute(at, Band::symmetric(2 * at.voxel()), distance);
        return !disguise::counts().kernels.contains("sweep_vertices");
    };
    for (const int resolution : {60, 70, 80}) BOOST_TEST(!finds(resolution));  // there is room for two at most
    BOOST_TEST(finds(80));
    BOOST_TEST(!finds(60));
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

namespace {

/// Nothing was waited for, allocated or moved since the counts began.
void check_nothing_moved() {
    const disguise::Counts counts = disguise::counts();
    BOOST_TEST(counts.blocking_waits == 0U);
    BOOST_TEST(counts.allocations == 0U);
    BOOST_TEST(counts.first_uses == 0U);
    BOOST_TEST(counts.bytes_up == 0U);
    BOOST_TEST(counts.bytes_down == 0U);
}

/// Nothing moved; at the run's end the memory holds the field, behind `skipped` elements.
void check_quiet_run(const cl::Event& end, const DeviceMemory& memory, std::size_t skipped = 0) {
    check_nothing_moved();
    end.wait();
    std::vector<std::uint32_t> bits = memory.read(device::context_of(test_device()).queue());
    bits.erase(bits.begin(), bits.begin() + static_cast<std::ptrdiff_t>(skipped));
    BOOST_TEST((bits == bits_of(compute(mesh(), grid(), band()).distance())));
}

}  // namespace

BOOST_AUTO_TEST_CASE(a_plan_neither_waits_nor_moves_what_it_has) {
    DistanceTransform transform(test_device(), mesh());
    for (const std::size_t skipped : {0U, 1U}) {  // in place, and by way of memory of the plan
        const DeviceMemory memory(test_device().context(), skipped + grid().sample_count());
        OutputArray target = memory.handle();
        target.offset = skipped * sizeof(float);
        Plan plan = skipped == 0 ? transform.plan(grid(), band()) : transform.plan({grid(), band(), target});
        disguise::restart();
        plan.enqueue(nullptr, target);
        cl::Event second;
        plan.enqueue(nullptr, target, {}, &second());
        check_quiet_run(second, memory, skipped);
    }
}

BOOST_AUTO_TEST_CASE(a_plan_of_boxes_neither_waits_nor_moves_what_it_has) {
    const DistanceTransform transform(test_device(), mesh());
    const DeviceMemory memory(test_device().context(), grid().sample_count());
    std::vector<Request> requests;
    for (std::int64_t z = 0; z < grid().size[2]; ++z) {
        const Grid slice = grid().part({0, 0, z}, {grid().size[0], grid().size[1], 1});
        OutputArray target = memory.handle();
        target.offset = sizeof(float) * slice.sample_count() * static_cast<std::size_t>(z);
        requests.push_back({slice, band(), target});
    }
    Plan plan = transform.plan(requests);
    disguise::restart();
    plan.enqueue(nullptr);
    cl::Event second;
    plan.enqueue(nullptr, std::span<const cl_event>(), &second());
    check_quiet_run(second, memory);
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

BOOST_AUTO_TEST_CASE(a_plan_of_a_sparse_field_neither_waits_nor_moves_what_it_has) {
    const DistanceTransform transform(test_device(), mesh());
    const SparseField field = transform.compute_sparse(grid(), band());
    const SparseCounts room{field.bricks.size(), field.inside.size() + 1};
    const DeviceMemory counts(test_device().context(), sizeof(DeviceSparseCounts) / sizeof(cl_uint)),
        bricks(test_device().context(), room.bricks * sizeof(Index3) / sizeof(cl_uint)),
        inside(test_device().context(), room.runs * sizeof(BrickRun) / sizeof(cl_uint)),
        distance(test_device().context(), room.bricks * brick_samples);
    const SparseDeviceTargets targets{{counts.handle()}, {bricks.handle()}, {inside.handle()}, distance.handle()};
    SparsePlan plan = transform.plan_sparse({grid(), band()}, room);
    disguise::restart();
    plan.enqueue(nullptr, targets);
    cl::Event end;
    plan.enqueue(nullptr, targets, {}, &end());
    check_nothing_moved();
    end.wait();
    BOOST_TEST((distance.read(device::context_of(test_device()).queue()) == bits_of(field.distance())));
}

// Drivers that allocate a buffer at its first use would fail when a plan is enqueued.
BOOST_AUTO_TEST_CASE(a_lack_of_memory_appears_when_a_plan_is_made) {
    const DeviceMemory memory(test_device().context(), grid().sample_count());
    const auto pool = std::make_shared<device::BufferPool>(device::shared_context_of(test_device()));
    device::context_of(test_device()).arena().release();
    disguise::Settings settings = as_gpu;
    settings.memory = 0;
    disguise::set(settings);
    const DistanceTransform transform(test_device(), mesh());  // the host makes the topology
    check_throws(ErrorCode::out_of_memory, {"CL_MEM_OBJECT_ALLOCATION_FAILURE", "smaller part"},
                 [&] { pool->lease(1000, "test"); });
    BOOST_TEST(!pool->lease_if_it_fits(1000, "test"));
    check_throws(ErrorCode::out_of_memory, {"smaller part"}, [&] { transform.plan(grid(), band()); });
    disguise::set(as_gpu);
    Plan plan = transform.plan(grid(), band());
    disguise::restart();
    cl::Event end;
    plan.enqueue(nullptr, memory.handle(), {}, &end());
    check_quiet_run(end, memory);
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

// The call that fails is named, and the plan computes the same field afterwards.
BOOST_AUTO_TEST_CASE(a_plan_survives_each_call_that_fails_while_it_is_enqueued) {
    DistanceTransform transform(test_device(), mesh());
    const DeviceMemory memory(test_device().context(), grid().sample_count());
    const cl::CommandQueue queue(device::context_of(test_device()).context(),
                                 device::context_of(test_device()).device(), CL_QUEUE_OUT_OF_ORDER_EXEC_MODE_ENABLE);
    // In place, and by way of memory of the plan.
    const auto run = [&](Plan& plan, const OutputArray& to) {
        cl::Event end;
        plan.enqueue(queue(), to, {}, &end());
        end.wait();
    };
    OutputArray turned;
    const auto rows = static_cast<std::ptrdiff_t>(sizeof(float)) * grid().size[2];
    turned.strides = {rows * grid().size[1], rows, sizeof(float)};
    for (const bool in_place : {true, false}) {
        const auto target = [&](const DeviceMemory& of) {
            OutputArray result = in_place ? OutputArray() : turned;
            result.device = of.handle();
            return result;
        };
        Plan plan = in_place ? transform.plan(grid(), band()) : transform.plan({grid(), band(), target(memory)});
        disguise::restart();
        run(plan, target(memory));
        const std::uint64_t calls = disguise::counts().all_calls - 1;  // without the wait
        const std::vector<std::uint32_t> expected = memory.read(queue);
        for (std::uint64_t number = 1; number <= calls; ++number) {
            disguise::restart({.number = number});
            try {
                run(plan, target(memory));
                // Without the event's state the plan waits for the event.
                BOOST_TEST(disguise::counts().failed == "clGetEventInfo");
            } catch (const Error& error) {
                BOOST_TEST_CONTEXT(error.what())
                BOOST_TEST(std::string(error.what()).find(disguise::counts().failed) != std::string::npos);
            }
            disguise::restart();
            const DeviceMemory other(test_device().context(), grid().sample_count());
            run(plan, target(other));
            BOOST_TEST((other.read(queue) == expected));
        }
    }
}

// Its commands may still use the buffer.
BOOST_AUTO_TEST_CASE(a_lease_of_a_lost_device_is_not_given_to_another) {
    const Device device = Device::automatic();
    const device::Context& context = device::context_of(device);
    const auto pool = std::make_shared<device::BufferPool>(device::shared_context_of(device));
    cl_mem first = nullptr;
    {
        const device::BufferPool::Lease lease = pool->lease(10000, "test");
        first = (*lease)();
        disguise::restart({.call = "clFinish", .number = 1});
        BOOST_TEST(!context.drain());
        disguise::restart();
    }
    BOOST_TEST((*pool->lease(10000, "test"))() != first);
}
