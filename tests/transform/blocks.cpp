#include "support/device_memory.hpp"
#include "support/exact_field.hpp"
#include "support/random_meshes.hpp"
#include "support/throws.hpp"

#include "device/context.hpp"

#include <clsdf/tuning.hpp>

#include <algorithm>
#include <array>
#include <cstring>
#include <vector>

// Equal blocks of one lattice in one call: each has the bytes of a call of its own.

using namespace clsdf;
using namespace clsdf::test;

namespace {

constexpr std::array both_bodies{KernelBody::by_vector, KernelBody::by_group};

const Mesh& mesh() {
    static const Mesh shape = make_shape("knot");
    return shape;
}
const Grid& lattice() {
    static const Grid grid = grid_around(mesh(), 60, 4);
    return grid;
}
Band band() {
    return Band::symmetric(3 * lattice().voxel());
}

/// Anywhere on the lattice, also before and beyond the mesh; some of them share samples.
std::vector<Index3> random_places(std::size_t count) {
    Random random(31);
    std::vector<Index3> places(count);
    for (Index3& place : places)
        for (std::size_t axis = 0; axis < 3; ++axis)
            place[axis] = lattice().first[axis] - 8 +
                          static_cast<std::int64_t>(random.index(static_cast<std::size_t>(lattice().size[axis]) + 8));
    return places;
}

/// Whether values have the bytes of a block's output.
template <typename Value>
bool are_bytes_of(std::span<const Value> values, const Field& field, Output output) {
    return std::ranges::equal(std::as_bytes(values), field.bytes(output));
}

}  // namespace

BOOST_AUTO_TEST_CASE(packed_blocks_have_the_bytes_of_calls_of_their_own) {
    const std::vector<Index3> places = random_places(50);
    const Index3 size{9, 7, 5};
    constexpr std::size_t samples = 9 * 7 * 5;
    const OutputSet outputs = Output::triangle | Output::site | Output::closest | Output::gradient;
    for (const KernelBody body : both_bodies) {
        const DistanceTransform transform(test_device(), mesh(), {.body = body});
        std::vector<float> distance(samples * places.size()), gradient(3 * distance.size());
        std::vector<std::uint32_t> triangle(distance.size());
        std::vector<std::uint8_t> site(distance.size());
        std::vector<Vec3> closest(distance.size());
        const TransformStatistics statistics = transform.compute(BlockSet{lattice(),
                                                                          band(),
                                                                          size,
                                                                          places,
                                                                          {{Output::distance, distance},
                                                                           {Output::triangle, triangle},
                                                                           {Output::site, site},
                                                                           {Output::closest, closest},
                                                                           {Output::gradient, gradient}}});
        BOOST_TEST(statistics.slabs > 0U);
        std::size_t in_band = 0;
        for (std::size_t n = 0; n < places.size(); ++n) {
            const Field field = transform.compute(lattice().block(places[n], size), band(), outputs);
            const auto part = [&](const auto& values, std::size_t components = 1) {
                using Value = typename std::remove_cvref_t<decltype(values)>::value_type;
                return std::span<const Value>(values).subspan(n * components * samples, components * samples);
            };
            BOOST_TEST_CONTEXT("block " << n) {
                BOOST_TEST(are_bytes_of(part(distance), field, Output::distance));
                BOOST_TEST(are_bytes_of(part(triangle), field, Output::triangle));
                BOOST_TEST(are_bytes_of(part(site), field, Output::site));
                BOOST_TEST(are_bytes_of(part(closest), field, Output::closest));
                BOOST_TEST(are_bytes_of(part(gradient, 3), field, Output::gradient));
            }
            in_band += samples - static_cast<std::size_t>(std::ranges::count(field.triangle(), no_triangle));
        }
        BOOST_TEST(in_band > 1000U);
    }
}

// Blocks with ghost samples around them, which stay as they are; z runs fastest, and all x of a gradient lie before all
// y.
BOOST_AUTO_TEST_CASE(blocks_have_strides_and_a_stride_from_block_to_block) {
    const std::vector<Index3> places = random_places(40);
    const Index3 size{6, 5, 4};
    const DistanceTransform transform(test_device(), mesh());
    constexpr std::ptrdiff_t width = sizeof(float);
    constexpr std::size_t padded = 8 * 7 * 6, before = 3 * padded;
    constexpr float blank = -77;
    const auto at = [](std::int64_t i, std::int64_t j, std::int64_t k) {
        return static_cast<std::size_t>((k + 1) + 6 * ((j + 1) + 7 * (i + 1)));
    };
    std::vector<float> distance(before + places.size() * padded, blank);
    std::vector<float> gradient(3 * places.size() * padded, blank);
    for (const bool is_backwards : {false, true}) {
        std::ranges::fill(distance, blank);
        std::ranges::fill(gradient, blank);
        OutputArray distances = distance, gradients = gradient;
        for (OutputArray* array : {&distances, &gradients}) array->strides = {42 * width, 6 * width, width};
        const std::size_t last = places.size() - 1;
        const auto sign = is_backwards ? std::ptrdiff_t{-1} : std::ptrdiff_t{1};
        distances.offset = sizeof(float) * (before + at(0, 0, 0) + (is_backwards ? last * padded : 0));
        distances.block_stride = sign * static_cast<std::ptrdiff_t>(padded) * width;
        gradients.offset = sizeof(float) * (at(0, 0, 0) + (is_backwards ? last * 3 * padded : 0));
        gradients.block_stride = sign * static_cast<std::ptrdiff_t>(3 * padded) * width;
        gradients.component_stride = static_cast<std::ptrdiff_t>(padded) * width;
        transform.compute(
            {lattice(), band(), size, places, {{Output::distance, distances}, {Output::gradient, gradients}}});
        std::size_t written = 0, wrong = 0;
        for (std::size_t n = 0; n < places.size(); ++n) {
            const Field field = transform.compute(lattice().block(places[n], size), band(), Output::gradient);
            const std::size_t place = is_backwards ? last - n : n;
            for (std::int64_t k = 0; k < size[2]; ++k)
                for (std::int64_t j = 0; j < size[1]; ++j)
                    for (std::int64_t i = 0; i < size[0]; ++i, ++written) {
                        const std::size_t sample = field.grid.offset(i, j, k);
                        const auto differs = [&](const float& one, const float& other) {
                            return std::memcmp(&one, &other, sizeof one) != 0 ? 1U : 0U;
                        };
                        wrong += differs(distance[before + place * padded + at(i, j, k)], field.distance()[sample]);
                        for (std::size_t c = 0; c < 3; ++c)
                            wrong += differs(gradient[(3 * place + c) * padded + at(i, j, k)],
                                             field.gradient()[3 * sample + c]);
                    }
        }
        BOOST_TEST(wrong == 0U);
        BOOST_TEST(static_cast<std::size_t>(std::ranges::count(distance, blank)) == distance.size() - written);
        BOOST_TEST(static_cast<std::size_t>(std::ranges::count(gradient, blank)) == gradient.size() - 3 * written);
    }
}

// One sample each, in an order of their own.
BOOST_AUTO_TEST_CASE(more_blocks_than_are_computed_at_once_have_the_bytes_of_the_whole) {
    const Mesh sphere = make_shape("sphere2");
    const DistanceTransform transform(test_device(), sphere);
    const Grid grid = grid_around(sphere, 35, 2);
    const Band narrow = Band::symmetric(2 * grid.voxel());
    const Field whole = transform.compute(grid, narrow, Output::triangle);
    std::vector<Index3> places;
    for (std::int64_t i = grid.size[0] - 1; i >= 0; --i)
        for (std::int64_t k = 0; k < grid.size[2]; ++k)
            for (std::int64_t j = 0; j < grid.size[1]; ++j)
                places.push_back({grid.first[0] + i, grid.first[1] + j, grid.first[2] + k});
    BOOST_REQUIRE(places.size() > 40'000U);
    std::vector<float> distance(places.size());
    std::vector<std::uint32_t> triangle(places.size());
    std::vector<double> seen;
    const TransformStatistics statistics = transform.compute(
        {grid, narrow, {1, 1, 1}, places, {{Output::distance, distance}, {Output::triangle, triangle}}},
        {.progress = when_computing([&](double fraction) { seen.push_back(fraction); })});
    std::size_t wrong = 0;
    for (std::size_t n = 0; n < places.size(); ++n) {
        const std::size_t sample =
            grid.offset(places[n][0] - grid.first[0], places[n][1] - grid.first[1], places[n][2] - grid.first[2]);
        wrong += std::memcmp(&distance[n], &whole.distance()[sample], sizeof(float)) != 0 ? 1U : 0U;
        wrong += triangle[n] != whole.triangle()[sample] ? 1U : 0U;
    }
    BOOST_TEST(wrong == 0U);
    BOOST_TEST(statistics.slabs < places.size() / 100);
    BOOST_TEST(std::ranges::is_sorted(seen));
    BOOST_TEST(seen.front() == 0);
    BOOST_TEST(seen.back() == 1);

    // The array is one for all of them.
    std::vector<float> small(places.size() - 1);
    check_throws(ErrorCode::invalid_argument, {std::to_string(places.size()) + " blocks", "distance"}, [&] {
        transform.compute({grid, narrow, {1, 1, 1}, places, small});
    });

    // From the last one on backwards.
    std::vector<float> backwards(places.size());
    OutputArray reversed(backwards);
    reversed.offset = sizeof(float) * (places.size() - 1);
    reversed.block_stride = -static_cast<std::ptrdiff_t>(sizeof(float));
    transform.compute({grid, narrow, {1, 1, 1}, places, reversed});
    BOOST_TEST(std::equal(distance.begin(), distance.end(), backwards.rbegin()));

    // If a block is refused, none is computed.
    const std::vector<float> before(places.size(), -7);
    distance = before;
    const std::string last = std::to_string(places.size() - 1);
    OutputArray triangles(reinterpret_cast<std::uint32_t*>(&distance.back()));  // the first block's on the last's
    check_throws(ErrorCode::invalid_argument, {"triangle of request 0", "distance of request " + last, "same bytes"},
                 [&] {
                     transform.compute({grid,
                                        narrow,
                                        {1, 1, 1},
                                        places,
                                        {{Output::distance, OutputArray(distance)}, {Output::triangle, triangles}}});
                 });
    places.back()[1] = std::int64_t{1} << 31;
    check_throws(ErrorCode::invalid_argument, {"request " + last + " of " + std::to_string(places.size())}, [&] {
        transform.compute({grid, narrow, {1, 1, 1}, places, distance});
    });
    BOOST_TEST(distance == before, boost::test_tools::per_element());
}

BOOST_AUTO_TEST_CASE(distances_of_blocks_may_be_doubles_and_their_arrays_of_unknown_size) {
    const std::vector<Index3> places = random_places(20);
    const Index3 size{5, 5, 5};
    const DistanceTransform transform(test_device(), mesh());
    std::vector<double> doubles(125 * places.size()), of_unknown_size(doubles.size()), expected(doubles.size());
    transform.compute({lattice(), band(), size, places, doubles});
    transform.compute({lattice(), band(), size, places, OutputArray(of_unknown_size.data())});
    for (std::size_t n = 0; n < places.size(); ++n)
        transform.compute(lattice().block(places[n], size), band(), std::span(expected).subspan(125 * n, 125));
    BOOST_TEST(std::memcmp(doubles.data(), expected.data(), expected.size() * sizeof(double)) == 0);
    BOOST_TEST(std::memcmp(of_unknown_size.data(), expected.data(), expected.size() * sizeof(double)) == 0);
}

BOOST_AUTO_TEST_CASE(blocks_may_go_to_memory_of_the_device) {
    const std::vector<Index3> places = random_places(30);
    const Index3 size{6, 5, 4};
    constexpr std::size_t samples = 6 * 5 * 4;
    for (const KernelBody body : both_bodies) {
        const DistanceTransform transform(test_device(), mesh(), {.body = body});
        const DeviceMemory distance(test_device().context(), samples * places.size()),
            triangle(test_device().context(), samples * places.size());
        transform.compute({lattice(),
                           band(),
                           size,
                           places,
                           {{Output::distance, distance.handle()}, {Output::triangle, triangle.handle()}}});
        std::vector<float> expected(samples * places.size());
        std::vector<std::uint32_t> triangles(expected.size());
        transform.compute(
            {lattice(), band(), size, places, {{Output::distance, expected}, {Output::triangle, triangles}}});
        const cl::CommandQueue& queue = device::context_of(test_device()).queue();
        BOOST_TEST((distance.read(queue) == bits_of(expected)));
        BOOST_TEST((triangle.read(queue) == triangles));
        const DeviceMemory planned(test_device().context(), samples * places.size());
        transform.plan({lattice(), band(), size, places, planned.handle()}).enqueue(queue());
        BOOST_TEST((planned.read(queue) == bits_of(expected)));
    }
}

BOOST_AUTO_TEST_CASE(arrays_that_blocks_do_not_fit_are_refused) {
    const std::vector<Index3> places = random_places(4);
    const Index3 size{3, 3, 3};
    const DistanceTransform transform(test_device(), mesh());
    std::vector<float> distance(27 * 4), gradient(3 * 27 * 4);
    std::vector<std::uint32_t> triangle(27 * 4 - 1);
    const auto refused = [&](const OutputTargets& targets, const std::vector<std::string>& words) {
        check_throws(ErrorCode::invalid_argument, words, [&] {
            transform.compute({lattice(), band(), size, places, targets});
        });
    };
    check_throws(ErrorCode::invalid_argument, {"distance has two targets"}, [&] {
        static_cast<void>(OutputTargets{{Output::distance, distance}, {Output::distance, distance}});
    });
    refused({{Output::distance, distance}, {Output::triangle, triangle}},
            {"4 blocks of 27 samples", "432 bytes", "triangle", "428"});
    refused(OutputTargets(), {"distance has no target"});
    OutputArray array = distance;
    array.strides = {4, 12, 36};
    refused(array, {"distance", "block stride"});
    array.block_stride = -27 * 4;
    refused(array, {"distance", "-108", "before its memory"});
    array.offset = 2 * 27 * 4;
    refused(array, {"distance", "before its memory"});
    array.offset = 3 * 27 * 4;
    BOOST_CHECK_NO_THROW(transform.compute({lattice(), band(), size, places, array}));
    array.offset = 0;
    array.block_stride = 28 * 4;
    refused(array, {"request 3 of 4", "distance", "its memory holds 432 bytes"});
    array.block_stride = 26 * 4;
    refused(array, {"distance of request 0 and distance of request 1", "the same bytes"});
    OutputArray planes = gradient;
    planes.component_stride = 27 * 4;
    refused({{Output::distance, distance}, {Output::gradient, planes}}, {"gradient", "block stride"});
    for (const Index3& wrong : {Index3{0, 3, 3}, Index3{3, -1, 3}, Index3{}})
        check_throws(ErrorCode::invalid_argument, {"samples along", "at least one"}, [&] {
            transform.compute({lattice(), band(), wrong, places, distance});
        });
    check_throws(ErrorCode::invalid_argument, {"band"}, [&] {
        transform.compute({lattice(), Band{}, size, places, distance});
    });
    std::vector<Index3> far = places;
    far[2][0] = std::int64_t{1} << 31;
    check_throws(ErrorCode::invalid_argument, {"request 2 of 4"}, [&] {
        transform.compute({lattice(), band(), size, far, distance});
    });
}

BOOST_AUTO_TEST_CASE(no_block_is_no_error) {
    const DistanceTransform transform(test_device(), mesh());
    std::vector<float> nothing;
    BOOST_TEST(transform.compute({lattice(), band(), {8, 8, 8}, {}, nothing}).slabs == 0U);
    BOOST_CHECK_NO_THROW(transform.compute(BlockSet{}));
}
