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

}  // namespace

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
