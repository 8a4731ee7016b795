#include "support/exact_field.hpp"
#include "support/random_meshes.hpp"
#include "support/test_meshes.hpp"
#include "support/throws.hpp"

#include <clsdf/distance_transform.hpp>
#include <clsdf/tuning.hpp>

#include <algorithm>
#include <vector>

// Many boxes in one call: what is shared, refused and told. That each has the bytes of a call of its own:
// same_bytes.cpp.

using namespace clsdf;
using namespace clsdf::test;

namespace {

/// A field for each request, and the requests that write into them.
struct Boxes {
    std::vector<Field> fields;

    void add(const Grid& grid, const Band& band, OutputSet outputs = {}) {
        fields.emplace_back(FieldDescription{grid, band, SignRule::none, {}}, Output::distance | outputs);
    }

    std::vector<Request> requests() {
        std::vector<Request> result;
        for (Field& field : fields) result.push_back({field.grid, field.band, field.targets()});
        return result;
    }
};

}  // namespace

// The first of them get polyhedra of their own; later ones share those of the lattice, and select from them.
BOOST_AUTO_TEST_CASE(small_grids_one_after_the_other_have_the_bytes_of_the_whole) {
    constexpr std::uint64_t seed = 20261124;
    BOOST_TEST_MESSAGE("seed " << seed);
    Random random(seed);
    const Mesh mesh = make_shape("sphere5");
    const Grid grid = grid_around(mesh, 96, 4);
    const Band narrow = Band::symmetric(3 * grid.voxel()), wide = Band::symmetric(25 * grid.voxel());
    for (const Band& band : {narrow, wide}) {
        const OutputSet outputs = Output::triangle;
        const Field whole = DistanceTransform(test_device(), mesh).compute(grid, band, outputs);
        const DistanceTransform kept(test_device(), mesh), forgetful(test_device(), mesh, {.kept_bytes = 0});
        for (int n = 0; n < 60; ++n) {
            Index3 first{}, size{};
            for (std::size_t axis = 0; axis < 3; ++axis) {
                size[axis] = 1 + static_cast<std::int64_t>(random.index(20));
                first[axis] =
                    static_cast<std::int64_t>(random.index(static_cast<std::size_t>(grid.size[axis] - size[axis])));
            }
            const Grid part = grid.part(first, size);
            for (const DistanceTransform* transform : {&kept, &forgetful})
                BOOST_TEST(same_bytes(transform->compute(part, band, outputs), part_of(whole, part)));
        }
        BOOST_TEST(kept.memory().device_bytes > 280 * mesh.triangles().size());
        BOOST_TEST(forgetful.memory().device_bytes == 0U);
    }
}

// All patches of a grid together are the grid, and are computed as one block.
BOOST_AUTO_TEST_CASE(patches_that_fill_a_grid_are_computed_once) {
    const Mesh mesh = make_shape("sphere4");
    const DistanceTransform transform(test_device(), mesh);
    const Grid grid = grid_around(mesh, 64, 4).block({-32, -32, -32}, {64, 64, 64});
    const Band band = Band::symmetric(3 * grid.voxel());
    Boxes boxes;
    for (std::int64_t z = 0; z < 64; z += 16)
        for (std::int64_t y = 0; y < 64; y += 16)
            for (std::int64_t x = 0; x < 64; x += 16) boxes.add(grid.part({x, y, z}, {16, 16, 16}).grown(2), band);
    BOOST_TEST(transform.compute(boxes.requests()).slabs == 1U);
}

// Each box goes to its place in one array with ghost samples around it, which stay as they are.
BOOST_AUTO_TEST_CASE(boxes_are_written_into_blocks_of_larger_arrays) {
    const Mesh mesh = make_shape("sphere3");
    const DistanceTransform transform(test_device(), mesh);
    const Grid grid = grid_around(mesh, 24, 2);
    const Band band = Band::symmetric(4 * grid.voxel());
    const Field whole = transform.compute(grid, band);
    const std::ptrdiff_t row = grid.size[0] + 3, slice = row * (grid.size[1] + 2);
    std::vector<float> array(static_cast<std::size_t>(slice * (grid.size[2] + 1)), 77);
    std::vector<Request> requests;
    constexpr std::int64_t side = 7;
    for (std::int64_t z = 0; z < grid.size[2]; z += side)
        for (std::int64_t y = 0; y < grid.size[1]; y += side)
            for (std::int64_t x = 0; x < grid.size[0]; x += side) {
                const Index3 size{std::min(side, grid.size[0] - x), std::min(side, grid.size[1] - y),
                                  std::min(side, grid.size[2] - z)};
                OutputArray target = array;
                target.offset = sizeof(float) * static_cast<std::size_t>(x + y * row + z * slice);
                target.strides = {4, 4 * row, 4 * slice};
                requests.push_back({grid.part({x, y, z}, size), band, target});
            }
    transform.compute(requests);
    std::size_t written = 0;
    for (std::int64_t z = 0; z < grid.size[2]; ++z)
        for (std::int64_t y = 0; y < grid.size[1]; ++y)
            for (std::int64_t x = 0; x < grid.size[0]; ++x, ++written)
                BOOST_REQUIRE(array[static_cast<std::size_t>(x + y * row + z * slice)] == whole.distance()[written]);
    BOOST_TEST(static_cast<std::size_t>(std::count(array.begin(), array.end(), 77.0F)) == array.size() - written);
}

BOOST_AUTO_TEST_CASE(a_request_that_is_refused_is_named_and_nothing_is_computed) {
    const Mesh mesh = make_shape("sphere2");
    const DistanceTransform transform(test_device(), mesh);
    const Grid grid = grid_around(mesh, 8, 1);
    Boxes boxes;
    for (int n = 0; n < 3; ++n) boxes.add(grid, Band::symmetric(0.1));
    for (Field& field : boxes.fields) std::fill(field.distance().begin(), field.distance().end(), 77.0F);
    std::vector<Request> requests = boxes.requests();
    requests[2].band = {};
    check_throws(ErrorCode::invalid_argument, {"request 2 of 3: band: the half widths are nan"},
                 [&] { transform.compute(requests); });
    requests = boxes.requests();
    requests[1].targets[Output::distance].bytes -= 4;
    check_throws(ErrorCode::invalid_argument, {"request 1 of 3: the grid has"}, [&] { transform.compute(requests); });
    requests = boxes.requests();
    requests[0].grid.size[1] = 0;
    check_throws(ErrorCode::invalid_argument, {"request 0 of 3: grid"}, [&] { transform.compute(requests); });
    requests = boxes.requests();
    requests[2].grid.first[0] = std::int64_t{1} << 30;
    check_throws(ErrorCode::invalid_argument, {"request 2 of 3: the grid's samples"},
                 [&] { transform.compute(requests); });
    for (const Field& field : boxes.fields)
        for (const float value : field.distance()) BOOST_REQUIRE(value == 77.0F);
    transform.compute(std::span<const Request>());
}

BOOST_AUTO_TEST_CASE(progress_of_many_boxes_rises_to_one_and_a_call_can_be_stopped) {
    const Mesh mesh = make_shape("sphere4");
    const DistanceTransform transform(test_device(), mesh);
    const Grid lattice = grid_around(mesh, 40, 2);
    Boxes boxes;
    for (std::int64_t n = 0; n < 6; ++n) boxes.add(lattice.block({4000 * n, 0, 0}, {20, 20, 20}), Band::symmetric(0.1));
    double latest = 0;
    const auto progress = when_computing([&](double fraction) {
        BOOST_TEST(fraction >= latest);
        latest = fraction;
    });
    transform.compute(boxes.requests(), {.progress = progress});
    BOOST_TEST(latest == 1);
    latest = 0;
    const auto should_stop = [&] { return latest > 0.3; };
    check_throws(ErrorCode::cancelled, {"cancelled"},
                 [&] { transform.compute(boxes.requests(), {.progress = progress, .should_stop = should_stop}); });
}
