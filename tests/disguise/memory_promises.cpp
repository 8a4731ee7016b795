// Memory of a GPU, and pinned memory of the host, that calls keep and find again.
#include "disguise/as_gpu.hpp"
#include "support/exact_field.hpp"
#include "support/hostile_meshes.hpp"

#include "core/parallel.hpp"
#include "device/buffer_pool.hpp"
#include "device/context.hpp"
#include "disguise/disguise.hpp"

#include <algorithm>
#include <memory>
#include <set>
#include <span>
#include <vector>

using namespace clsdf;
using namespace clsdf::test;

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
