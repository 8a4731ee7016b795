#include "support/device_memory.hpp"
#include "support/exact_field.hpp"
#include "support/hostile_meshes.hpp"
#include "support/random_meshes.hpp"
#include "support/throws.hpp"

#include <clsdf/tuning.hpp>

#include <algorithm>
#include <array>
#include <cstring>
#include <vector>

// The caller's arrays on the host: of unknown size, with strides that run backwards, and with signed triangles.

using namespace clsdf;
using namespace clsdf::test;

namespace {

constexpr std::array both_bodies{KernelBody::by_vector, KernelBody::by_group};
using Strides = std::array<std::ptrdiff_t, 3>;

const Mesh& mesh() {
    static const Mesh shape = tilted(make_shape("knot"));
    return shape;
}
/// No two sides are equally long.
Grid grid() {
    return grid_around(mesh(), 40, 4).part({2, 3, 5}, {33, 30, 25});
}
Band band() {
    return Band::symmetric(3 * grid().voxel());
}

/// Bytes that hold the samples of a grid, and how they lie in them.
template <typename Value>
struct Memory {
    std::vector<Value> values;
    std::ptrdiff_t first = 0;  ///< index of the first sample's first component
    Strides strides{};         ///< in values
    std::ptrdiff_t component_stride = 1;

    Value& at(std::int64_t i, std::int64_t j, std::int64_t k, std::size_t component) {
        return values[static_cast<std::size_t>(first + i * strides[0] + j * strides[1] + k * strides[2] +
                                               static_cast<std::ptrdiff_t>(component) * component_stride)];
    }
    /// Of unknown size.
    OutputArray target() {
        constexpr std::ptrdiff_t width = sizeof(Value);
        return {values.data() + first,
                {strides[0] * width, strides[1] * width, strides[2] * width},
                component_stride * width};
    }
};

/// Axes that run backwards begin at their end: bit 0 to 2 are x to z, bit 3 the components.
template <typename Value>
Memory<Value> memory_for(const Grid& grid, std::size_t components, const std::array<std::size_t, 3>& order,
                         unsigned backwards, std::ptrdiff_t padding, Value blank) {
    Memory<Value> memory;
    std::ptrdiff_t stride = static_cast<std::ptrdiff_t>(components) + padding;
    const auto turn = [&](std::ptrdiff_t& step, unsigned bit, std::ptrdiff_t count) {
        if ((backwards >> bit & 1U) == 0) return;
        memory.first += step * (count - 1);
        step = -step;
    };
    for (const std::size_t axis : order) {
        memory.strides[axis] = stride;
        stride = stride * grid.size[axis] + padding;
    }
    for (unsigned axis = 0; axis < 3; ++axis) turn(memory.strides[axis], axis, grid.size[axis]);
    turn(memory.component_stride, 3, static_cast<std::ptrdiff_t>(components));
    memory.values.assign(static_cast<std::size_t>(stride), blank);
    return memory;
}

/// How many values of an output differ from the memory's.
template <typename Value>
std::size_t differences(Memory<Value>& memory, const Field& field, Output output) {
    const std::size_t components = info_of(output).components, bytes = info_of(output).sample_bytes() / components;
    BOOST_REQUIRE(bytes == sizeof(Value));
    std::size_t count = 0, value = 0;
    for (std::int64_t k = 0; k < field.grid.size[2]; ++k)
        for (std::int64_t j = 0; j < field.grid.size[1]; ++j)
            for (std::int64_t i = 0; i < field.grid.size[0]; ++i)
                for (std::size_t c = 0; c < components; ++c, ++value)
                    count += std::memcmp(&memory.at(i, j, k, c), &field.bytes(output)[value * bytes], bytes) != 0;
    return count;
}

}  // namespace

BOOST_AUTO_TEST_CASE(arrays_of_unknown_size_and_any_strides_have_the_values_of_packed_ones) {
    constexpr float blank = -77;
    for (const KernelBody body : both_bodies) {
        const DistanceTransform transform(test_device(), mesh(), {.body = body});
        const Grid grid = ::grid();
        const Field expected =
            transform.compute(grid, band(), Output::triangle | Output::gradient | Output::barycentric);
        for (unsigned backwards = 0; backwards < 16; ++backwards)
            for (const std::ptrdiff_t padding : {0, 3}) BOOST_TEST_CONTEXT(backwards << ", padding " << padding) {
                    auto distance = memory_for<float>(grid, 1, {2, 0, 1}, backwards, padding, blank);
                    auto triangle = memory_for<std::uint32_t>(grid, 1, {0, 1, 2}, ~backwards, padding, 7);
                    auto gradient = memory_for<float>(grid, 3, {1, 2, 0}, backwards, padding, blank);
                    auto barycentric = memory_for<float>(grid, 2, {0, 1, 2}, backwards, padding, blank);
                    transform.compute(grid, band(),
                                      {{Output::distance, distance.target()},
                                       {Output::triangle, triangle.target()},
                                       {Output::gradient, gradient.target()},
                                       {Output::barycentric, barycentric.target()}});
                    BOOST_TEST(differences(distance, expected, Output::distance) == 0U);
                    BOOST_TEST(differences(triangle, expected, Output::triangle) == 0U);
                    BOOST_TEST(differences(gradient, expected, Output::gradient) == 0U);
                    BOOST_TEST(differences(barycentric, expected, Output::barycentric) == 0U);
                    const auto unwritten = static_cast<std::size_t>(std::ranges::count(distance.values, blank));
                    BOOST_TEST(unwritten == distance.values.size() - grid.sample_count());
                }
    }
}

BOOST_AUTO_TEST_CASE(requests_and_points_take_arrays_of_unknown_size) {
    const DistanceTransform transform(test_device(), mesh());
    const Grid grid = ::grid();
    const Field expected = transform.compute(grid, band());
    std::vector<float> at_an_address(grid.sample_count());
    transform.compute(grid, band(), at_an_address.data());
    BOOST_TEST(std::ranges::equal(at_an_address, expected.distance()));
    // Whole arrays backwards: the first sample is the last value.
    const std::size_t count = grid.sample_count();
    std::vector<float> packed(count), backwards(count);
    constexpr std::ptrdiff_t width = sizeof(float);
    const Strides negative{-width, -width * grid.size[0], -width * grid.size[0] * grid.size[1]};
    const std::vector<Request> requests{{grid, band(), OutputArray(packed.data())},
                                        {grid, band(), OutputArray(&backwards.back(), negative)}};
    transform.compute(requests);
    BOOST_TEST((bits_of(packed) == bits_of(expected.distance())));
    BOOST_TEST(std::memcmp(std::vector<float>(backwards.rbegin(), backwards.rend()).data(), packed.data(),
                           count * sizeof(float)) == 0);

    Random random(3);
    std::vector<Vec3> points(2000);
    for (Vec3& p : points) p = random.point(-1.5, 1.5);
    const Field at_points = query(transform, points, 0.4);
    std::vector<float> distance(points.size());
    std::vector<double> closest(3 * points.size());
    constexpr std::ptrdiff_t point = 3 * sizeof(double);
    transform.query(points, 0.4,
                    {{Output::distance, OutputArray(&distance.back(), {-width})},
                     {Output::closest, OutputArray(&closest[closest.size() - 3], {-point})}});
    std::size_t wrong = 0;
    for (std::size_t i = 0; i < points.size(); ++i) {
        const std::size_t place = points.size() - 1 - i;
        wrong += std::memcmp(&distance[place], &at_points.distance()[i], sizeof(float)) != 0;
        wrong += std::memcmp(&closest[3 * place], &at_points.closest()[3 * i], 3 * sizeof(double)) != 0;
    }
    BOOST_TEST(wrong == 0U);
}

// Of known size they are held against it.
BOOST_AUTO_TEST_CASE(an_array_written_backwards_is_refused_if_it_begins_too_early) {
    const DistanceTransform transform(test_device(), mesh());
    const Grid grid = ::grid();
    std::vector<float> distance(grid.sample_count());
    constexpr std::ptrdiff_t width = sizeof(float);
    OutputArray array = distance;
    array.strides = {-width, -width * grid.size[0], -width * grid.size[0] * grid.size[1]};
    array.offset = (grid.sample_count() - 2) * sizeof(float);
    check_throws(ErrorCode::invalid_argument, {"distance", "from byte -4"},
                 [&] { transform.compute(grid, band(), array); });
    array.offset += sizeof(float);
    transform.compute(grid, band(), array);
    std::ranges::reverse(distance);
    BOOST_TEST((bits_of(distance) == bits_of(transform.compute(grid, band()).distance())));
}

BOOST_AUTO_TEST_CASE(an_array_on_the_host_and_on_the_device_is_refused) {
    const DistanceTransform transform(test_device(), mesh());
    const DeviceMemory memory(test_device().context(), 100);
    std::vector<float> distance(3);
    std::vector<Vec3> points(3);
    InputArray input(points);
    input.device = memory.handle();
    check_throws(ErrorCode::invalid_argument, {"points", "host and of the device"},
                 [&] { transform.query(input, 1, distance); });
    OutputArray output(distance);
    output.device = memory.handle();
    check_throws(ErrorCode::invalid_argument, {"distance", "host and of the device"},
                 [&] { transform.query(points, 1, output); });
    output.device = nullptr;
    output.strides = {4, 4, 4};
    check_throws(ErrorCode::invalid_argument, {"distance", "points lie in one row"},
                 [&] { transform.query(points, 1, output); });
}

BOOST_AUTO_TEST_CASE(signed_triangles_are_minus_one_beyond_the_band) {
    for (const KernelBody body : both_bodies) {
        const DistanceTransform transform(test_device(), mesh(), {.body = body});
        const Grid grid = ::grid();
        const Field expected = transform.compute(grid, band(), Output::triangle);
        std::vector<float> distance(grid.sample_count());
        std::vector<std::int32_t> triangle(grid.sample_count()), spread(2 * grid.sample_count(), 7);
        transform.compute(grid, band(), {{Output::distance, distance}, {Output::triangle, triangle}});
        const std::ptrdiff_t step = 2 * sizeof(std::int32_t);
        transform.compute(grid, band(),
                          {{Output::distance, distance},
                           {Output::triangle, OutputArray(spread.data(), {step, step * grid.size[0],
                                                                          step * grid.size[0] * grid.size[1]})}});
        std::size_t wrong = 0, beyond = 0;
        for (std::size_t i = 0; i < triangle.size(); ++i) {
            const bool is_beyond = expected.triangle()[i] == no_triangle;
            const std::int32_t right = is_beyond ? -1 : static_cast<std::int32_t>(expected.triangle()[i]);
            wrong += triangle[i] != right || spread[2 * i] != right || spread[2 * i + 1] != 7 ? 1U : 0U;
            beyond += is_beyond ? 1U : 0U;
        }
        BOOST_TEST(wrong == 0U);
        BOOST_TEST((beyond > 0 && beyond < triangle.size()));

        Random random(5);
        std::vector<Vec3> points(500);
        for (Vec3& p : points) p = random.point(-1.5, 1.5);
        const Field at_points = query(transform, points, 0.1);
        distance.resize(points.size());
        triangle.resize(points.size());
        transform.query(points, 0.1, {{Output::distance, distance}, {Output::triangle, triangle}});
        BOOST_TEST(std::ranges::equal(triangle, at_points.triangle(), {},
                                      [](std::int32_t number) { return static_cast<std::uint32_t>(number); }));
        BOOST_TEST(std::ranges::count(triangle, -1) > 0);
    }
}

BOOST_AUTO_TEST_CASE(other_types_of_triangles_are_refused_by_name) {
    const DistanceTransform transform(test_device(), mesh());
    std::vector<float> distance(grid().sample_count());
    std::vector<std::int64_t> triangle(distance.size());
    check_throws(ErrorCode::unsupported, {"output triangle", "int64", "uint32 or int32"}, [&] {
        transform.compute(grid(), band(), {{Output::distance, distance}, {Output::triangle, triangle}});
    });
}
