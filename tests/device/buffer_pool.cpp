#include "support/throws.hpp"

#include <clsdf/device.hpp>

#include "device/buffer_pool.hpp"

#include <chrono>
#include <memory>
#include <optional>
#include <thread>
#include <vector>

using namespace clsdf;
using device::BufferPool;
using namespace std::chrono_literals;

namespace {

std::shared_ptr<BufferPool> new_pool() {
    return std::make_shared<BufferPool>(device::shared_context_of(Device::strongest()));
}

}  // namespace

BOOST_AUTO_TEST_CASE(a_buffer_that_was_given_back_serves_the_next_lease) {
    const auto pool = new_pool();
    cl_mem first = nullptr;
    {
        const BufferPool::Lease lease = pool->lease(10000, "test");
        first = (*lease)();
    }
    const BufferPool::Lease again = pool->lease(9000, "test");
    BOOST_TEST((*again)() == first);
    BOOST_TEST(again.bytes() >= 9000U);
}

BOOST_AUTO_TEST_CASE(two_leases_never_share_a_buffer) {
    const auto pool = new_pool();
    const BufferPool::Lease one = pool->lease(10000, "test");
    const BufferPool::Lease other = pool->lease(10000, "test");
    BOOST_TEST((*one)() != (*other)());
}

BOOST_AUTO_TEST_CASE(a_small_lease_does_not_take_a_large_buffer) {
    const auto pool = new_pool();
    cl_mem large = nullptr;
    {
        const BufferPool::Lease lease = pool->lease(1 << 24, "test");
        large = (*lease)();
    }
    const BufferPool::Lease small = pool->lease(64, "test");
    BOOST_TEST((*small)() != large);
}

BOOST_AUTO_TEST_CASE(pools_beside_each_other_share_the_devices_memory) {
    const Device device = Device::strongest().limited({.memory = 1 << 20});
    const auto pool = std::make_shared<BufferPool>(device::shared_context_of(device));
    const auto other = pool->beside();
    std::optional<BufferPool::Lease> lease = pool->lease(600'000, "test");
    test::check_throws(ErrorCode::out_of_memory, {"600000 bytes", "1048576"}, [&] { other->lease(600'000, "test"); });
    lease.reset();
    pool->release();
    BOOST_TEST(other->lease(600'000, "test").bytes() >= 600'000U);
}

BOOST_AUTO_TEST_CASE(a_lease_of_nothing_is_a_buffer_all_the_same) {
    const BufferPool::Lease lease = new_pool()->lease(0, "test");
    BOOST_TEST((*lease)() != nullptr);
}

BOOST_AUTO_TEST_CASE(a_lease_outlives_its_pool_and_ends_on_another_thread) {
    BufferPool::Lease lease = new_pool()->lease(1000, "test");
    const cl::Buffer buffer = *lease;
    const cl_uint held = buffer.getInfo<CL_MEM_REFERENCE_COUNT>();
    std::thread([moved = std::move(lease)]() mutable { BufferPool::Lease last = std::move(moved); }).join();
    BOOST_TEST(buffer.getInfo<CL_MEM_REFERENCE_COUNT>() < held);
}

BOOST_AUTO_TEST_CASE(more_than_the_device_allocates_at_once_is_refused_by_name) {
    const auto pool = new_pool();
    const std::size_t largest = device::context_of(Device::strongest()).capabilities().largest_allocation;
    test::check_throws(ErrorCode::out_of_memory,
                       {"coarse lists", std::to_string(largest + 1), std::to_string(largest), "smaller part"},
                       [&] { pool->lease(largest + 1, "coarse lists"); });
}

BOOST_AUTO_TEST_CASE(what_was_not_used_since_the_last_trim_is_released) {
    const auto pool = new_pool();
    cl::Buffer buffer;
    {
        const BufferPool::Lease lease = pool->lease(1000, "test");
        buffer = *lease;
    }
    const auto references = [&] { return buffer.getInfo<CL_MEM_REFERENCE_COUNT>(); };
    const cl_uint held = references();
    pool->trim();
    BOOST_TEST(references() == held);
    pool->trim();
    BOOST_TEST(references() == held - 1);
}

BOOST_AUTO_TEST_CASE(the_hosts_memory_under_a_buffer_lives_until_no_command_uses_it) {
    const device::Context& context = device::context_of(Device::strongest());
    const cl::CommandQueue queue(context.context(), context.device());
    constexpr std::size_t count = 1000;
    auto values = std::make_shared<const std::vector<cl_uint>>(count, 7U);
    const std::weak_ptr<const std::vector<cl_uint>> watched = values;
    cl::Buffer buffer = device::buffer_in(context, std::shared_ptr<const void>(values, values->data()),
                                          count * sizeof(cl_uint), CL_MEM_READ_ONLY);
    const cl::UserEvent gate(context.context());
    const std::vector<cl::Event> before{gate};
    std::vector<cl_uint> copies(count);
    queue.enqueueReadBuffer(buffer, CL_FALSE, 0, count * sizeof(cl_uint), copies.data(), &before);
    buffer = {};
    values.reset();
    BOOST_TEST(!watched.expired());
    cl::UserEvent(gate).setStatus(CL_COMPLETE);
    queue.finish();
    BOOST_TEST((copies == std::vector<cl_uint>(count, 7U)));
    // A driver may release the buffer a little later.
    for (int wait = 0; wait < 1000 && !watched.expired(); ++wait) std::this_thread::sleep_for(10ms);
    BOOST_TEST(watched.expired());
}
