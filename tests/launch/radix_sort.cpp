// The radix sort of the device, against std::stable_sort. CLSDF_SORT_BITS is the logarithm of the most keys [20].
#include "support/device_memory.hpp"
#include "support/exact_field.hpp"

#include "device/buffer_pool.hpp"
#include "launch/programs.hpp"
#include "launch/radix_sort.hpp"

#include <clsdf/tuning.hpp>

#include <algorithm>
#include <array>
#include <cstdlib>
#include <functional>
#include <memory>
#include <numeric>
#include <random>
#include <string>
#include <vector>

using namespace clsdf;
using namespace clsdf::test;

namespace {

using Keys = std::vector<std::uint32_t>;

/// Sorts on the device.
Keys sorted_order(const Keys& keys, unsigned bits) {
    device::Context& context = device::context_of(test_device());
    const auto pool = std::make_shared<device::BufferPool>(device::shared_context_of(test_device()));
    const engine::Programs programs(context, KernelBody::by_group);
    const std::size_t bytes = (keys.size() + 1) * sizeof(cl_uint);  // none is empty
    const device::BufferPool::Lease on_device = pool->lease(bytes, "test"), order = pool->lease(bytes, "test");
    if (!keys.empty())
        context.queue().enqueueWriteBuffer(*on_device, CL_TRUE, 0, keys.size() * sizeof(cl_uint), keys.data());
    engine::sort_by_keys({context, pool, programs}, *on_device, keys.size(), bits, *order);
    return read<std::uint32_t>(context, *order, keys.size());
}

void check_sort(const Keys& keys, unsigned bits) {
    Keys expected(keys.size());
    std::iota(expected.begin(), expected.end(), 0U);
    std::stable_sort(expected.begin(), expected.end(),
                     [&](std::uint32_t a, std::uint32_t b) { return keys[a] < keys[b]; });
    BOOST_TEST((sorted_order(keys, bits) == expected));
}

/// Random; each shared by many; random and sorted; the same the other way; all equal; nearly all the greatest, whose
/// digits are those of padding.
enum class Kind { any, repeated, ascending, descending, equal, greatest };
constexpr std::array kinds{Kind::any, Kind::repeated, Kind::ascending, Kind::descending, Kind::equal, Kind::greatest};

Keys keys_of(Kind kind, std::size_t count, std::mt19937& random) {
    Keys keys(count);
    for (std::uint32_t& key : keys) {
        const auto any = static_cast<std::uint32_t>(random());
        key = kind == Kind::repeated   ? any % 37 * 0x01030507U
              : kind == Kind::equal    ? 0x12345678U
              : kind == Kind::greatest ? ~0U - (any % 1000 == 0)
                                       : any;
    }
    if (kind == Kind::any && count > 2) keys[count / 2] = keys.back();
    if (kind == Kind::ascending) std::ranges::sort(keys);
    if (kind == Kind::descending) std::ranges::sort(keys, std::greater());
    return keys;
}

unsigned most_bits() {
    const char* const text = std::getenv("CLSDF_SORT_BITS");
    return text == nullptr ? 20U : static_cast<unsigned>(std::stoul(text));
}

}  // namespace

BOOST_AUTO_TEST_CASE(the_order_is_that_of_a_stable_sort) {
    const unsigned seed = std::random_device()();
    std::mt19937 random(seed);
    for (const std::size_t count : {0U, 1U, 2U, 63U, 64U, 65U, 127U, 128U, 129U, 1023U, 1024U, 1025U, 2047U, 2048U,
                                    2049U, 4096U, 65535U, 262145U + 2048U})  // more tiles than a group has work-items
        for (const Kind kind : kinds)
            BOOST_TEST_CONTEXT("seed " << seed << ", " << count << " keys of kind " << static_cast<int>(kind))
    check_sort(keys_of(kind, count, random), 32);
}

BOOST_AUTO_TEST_CASE(keys_of_few_bits_take_fewer_passes) {
    const unsigned seed = std::random_device()();
    std::mt19937 random(seed);
    for (const unsigned bits : {1U, 7U, 8U, 9U, 16U, 24U, 30U, 31U})
        BOOST_TEST_CONTEXT("seed " << seed << ", " << bits << " bits") {
            Keys keys = keys_of(Kind::any, 5000, random);
            for (std::uint32_t& key : keys) key >>= 32 - bits;
            check_sort(keys, bits);
        }
}

BOOST_AUTO_TEST_CASE(many_keys_are_sorted) {
    const unsigned seed = std::random_device()();
    std::mt19937 random(seed);
    const std::size_t most = std::size_t{1} << most_bits();
    for (const std::size_t count : {most / 2 + 1, most})
        for (const Kind kind : {Kind::any, Kind::repeated})
            BOOST_TEST_CONTEXT("seed " << seed << ", " << count << " keys of kind " << static_cast<int>(kind))
    check_sort(keys_of(kind, count, random), 32);
}
