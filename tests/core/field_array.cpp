#include <clsdf/field_array.hpp>

#include <boost/test/unit_test.hpp>

#include <cstddef>
#include <cstdint>
#include <limits>
#include <new>
#include <numeric>
#include <utility>

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

BOOST_AUTO_TEST_CASE(field_arrays_are_vectors) {
    FieldArray<std::uint32_t> values(1000);
    std::iota(values.begin(), values.end(), 0U);
    values.resize(3U << 20, 7U);  // from small memory into large
    BOOST_TEST(values[999] == 999U);
    BOOST_TEST(values.back() == 7U);
    const FieldArray<std::uint32_t> copy = values;
    BOOST_TEST((copy == values));
    const std::uint32_t* memory = values.data();
    const FieldArray<std::uint32_t> moved = std::move(values);
    BOOST_TEST(moved.data() == memory);
    BOOST_TEST((clsdf::FieldAllocator<float>() == clsdf::FieldAllocator<int>()));
    BOOST_CHECK_THROW(clsdf::FieldAllocator<float>().allocate(std::numeric_limits<std::size_t>::max() / 2),
                      std::bad_array_new_length);
    BOOST_CHECK_THROW(clsdf::FieldAllocator<float>().allocate(std::numeric_limits<std::size_t>::max() / 4),
                      std::bad_alloc);
}
