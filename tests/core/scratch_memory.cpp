#include "core/scratch_memory.hpp"

#include "core/large_memory.hpp"

#include <boost/test/unit_test.hpp>

#include <limits>
#include <new>

using clsdf::large_memory_bytes;
using clsdf::ScratchMemory;

namespace {

void use(ScratchMemory& scratch, std::size_t bytes) {
    scratch.give_back(scratch.allocate(bytes));
}

void compute(ScratchMemory& scratch, std::size_t bytes, bool succeeds) {
    ScratchMemory::Computation computation(scratch);
    use(scratch, bytes);
    if (succeeds) computation.succeed();
}

}  // namespace

BOOST_AUTO_TEST_SUITE(scratch_memory)

BOOST_AUTO_TEST_CASE(what_was_given_back_serves_the_next_array_of_about_that_size) {
    ScratchMemory scratch;
    void* const first = scratch.allocate(3 * large_memory_bytes);
    scratch.give_back(first);
    void* const smaller = scratch.allocate(2 * large_memory_bytes);
    BOOST_TEST(smaller == first);
    scratch.give_back(smaller);
    void* const small = scratch.allocate(large_memory_bytes);
    BOOST_TEST(small != first);
    void* const larger = scratch.allocate(4 * large_memory_bytes);
    BOOST_TEST(larger != first);
    BOOST_TEST(scratch.bytes() == 8 * large_memory_bytes);
    scratch.give_back(small);
    scratch.give_back(larger);
}

BOOST_AUTO_TEST_CASE(the_smallest_that_is_large_enough_is_taken) {
    ScratchMemory scratch;
    void* const large = scratch.allocate(4 * large_memory_bytes);
    void* const right = scratch.allocate(3 * large_memory_bytes);
    scratch.give_back(large);
    scratch.give_back(right);
    BOOST_TEST(scratch.allocate(3 * large_memory_bytes) == right);
    scratch.give_back(right);
}

BOOST_AUTO_TEST_CASE(two_arrays_never_share_memory) {
    ScratchMemory scratch;
    void* const one = scratch.allocate(large_memory_bytes);
    void* const other = scratch.allocate(large_memory_bytes);
    BOOST_TEST(one != other);
    scratch.give_back(one);
    scratch.give_back(other);
}

BOOST_AUTO_TEST_CASE(what_was_not_used_since_the_last_trim_is_released) {
    ScratchMemory scratch;
    use(scratch, large_memory_bytes);
    use(scratch, 4 * large_memory_bytes);
    scratch.trim();
    BOOST_TEST(scratch.bytes() == 5 * large_memory_bytes);
    use(scratch, large_memory_bytes);
    scratch.trim();
    BOOST_TEST(scratch.bytes() == large_memory_bytes);
    scratch.trim();
    BOOST_TEST(scratch.bytes() == 0U);
}

BOOST_AUTO_TEST_CASE(what_is_in_use_is_not_released) {
    ScratchMemory scratch;
    void* const used = scratch.allocate(large_memory_bytes);
    use(scratch, 4 * large_memory_bytes);
    scratch.release();
    BOOST_TEST(scratch.bytes() == large_memory_bytes);
    scratch.trim();
    scratch.trim();
    BOOST_TEST(scratch.bytes() == large_memory_bytes);
    scratch.give_back(used);
    scratch.release();
    BOOST_TEST(scratch.bytes() == 0U);
}

BOOST_AUTO_TEST_CASE(only_a_computation_that_is_repeated_keeps_memory) {
    ScratchMemory scratch;
    compute(scratch, large_memory_bytes, true);
    BOOST_TEST(scratch.bytes() == 0U);
    for (int again = 0; again < 2; ++again) {
        compute(scratch, large_memory_bytes, true);
        BOOST_TEST(scratch.bytes() == large_memory_bytes);
    }
    compute(scratch, 4 * large_memory_bytes, true);
    BOOST_TEST(scratch.bytes() == 4 * large_memory_bytes);
}

BOOST_AUTO_TEST_CASE(a_computation_that_fails_keeps_nothing) {
    ScratchMemory scratch;
    for (const bool succeeds : {true, true, false}) compute(scratch, large_memory_bytes, succeeds);
    BOOST_TEST(scratch.bytes() == 0U);
}

BOOST_AUTO_TEST_CASE(what_cannot_be_had_leaves_the_rest_as_it_was) {
    ScratchMemory scratch;
    use(scratch, large_memory_bytes);
    BOOST_CHECK_THROW(scratch.allocate(std::numeric_limits<std::size_t>::max()), std::bad_alloc);
    BOOST_TEST(scratch.bytes() == large_memory_bytes);
}

BOOST_AUTO_TEST_SUITE_END()
