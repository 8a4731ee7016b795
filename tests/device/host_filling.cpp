#include "device/buffer_pool.hpp"

#include "core/large_memory.hpp"

#include <clsdf/device.hpp>

#include <boost/test/unit_test.hpp>

#include <array>
#include <span>
#include <stdexcept>
#include <vector>

using namespace clsdf;
using device::BufferPool;
using device::HostFilling;

namespace {

/// Small, with pages to spare, and large enough for huge pages.
constexpr std::array<std::size_t, 3> sizes{1, 10000, large_memory_bytes + 12345};

void fill(const HostFilling& filling, std::size_t bytes, unsigned seed) {
    const std::span values(static_cast<unsigned char*>(filling.memory()), bytes);
    for (std::size_t i = 0; i < bytes; ++i) values[i] = static_cast<unsigned char>((i * 7 + i / 251 + seed) & 255U);
}

bool is_filled(const Device& device, const BufferPool::Lease& buffer, std::size_t bytes, unsigned seed) {
    std::vector<unsigned char> values(bytes);
    device::context_of(device).queue().enqueueReadBuffer(*buffer, CL_TRUE, 0, bytes, values.data());
    for (std::size_t i = 0; i < bytes; ++i)
        if (values[i] != static_cast<unsigned char>((i * 7 + i / 251 + seed) & 255U)) return false;
    return true;
}

}  // namespace

BOOST_AUTO_TEST_CASE(a_buffer_holds_what_the_host_filled_in_by_either_way) {
    const Device device = Device::strongest();
    const auto pool = std::make_shared<BufferPool>(device::shared_context_of(device));
    for (const std::size_t bytes : sizes)
        for (const bool in_place : {true, false}) {
            HostFilling filling(device::context_of(device), pool, bytes, "test", in_place);
            const unsigned seed = in_place ? 1 : 2;
            fill(filling, bytes, seed);
            BOOST_TEST(is_filled(device, filling.finish(), bytes, seed));
        }
}

BOOST_AUTO_TEST_CASE(a_buffer_of_nothing_is_filled_all_the_same) {
    const Device device = Device::strongest();
    const auto pool = std::make_shared<BufferPool>(device::shared_context_of(device));
    for (const bool in_place : {true, false}) {
        HostFilling filling(device::context_of(device), pool, 0, "test", in_place);
        BOOST_TEST((*filling.finish())() != nullptr);
    }
}

BOOST_AUTO_TEST_CASE(a_filling_that_ends_early_leaves_its_buffer_to_the_next) {
    const Device device = Device::strongest();
    for (const std::size_t bytes : sizes)
        for (const bool in_place : {true, false}) {
            const auto pool = std::make_shared<BufferPool>(device::shared_context_of(device));
            const auto fail = [&] {
                const HostFilling filling(device::context_of(device), pool, bytes, "test", in_place);
                fill(filling, bytes, 3);
                throw std::runtime_error("halfway");
            };
            BOOST_CHECK_THROW(fail(), std::runtime_error);
            HostFilling filling(device::context_of(device), pool, bytes, "test", in_place);
            fill(filling, bytes, 4);
            BOOST_TEST(is_filled(device, filling.finish(), bytes, 4));
            BOOST_TEST(pool->peak() < bytes + 64);
        }
}

// If a larger buffer is needed, the values of the smaller one are copied.
BOOST_AUTO_TEST_CASE(a_filling_that_is_not_in_place_takes_no_buffer_before_it_ends) {
    const Device device = Device::strongest();
    const auto pool = std::make_shared<BufferPool>(device::shared_context_of(device));
    const HostFilling smaller(device::context_of(device), pool, 10000, "test", false);
    HostFilling larger(device::context_of(device), pool, 20000, "test", false);
    BOOST_TEST(pool->peak() == 0U);
    fill(larger, 20000, 5);
    BOOST_TEST(is_filled(device, larger.finish(), 20000, 5));
    BOOST_TEST(pool->peak() == 20000U);
}
