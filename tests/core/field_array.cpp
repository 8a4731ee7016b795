#include <clsdf/field.hpp>

#include <boost/test/unit_test.hpp>

#include <cstddef>
#include <cstdint>
#include <limits>
#include <new>
#include <numeric>
#include <utility>
#include <vector>

using clsdf::FieldArray;

BOOST_AUTO_TEST_CASE(field_arrays_begin_on_a_line_of_memory_and_large_ones_on_a_huge_page) {
    // Below, at and above what is large.
    for (const std::size_t count : {1U, 3U, 1000U, (1U << 20) - 1, 1U << 20, (1U << 20) + 5, 3U << 20}) {
        const FieldArray<float> distance(count);
        const FieldArray<std::uint32_t> triangle(count);
        const std::uintptr_t boundary = count < std::size_t{1} << 20 ? 64 : std::uintptr_t{2} << 20;
        BOOST_TEST_CONTEXT(count << " values") {
            BOOST_TEST(reinterpret_cast<std::uintptr_t>(distance.data()) % boundary == 0U);
            BOOST_TEST(reinterpret_cast<std::uintptr_t>(triangle.data()) % boundary == 0U);
        }
    }
}

BOOST_AUTO_TEST_CASE(field_arrays_keep_their_values_when_they_grow_are_copied_or_move) {
    FieldArray<std::uint32_t> values(1000);
    std::iota(values.begin(), values.end(), 0U);
    values.resize(3U << 20, 7U);  // from small memory into large
    BOOST_TEST(values[999] == 999U);
    BOOST_TEST(values[1000] == 7U);
    BOOST_TEST(values.back() == 7U);
    const std::uint32_t* memory = values.data();
    values.resize(500);
    BOOST_TEST(values.data() == memory);
    BOOST_TEST(values.back() == 499U);
    FieldArray<std::uint32_t> copy = values;
    BOOST_TEST((copy == values));
    copy[3] = 0;
    BOOST_TEST((copy != values));
    FieldArray<std::uint32_t> moved = std::move(values);
    BOOST_TEST(moved.data() == memory);
    BOOST_TEST(values.empty());  // NOLINT(bugprone-use-after-move): which is promised
    moved = copy;
    BOOST_TEST((moved == copy));
    moved = FieldArray<std::uint32_t>{1, 2};
    BOOST_TEST(moved.size() == 2U);
    BOOST_TEST(moved[1] == 2U);
    for (std::uint32_t n = 3; n < 100; ++n) moved.push_back(n);
    moved.append(std::vector<std::uint32_t>{100, 101, 102});
    moved.pop_back();
    std::vector<std::uint32_t> expected(101);
    std::iota(expected.begin(), expected.end(), 1U);
    BOOST_TEST(moved == expected, boost::test_tools::per_element());
}

BOOST_AUTO_TEST_CASE(field_arrays_that_no_memory_can_hold_throw_and_keep_their_values) {
    FieldArray<float> values(10, 1.5F);
    BOOST_CHECK_THROW(values.resize(std::numeric_limits<std::size_t>::max() / 2), std::bad_array_new_length);
    BOOST_CHECK_THROW(values.resize(std::numeric_limits<std::size_t>::max() / 4), std::bad_alloc);
    BOOST_TEST((values == FieldArray<float>(10, 1.5F)));
}
