#include "support/device_memory.hpp"
#include "support/exact_field.hpp"
#include "support/throws.hpp"

#include <array>
#include <random>
#include <vector>

// Arrays of a call that overlap are refused, and hold nothing new; arrays whose values interleave are not.

using namespace clsdf;
using namespace clsdf::test;

namespace {

const DistanceTransform& transform() {
    static const DistanceTransform made(test_device(), make_shape("tetrahedron"));
    return made;
}

const Grid lattice{{-1, -1, -1}, {0.25, 0.25, 0.25}, {8, 8, 8}, {}};
const Grid elsewhere = lattice.block({40, 0, 0}, {8, 8, 8});
const Band band = Band::symmetric(1);
constexpr std::size_t samples = 512;
constexpr float initial = 7;

void refused(const std::vector<Request>& requests, const std::vector<std::string>& words) {
    check_throws(ErrorCode::invalid_argument, words, [&] { transform().compute(requests); });
}

/// A tile of an array with this many values in a row and in a slice.
OutputArray tile(float* first, std::ptrdiff_t row, std::ptrdiff_t slice) {
    return {first, {4, 4 * row, 4 * slice}};
}

}  // namespace

BOOST_AUTO_TEST_CASE(one_array_of_two_requests_is_refused) {
    std::vector<float> one(samples, initial);
    refused({{lattice, band, one}, {elsewhere, band, one}}, {"distance of request 0", "distance of request 1"});
    BOOST_TEST(one == std::vector<float>(samples, initial), boost::test_tools::per_element());
}

BOOST_AUTO_TEST_CASE(arrays_that_share_one_value_are_refused) {
    std::vector<float> all(2 * samples, initial);
    const std::span<float> whole(all);
    refused({{lattice, band, whole.first(samples)}, {elsewhere, band, whole.subspan(samples - 1, samples)}},
            {"request 0", "request 1"});
    transform().compute(
        std::vector<Request>{{lattice, band, whole.first(samples)}, {elsewhere, band, whole.subspan(samples)}});
}

BOOST_AUTO_TEST_CASE(two_outputs_in_one_array_are_refused) {
    std::vector<float> distance(samples), vectors(3 * samples);
    const auto numbers = std::span(reinterpret_cast<std::uint32_t*>(distance.data()), samples);
    check_throws(ErrorCode::invalid_argument, {"distance and triangle"}, [&] {
        transform().compute(lattice, band, {{Output::distance, distance}, {Output::triangle, numbers}});
    });
    const std::vector<Vec3> points(samples);
    check_throws(ErrorCode::invalid_argument, {"gradient and offset"}, [&] {
        transform().query(points, 1,
                          {{Output::distance, distance}, {Output::gradient, vectors}, {Output::offset, vectors}});
    });
}

BOOST_AUTO_TEST_CASE(a_gradient_over_the_distances_of_another_box_is_refused) {
    // A struct of four floats a sample, and the distances of the other box where the first box has a component.
    std::vector<float> all(4 * samples);
    const auto member = [&](std::ptrdiff_t number) { return OutputArray(all.data() + number, {16, 16 * 8, 16 * 64}); };
    std::vector<float> other(samples);
    refused(
        {{lattice, band, {{Output::distance, member(0)}, {Output::gradient, member(1)}}}, {elsewhere, band, member(3)}},
        {"gradient of request 0", "distance of request 1"});
    transform().compute(std::vector<Request>{
        {lattice, band, {{Output::distance, member(0)}, {Output::gradient, member(1)}}}, {elsewhere, band, other}});
}

BOOST_AUTO_TEST_CASE(tiles_of_one_array_may_touch_and_not_overlap) {
    constexpr std::ptrdiff_t row = 24, slice = row * 16;
    std::vector<float> all(static_cast<std::size_t>(slice * 8), initial);
    const auto requests = [&](std::ptrdiff_t second) {
        return std::vector<Request>{{lattice, band, tile(all.data(), row, slice)},
                                    {elsewhere, band, tile(all.data() + second, row, slice)}};
    };
    transform().compute(requests(8));            // beside it
    transform().compute(requests(row * 8));      // above it
    transform().compute(requests(row * 8 - 8));  // diagonally: rows of one begin where those of the other end
    refused(requests(7), {"request 0", "request 1"});
    refused(requests(row * 7), {"request 0", "request 1"});
    refused(requests(-0), {"request 0", "request 1"});
}

BOOST_AUTO_TEST_CASE(arrays_that_run_backwards_are_compared_where_they_lie) {
    std::vector<float> all(2 * samples);
    const auto backwards = [&](std::size_t last) { return OutputArray(all.data() + last, {-4, -32, -256}); };
    transform().compute(std::vector<Request>{{lattice, band, std::span(all).first(samples)},
                                             {elsewhere, band, backwards(2 * samples - 1)}});
    refused({{lattice, band, std::span(all).first(samples)}, {elsewhere, band, backwards(2 * samples - 2)}},
            {"request 0", "request 1"});
}

BOOST_AUTO_TEST_CASE(buffers_of_the_device_are_compared_through_their_parts) {
    const Device device = test_device();
    cl_int code = CL_SUCCESS;
    const cl_mem buffer = clCreateBuffer(device.context(), CL_MEM_READ_WRITE, 2 * samples * 4, nullptr, &code);
    BOOST_REQUIRE(code == CL_SUCCESS);
    const cl_buffer_region half{samples * 4, samples * 4};
    const cl_mem part = clCreateSubBuffer(buffer, CL_MEM_READ_WRITE, CL_BUFFER_CREATE_TYPE_REGION, &half, &code);
    BOOST_REQUIRE(code == CL_SUCCESS);
    OutputArray second(buffer);
    second.offset = samples * 4;
    refused({{lattice, band, part}, {elsewhere, band, second}}, {"request 0", "request 1"});
    transform().compute(std::vector<Request>{{lattice, band, buffer}, {elsewhere, band, part}});

    const std::vector<Request> apart{{lattice, band, buffer}, {elsewhere, band, part}};
    Plan plan = transform().plan(apart);
    const std::vector<OutputTargets> together{buffer, buffer};
    check_throws(ErrorCode::invalid_argument, {"request 0", "request 1"}, [&] { plan.enqueue(nullptr, together); });
    check_throws(ErrorCode::invalid_argument, {"distance and triangle"}, [&] {
        transform()
            .plan(lattice, band, Output::triangle)
            .enqueue(nullptr, {{Output::distance, buffer}, {Output::triangle, buffer}});
    });
    plan.enqueue(nullptr);
    clReleaseMemObject(part);
    clReleaseMemObject(buffer);
}

BOOST_AUTO_TEST_CASE(random_tiles_are_refused_exactly_if_they_overlap) {
    constexpr std::uint32_t seed = 5;
    BOOST_TEST_MESSAGE("seed " << seed);
    std::mt19937 random(seed);
    const auto any = [&](std::ptrdiff_t most) {
        return static_cast<std::ptrdiff_t>(random() % static_cast<std::uint32_t>(most));
    };
    std::size_t refusals = 0;
    for (std::size_t n = 0; n < 300; ++n) {
        const std::ptrdiff_t row = 6 + any(6), slice = row * (4 + any(3));
        std::vector<float> all(static_cast<std::size_t>(slice * 12));
        std::vector<std::size_t> writes(all.size());
        std::vector<Request> requests;
        for (std::int64_t box = 0; box < 3; ++box) {
            const Grid grid = lattice.block({20 * box, 0, 0}, {1 + any(4), 1 + any(4), 1 + any(3)});
            const std::ptrdiff_t first = any(slice * 8);
            requests.push_back({grid, band, tile(all.data() + first, row, slice)});
            for (std::int64_t k = 0; k < grid.size[2]; ++k)
                for (std::int64_t j = 0; j < grid.size[1]; ++j)
                    for (std::int64_t i = 0; i < grid.size[0]; ++i)
                        ++writes[static_cast<std::size_t>(first + i + row * j + slice * k)];
        }
        const bool overlap = std::ranges::any_of(writes, [](std::size_t count) { return count > 1; });
        bool is_refused = false;
        try {
            transform().compute(requests);
        } catch (const Error& error) {
            is_refused = error.code() == ErrorCode::invalid_argument;
        }
        refusals += is_refused;
        BOOST_TEST(is_refused == overlap, "seed " << seed << ", round " << n);
    }
    BOOST_TEST(refusals > 20U);
    BOOST_TEST(refusals < 280U);
}
