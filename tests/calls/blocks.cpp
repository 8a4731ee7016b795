#include "support/exact_field.hpp"
#include "support/random_meshes.hpp"
#include "support/throws.hpp"

#include <clsdf/tuning.hpp>

#include <algorithm>
#include <cstring>
#include <vector>

// Equal blocks of one lattice in one call: any number of them, and arrays that are refused. That each has the bytes of
// a call of its own: same_bytes.cpp.

using namespace clsdf;
using namespace clsdf::test;

namespace {

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

}  // namespace

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
