#include "support/exact_field.hpp"
#include "support/hostile_meshes.hpp"
#include "support/open_meshes.hpp"
#include "support/random_meshes.hpp"
#include "support/throws.hpp"

#include "core/outputs.hpp"

#include <clsdf/papers.hpp>
#include <clsdf/tuning.hpp>

#include <algorithm>
#include <array>
#include <bit>
#include <cstring>
#include <map>
#include <thread>
#include <vector>

// A sparse field has the bricks that it promises, and together with the sign of the rest the bytes of the dense field.

using namespace clsdf;
using namespace clsdf::test;

namespace {

/// Sample n of a brick.
Index3 in_brick(const Index3& brick, std::size_t n) {
    const auto at = static_cast<std::int64_t>(n);
    return {brick[0] + at % 8, brick[1] + at / 8 % 8, brick[2] + at / 64};
}

std::size_t offset_in(const Grid& grid, const Index3& sample) {
    return grid.offset(sample[0] - grid.first[0], sample[1] - grid.first[1], sample[2] - grid.first[2]);
}

bool holds(const Grid& grid, const Index3& sample) {
    for (std::size_t axis = 0; axis < 3; ++axis)
        if (sample[axis] < grid.first[axis] || sample[axis] >= grid.first[axis] + grid.size[axis]) return false;
    return true;
}

/// The bricks of the grid, in the order of sparse fields.
std::vector<Index3> bricks_of(const Grid& grid) {
    std::vector<Index3> bricks;
    const Grid whole = in_whole_bricks(grid);
    Index3 at{};
    for (at[2] = whole.first[2]; at[2] < whole.first[2] + whole.size[2]; at[2] += 8)
        for (at[1] = whole.first[1]; at[1] < whole.first[1] + whole.size[1]; at[1] += 8)
            for (at[0] = whole.first[0]; at[0] < whole.first[0] + whole.size[0]; at[0] += 8) bricks.push_back(at);
    return bricks;
}

/// The sparse field that a dense one of whole bricks, with all outputs, has.
struct Expected {
    std::vector<Index3> bricks;
    std::vector<BrickRun> inside;
};

Expected expected_of(const Field& dense) {
    Expected expected;
    for (const Index3& brick : bricks_of(dense.grid)) {
        bool is_in_band = false;
        std::size_t negative = 0;
        for (std::size_t n = 0; n < brick_samples; ++n) {
            const std::size_t at = offset_in(dense.grid, in_brick(brick, n));
            is_in_band = is_in_band || dense.triangle()[at] != no_triangle;
            negative += std::signbit(dense.distance()[at]) ? 1U : 0U;
        }
        if (is_in_band || (negative > 0 && negative < brick_samples)) {
            expected.bricks.push_back(brick);
        } else if (negative > 0) {
            if (!expected.inside.empty()) {
                BrickRun& last = expected.inside.back();
                if (brick[1] == last.first[1] && brick[2] == last.first[2] &&
                    brick[0] == last.first[0] + 8 * last.count) {
                    ++last.count;
                    continue;
                }
            }
            expected.inside.push_back({brick, 1});
        }
    }
    return expected;
}

bool is_all_ones(std::span<const std::byte> bytes) {
    return std::ranges::all_of(bytes, [](std::byte value) { return value == std::byte{0xFF}; });
}

/// sparse: of a grid whose dense field is `dense`, rounded out to whole bricks, with all outputs.
void check_same(const SparseField& sparse, const Field& dense) {
    const Expected expected = expected_of(dense);
    BOOST_TEST((sparse.bricks == expected.bricks));
    BOOST_TEST((sparse.inside == expected.inside));
    std::size_t wrong = 0;
    for (const OutputInfo& info : output_table()) {
        if (!sparse.outputs().contains(info.output)) continue;
        const std::size_t bytes = info.sample_bytes();
        const std::span<const std::byte> values = sparse.bytes(info.output);
        BOOST_REQUIRE(values.size() == sparse.bricks.size() * brick_samples * bytes);
        for (std::size_t b = 0; b < sparse.bricks.size(); ++b)
            for (std::size_t n = 0; n < brick_samples; ++n)
                wrong += std::memcmp(values.data() + (b * brick_samples + n) * bytes,
                                     dense.bytes(info.output).data() +
                                         offset_in(dense.grid, in_brick(sparse.bricks[b], n)) * bytes,
                                     bytes) == 0
                             ? 0U
                             : 1U;
        BOOST_TEST(wrong == 0U, wrong << " samples of bricks differ in " << info.name);
    }
    wrong = 0;
    for (const Index3& brick : bricks_of(dense.grid))
        for (std::size_t n = 0; n < brick_samples; ++n) {
            const Index3 sample = in_brick(brick, n);
            const std::size_t at = offset_in(dense.grid, sample);
            wrong += std::bit_cast<std::uint32_t>(sparse.distance_at(sample)) ==
                             std::bit_cast<std::uint32_t>(dense.distance()[at])
                         ? 0U
                         : 1U;
            if (sparse.find(sample)) continue;
            for (const OutputInfo& info : output_table())
                if (info.output != Output::distance)
                    wrong +=
                        is_all_ones(dense.bytes(info.output).subspan(at * info.sample_bytes(), info.sample_bytes()))
                            ? 0U
                            : 1U;
        }
    BOOST_TEST(wrong == 0U, wrong << " samples differ from the dense field");
}

void check_sparse(const DistanceTransform& transform, const Grid& grid, const Band& band, OutputSet outputs) {
    const Field dense = transform.compute(in_whole_bricks(grid), band, all_outputs());
    const SparseField sparse = transform.compute_sparse(grid, band, outputs);
    BOOST_TEST((sparse.grid == grid));
    if (!sparse.bricks.empty()) BOOST_TEST((sparse.outputs() == (outputs | Output::distance)));
    check_same(sparse, dense);
}

/// The grid around the mesh, with its first sample at this index of the lattice.
Grid lattice_around(const Mesh& mesh, std::int64_t resolution, double margin, const Index3& first) {
    Grid grid = grid_around(mesh, resolution, margin);
    for (std::size_t axis = 0; axis < 3; ++axis)
        grid.origin[axis] -= grid.spacing[axis] * static_cast<double>(first[axis]);
    grid.first = first;
    return grid;
}

const Mesh& sphere() {
    static const Mesh mesh = [] {
        Random random(11);
        return random_sphere(random, "sphere3", 0.2);
    }();
    return mesh;
}

}  // namespace

BOOST_AUTO_TEST_CASE(every_sample_has_the_bytes_of_the_dense_field) {
    const std::vector<Mesh> meshes{sphere(), tilted(box({0, 0, 0}, {1, 2, 3})), make_shape("knot"), plate(0.01)};
    for (const KernelBody body : {KernelBody::by_vector, KernelBody::by_group})
        for (const Mesh& mesh : meshes) {
            const DistanceTransform transform(test_device(), mesh, {.body = body});
            for (const Index3& first : {Index3{0, 0, 0}, Index3{-21, 5, 3}}) {
                const Grid grid = lattice_around(mesh, 44, 6, first);
                const double h = grid.voxel();
                for (const Band& band : {Band{3 * h, 3 * h}, Band{0.5 * h, 5 * h}, Band{6 * h, 0}, Band{0, 2.5 * h}})
                    BOOST_TEST_CONTEXT(mesh.name() << ", first sample " << first[0] << ", band " << band.inside / h
                                                   << " " << band.outside / h)
                check_sparse(transform, grid, band, Output::distance);
            }
        }
}

BOOST_AUTO_TEST_CASE(all_outputs_have_the_bytes_of_the_dense_field) {
    for (const KernelBody body : {KernelBody::by_vector, KernelBody::by_group}) {
        const Grid grid = lattice_around(sphere(), 50, 6, {3, 1, -4});
        check_sparse(DistanceTransform(test_device(), sphere(), {.body = body}), grid,
                     {2 * grid.voxel(), 3 * grid.voxel()}, all_outputs());
        check_sparse(DistanceTransform(test_device(), sphere(), {.body = body}), grid,
                     {2 * grid.voxel(), 3 * grid.voxel()}, Output::triangle);
    }
}

// Groups share these lists, and bricks are listed by the groups that join their minima.
BOOST_AUTO_TEST_CASE(long_lists_have_the_bytes_of_the_dense_field) {
    const DistanceTransform transform(test_device(), scaled(make_shape("sphere5"), 5), {.body = KernelBody::by_group});
    check_sparse(transform, grid_at({0, 0, 0}, 1, 12), Band::symmetric(2), Output::triangle);
    check_sparse(transform, grid_at({0, 0, 0}, 1, 12), Band::symmetric(2), {});
}

// The samples of whole layers have the distance of the half width exactly: they are in the band, with a triangle.
BOOST_AUTO_TEST_CASE(the_limits_of_the_band_belong_to_it) {
    for (const KernelBody body : {KernelBody::by_vector, KernelBody::by_group}) {
        const DistanceTransform transform(test_device(), cube(16), {.body = body});
        check_sparse(transform, grid_at({0, 0, 0}, 1, 40), Band::symmetric(4), all_outputs());
        check_sparse(transform, grid_at({0, 0, 0}, 1, 40), Band::symmetric(1e-3), all_outputs());
    }
}

// The surface passes between the samples, and the sign of an open mesh changes at its film, far from it.
BOOST_AUTO_TEST_CASE(bricks_of_both_signs_have_values) {
    for (const KernelBody body : {KernelBody::by_vector, KernelBody::by_group}) {
        const Grid grid = lattice_around(sphere(), 40, 4, {1, 2, 3});
        check_sparse(DistanceTransform(test_device(), sphere(), {.body = body}), grid,
                     Band::symmetric(1e-4 * grid.voxel()), Output::distance);
        const Mesh open = open_box({0, 0, 0}, {1, 1, 1}, 0);
        const DistanceTransform transform(test_device(), open, {.sign = SignRule::solid_angle, .body = body});
        const Grid around = lattice_around(open, 70, 10, {0, 0, 0});
        const Band band = Band::symmetric(2 * around.voxel());
        check_sparse(transform, around, band, all_outputs());
        const Field dense = transform.compute(in_whole_bricks(around), band, all_outputs());
        const SparseField sparse = transform.compute_sparse(around, band);
        std::size_t far = 0;
        for (const Index3& brick : sparse.bricks) {
            bool has_band = false;
            for (std::size_t n = 0; n < brick_samples; ++n)
                has_band = has_band || dense.triangle()[offset_in(dense.grid, in_brick(brick, n))] != no_triangle;
            far += has_band ? 0 : 1;
        }
        BOOST_TEST(far > 0U);
    }
}

BOOST_AUTO_TEST_CASE(a_field_without_a_sign_has_no_inside) {
    const DistanceTransform transform(test_device(), sphere(), {.sign = SignRule::none});
    const Grid grid = lattice_around(sphere(), 60, 6, {0, 7, 0});
    const Band band{std::numeric_limits<double>::infinity(), 2 * grid.voxel()};
    check_sparse(transform, grid, band, all_outputs());
    BOOST_TEST(transform.compute_sparse(grid, band).inside.empty());
}

BOOST_AUTO_TEST_CASE(unequal_spacings_have_the_bytes_of_the_dense_field) {
    Grid grid = lattice_around(sphere(), 40, 4, {0, 0, 0});
    grid.spacing[2] *= 1.7;
    grid.size[2] = grid.size[2] * 10 / 17;
    check_sparse(DistanceTransform(test_device(), sphere()), grid, Band::symmetric(3 * grid.voxel()), all_outputs());
}

BOOST_AUTO_TEST_CASE(the_bricks_of_a_part_are_bricks_of_the_whole) {
    const DistanceTransform transform(test_device(), sphere());
    const Grid grid = lattice_around(sphere(), 90, 5, {-3, 0, 2});
    const Band band = Band::symmetric(3 * grid.voxel());
    const SparseField whole = transform.compute_sparse(grid, band, Output::triangle);
    std::map<Index3, std::size_t> numbers;
    for (std::size_t n = 0; n < whole.bricks.size(); ++n) numbers[whole.bricks[n]] = n;
    for (const auto& [offset, size] : {std::pair<Index3, Index3>({0, 0, 0}, {90, 3, 50}),
                                       {{11, 20, 17}, {33, 29, 31}},
                                       {{40, 40, 40}, {1, 1, 1}},
                                       {{5, 5, 5}, {11, 11, 11}}}) {
        Index3 within = size;
        for (std::size_t axis = 0; axis < 3; ++axis)
            within[axis] = std::min(size[axis], grid.size[axis] - offset[axis]);
        const Grid part = grid.part(offset, within);
        const SparseField sparse = transform.compute_sparse(part, band, Output::triangle);
        std::size_t of_whole = 0;
        for (const Index3& brick : whole.bricks) of_whole += holds(in_whole_bricks(part), brick) ? 1U : 0U;
        BOOST_TEST(sparse.bricks.size() == of_whole);
        for (std::size_t n = 0; n < sparse.bricks.size(); ++n) {
            BOOST_REQUIRE(numbers.contains(sparse.bricks[n]));
            for (const Output output : {Output::distance, Output::triangle}) {
                const std::size_t bytes = brick_samples * info_of(output).sample_bytes();
                BOOST_TEST(std::memcmp(sparse.bytes(output).data() + n * bytes,
                                       whole.bytes(output).data() + numbers[sparse.bricks[n]] * bytes, bytes) == 0);
            }
        }
        for (std::int64_t k = 0; k < part.size[2]; k += 3)
            for (std::int64_t i = 0; i < part.size[0]; ++i) {
                const Index3 sample{part.first[0] + i, part.first[1], part.first[2] + k};
                BOOST_TEST((std::bit_cast<std::uint32_t>(sparse.distance_at(sample)) ==
                            std::bit_cast<std::uint32_t>(whole.distance_at(sample))));
            }
    }
}

BOOST_AUTO_TEST_CASE(a_sink_gets_the_layers_in_order) {
    // With little memory there are several slabs.
    const Grid grid = lattice_around(make_shape("sphere5"), 200, 4, {-5, 0, 11});
    const Band band = Band::symmetric(3 * grid.voxel());
    const DistanceTransform transform(test_device(), make_shape("sphere5"));
    const SparseField whole = transform.compute_sparse(grid, band, Output::closest);
    const DistanceTransform small(test_device().limited({.memory = std::size_t{26} << 20}), make_shape("sphere5"));
    SparseField joined;
    std::int64_t next = in_whole_bricks(grid).first[2];
    std::size_t slabs = 0;
    const TransformStatistics statistics =
        small.compute_sparse(grid, band, Output::closest, [&](const SparseSlab& slab) {
            BOOST_TEST(slab.part.first[2] == next);
            next += slab.part.size[2];
            for (const OutputInfo& info : infos_of(Output::closest)) {
                const std::size_t before = joined.bytes(info.output).size();
                const std::size_t count = joined.bricks.size() + slab.bricks.size();
                const std::span<const std::byte> values = slab.values.bytes(info.output);
                std::memcpy(joined.resize(info.output, count).data() + before, values.data(), values.size());
            }
            joined.bricks.insert(joined.bricks.end(), slab.bricks.begin(), slab.bricks.end());
            joined.inside.insert(joined.inside.end(), slab.inside.begin(), slab.inside.end());
            ++slabs;
        });
    BOOST_TEST(next == in_whole_bricks(grid).first[2] + in_whole_bricks(grid).size[2]);
    BOOST_TEST(slabs > 1U);
    BOOST_TEST(statistics.slabs == slabs);
    BOOST_TEST((joined.bricks == whole.bricks));
    BOOST_TEST((joined.inside == whole.inside));
    BOOST_TEST(same_bytes(joined.values(), whole.values(), Output::distance));
    BOOST_TEST(same_bytes(joined.values(), whole.values(), Output::closest));
}

// The first guess is 24 bricks for each coarse brick that polyhedra overlap.
BOOST_AUTO_TEST_CASE(a_wide_band_has_more_bricks_than_expected) {
    const DistanceTransform transform(test_device(), sphere());
    const Grid grid = lattice_around(sphere(), 100, 4, {0, 0, 0});
    check_sparse(transform, grid, Band::symmetric(40 * grid.voxel()), Output::triangle);
}

BOOST_AUTO_TEST_CASE(threads_and_later_calls_get_the_same_bytes) {
    const DistanceTransform transform(test_device(), sphere());
    const Grid grid = lattice_around(sphere(), 70, 5, {0, 0, 0});
    const Band band = Band::symmetric(3 * grid.voxel());
    const SparseField first = transform.compute_sparse(grid, band);
    std::vector<SparseField> fields(4);
    std::vector<std::thread> threads;
    for (SparseField& field : fields) threads.emplace_back([&] { field = transform.compute_sparse(grid, band); });
    for (std::thread& thread : threads) thread.join();
    for (const SparseField& field : fields) {
        BOOST_TEST((field.bricks == first.bricks));
        BOOST_TEST((field.inside == first.inside));
        BOOST_TEST(same_bytes(field.values(), first.values(), Output::distance));
    }
    // The dense field takes the plan that the sparse one has kept.
    check_same(first, transform.compute(in_whole_bricks(grid), band, all_outputs()));
}

BOOST_AUTO_TEST_CASE(a_restricted_transform_has_the_bricks_of_the_whole) {
    const DistanceTransform transform(test_device(), sphere());
    const Grid grid = lattice_around(sphere(), 80, 5, {0, 0, 0});
    const Band band = Band::symmetric(3 * grid.voxel());
    const Grid part = grid.part({20, 8, 40}, {25, 30, 19});
    const DistanceTransform restricted =
        transform.restrict_to({in_whole_bricks(part).box(), band.widest(), grid.voxel()});
    check_sparse(restricted, part, band, all_outputs());
    check_same(restricted.compute_sparse(part, band), transform.compute(in_whole_bricks(part), band, all_outputs()));
}

/// Arrays with room for so many bricks and runs, and one more of each that must stay as it is.
struct OwnArrays {
    OwnArrays(std::size_t brick_room, std::size_t run_room)
        : bricks(brick_room + 1, Index3{7, 7, 7}),
          inside(run_room + 1, BrickRun{{7, 7, 7}, 7}),
          distance((brick_room + 1) * brick_samples, 7.0F),
          triangle((brick_room + 1) * brick_samples, 7) {}

    SparseTargets targets() {
        const std::size_t samples = (bricks.size() - 1) * brick_samples;
        SparseTargets targets;
        targets.bricks = std::span(bricks).first(bricks.size() - 1);
        targets.inside = std::span(inside).first(inside.size() - 1);
        targets.values = {{Output::distance, std::span(distance).first(samples)},
                          {Output::triangle, std::span(triangle).first(samples)}};
        return targets;
    }
    bool is_rest_untouched(std::size_t brick_count, std::size_t run_count) const {
        const auto all = [](const auto& values, std::size_t from, const auto& value) {
            return std::all_of(values.begin() + static_cast<std::ptrdiff_t>(from), values.end(),
                               [&](const auto& v) { return v == value; });
        };
        return all(bricks, brick_count, Index3{7, 7, 7}) && all(inside, run_count, BrickRun{{7, 7, 7}, 7}) &&
               all(distance, brick_count * brick_samples, 7.0F) && all(triangle, brick_count * brick_samples, 7);
    }

    std::vector<Index3> bricks;
    std::vector<BrickRun> inside;
    std::vector<float> distance;
    std::vector<std::int32_t> triangle;
};

BOOST_AUTO_TEST_CASE(the_callers_arrays_get_the_field) {
    // With little memory there are several slabs.
    const Grid grid = lattice_around(make_shape("sphere4"), 160, 4, {-5, 0, 11});
    const Band band = Band::symmetric(3 * grid.voxel());
    for (const std::size_t memory : {std::size_t{1} << 30, std::size_t{10} << 20}) {
        const DistanceTransform transform(test_device().limited({.memory = memory}), make_shape("sphere4"));
        const SparseField whole = transform.compute_sparse(grid, band, Output::triangle);
        const SparseCounts expected{whole.bricks.size(), whole.inside.size()};
        BOOST_TEST((transform.count_sparse(grid, band) == expected));
        TransformStatistics statistics;
        SparseCounts counts;
        for (const auto& [more_bricks, more_runs] :
             {std::pair<std::ptrdiff_t, std::ptrdiff_t>(0, 0), {5, 3}, {-1, 0}, {0, -1}}) {
            OwnArrays own(expected.bricks + static_cast<std::size_t>(more_bricks),
                          expected.runs + static_cast<std::size_t>(more_runs));
            const auto compute = [&] { statistics = transform.compute_sparse(grid, band, own.targets(), counts); };
            if (more_bricks < 0 || more_runs < 0)
                check_throws(ErrorCode::invalid_argument,
                             {std::to_string(expected.bricks) + " bricks", std::to_string(expected.runs) + " runs",
                              "room for " + std::to_string(own.bricks.size() - 1)},
                             compute);
            else
                compute();
            BOOST_TEST((counts == expected));
            BOOST_TEST(own.is_rest_untouched(std::min(expected.bricks, own.bricks.size() - 1),
                                             std::min(expected.runs, own.inside.size() - 1)));
            if (more_bricks < 0 || more_runs < 0) continue;
            BOOST_TEST((statistics.slabs > 1) == (memory < std::size_t{1} << 30));
            BOOST_TEST(std::equal(whole.bricks.begin(), whole.bricks.end(), own.bricks.begin()));
            BOOST_TEST(std::equal(whole.inside.begin(), whole.inside.end(), own.inside.begin()));
            BOOST_TEST(std::memcmp(own.distance.data(), whole.distance().data(), whole.distance().size_bytes()) == 0);
            BOOST_TEST(std::memcmp(own.triangle.data(), whole.triangle().data(), whole.triangle().size_bytes()) == 0);
        }
        // A quarter of the room: some slabs have values, the others are only counted.
        OwnArrays quarter(expected.bricks / 4, expected.runs / 4);
        check_throws(ErrorCode::invalid_argument, {std::to_string(expected.bricks) + " bricks"},
                     [&] { transform.compute_sparse(grid, band, quarter.targets(), counts); });
        BOOST_TEST((counts == expected));
        BOOST_TEST(quarter.is_rest_untouched(expected.bricks / 4, expected.runs / 4));
    }
}

BOOST_AUTO_TEST_CASE(closest_points_go_into_arrays_of_doubles) {
    const Mesh mesh = sphere();
    const DistanceTransform transform(test_device(), mesh);
    const Grid grid = lattice_around(mesh, 40, 5, {0, 0, 0});
    const Band band = Band::symmetric(3 * grid.voxel());
    const SparseField whole = transform.compute_sparse(grid, band, Output::closest);
    OwnArrays own(whole.bricks.size(), whole.inside.size());
    const std::size_t samples = whole.bricks.size() * brick_samples;
    std::vector<double> closest(3 * samples);
    SparseTargets targets = own.targets();
    targets.values = {{Output::distance, std::span(own.distance).first(samples)}, {Output::closest, closest}};
    SparseCounts counts;
    transform.compute_sparse(grid, band, targets, counts);
    BOOST_TEST(std::memcmp(closest.data(), whole.closest().data(), whole.closest().size_bytes()) == 0);
    std::vector<float> floats(closest.size());
    targets.values = {{Output::distance, std::span(own.distance).first(samples)}, {Output::closest, floats}};
    check_throws(ErrorCode::unsupported, {"closest", "double"},
                 [&] { transform.compute_sparse(grid, band, targets, counts); });
}

// A pointer beyond the arrays would be seen by the sanitizers.
BOOST_AUTO_TEST_CASE(layers_without_bricks_may_follow_those_that_exceed_the_room) {
    const Mesh mesh = make_shape("sphere4");
    Grid grid = lattice_around(mesh, 160, 4, {0, 0, 0});
    grid.size[2] *= 2;
    const Band band = Band::symmetric(3 * grid.voxel());
    const SparseField whole = DistanceTransform(test_device(), mesh).compute_sparse(grid, band);
    const SparseCounts expected{whole.bricks.size(), whole.inside.size()};
    const DistanceTransform transform(test_device().limited({.memory = std::size_t{5} << 19}), mesh);
    TransformStatistics statistics;
    BOOST_TEST((transform.count_sparse(grid, band, {}, &statistics) == expected));
    BOOST_TEST(statistics.slabs > 1U);
}

BOOST_AUTO_TEST_CASE(arrays_that_are_refused) {
    const DistanceTransform transform(test_device(), sphere());
    const Grid grid = lattice_around(sphere(), 40, 5, {0, 0, 0});
    const Band band = Band::symmetric(3 * grid.voxel());
    SparseCounts counts{3, 3};
    OwnArrays own(100, 100);
    const auto refuse = [&](ErrorCode code, const std::string& part, const SparseTargets& targets) {
        counts = {3, 3};
        check_throws(code, {part}, [&] { transform.compute_sparse(grid, band, targets, counts); });
        BOOST_TEST((counts == SparseCounts{}));
    };
    SparseTargets targets = own.targets();
    targets.bricks = targets.bricks.first(99);
    refuse(ErrorCode::invalid_argument, "room for bricks of 50688 samples", targets);
    targets = own.targets();
    std::vector<double> doubles(100 * brick_samples);
    targets.values[Output::distance] = doubles;
    refuse(ErrorCode::unsupported, "doubles", targets);
    targets = own.targets();
    targets.values[Output::distance].strides[0] = 8;
    targets.values[Output::distance].bytes = ArrayLayout::unknown_size;
    refuse(ErrorCode::unsupported, "strides", targets);
    targets = own.targets();
    targets.values[Output::triangle].host = own.distance.data() + 8;
    refuse(ErrorCode::invalid_argument, "lie on the same bytes", targets);
    targets = own.targets();
    targets.inside = {reinterpret_cast<BrickRun*>(own.bricks.data()), 1};
    refuse(ErrorCode::invalid_argument, "the array of bricks and the array of runs lie on the same bytes", targets);
    targets = own.targets();
    targets.values = {{Output::triangle, std::span(own.triangle)}};
    refuse(ErrorCode::invalid_argument, "the distance has no target", targets);
    check_throws(ErrorCode::invalid_argument, {"band with an end"},
                 [&] { transform.count_sparse(grid, Band::full()); });
}

BOOST_AUTO_TEST_CASE(many_grids_have_the_fields_of_calls_of_their_own) {
    const Grid grid = lattice_around(sphere(), 90, 5, {-3, 0, 2});
    const Band band = Band::symmetric(3 * grid.voxel());
    Random random(29);
    // Boxes of one lattice that overlap, one without the surface; another lattice, band and set of outputs.
    std::vector<SparseRequest> requests{{grid.part({0, 0, 0}, {5, 5, 5}), band, Output::gradient},
                                        {lattice_around(sphere(), 33, 3, {0, 1, 0}), band, Output::gradient},
                                        {grid, Band{2 * grid.voxel(), grid.voxel()}, Output::gradient},
                                        {grid, band, Output::gradient | Output::site}};
    for (int n = 0; n < 12; ++n) {
        Index3 offset{}, size{};
        for (std::size_t axis = 0; axis < 3; ++axis) {
            offset[axis] = static_cast<std::int64_t>(random.uniform(0, 60));
            size[axis] = static_cast<std::int64_t>(random.uniform(1, 30));
        }
        requests.push_back({grid.part(offset, size), band, Output::gradient});
    }
    for (const KernelBody body : {KernelBody::by_vector, KernelBody::by_group}) {
        const DistanceTransform transform(test_device(), sphere(), {.body = body});
        TransformStatistics statistics;
        const std::vector<SparseField> fields = transform.compute_sparse(requests, {}, &statistics);
        BOOST_REQUIRE(fields.size() == requests.size());
        BOOST_TEST(statistics.slabs < requests.size());  // some were computed together
        for (std::size_t n = 0; n < requests.size(); ++n) BOOST_TEST_CONTEXT("request " << n) {
                const auto& [part, of_part, outputs] = requests[n];
                const SparseField one = transform.compute_sparse(part, of_part, outputs);
                BOOST_TEST((fields[n].grid == part));
                BOOST_TEST((fields[n].band == of_part));
                BOOST_TEST((fields[n].outputs() == one.outputs()));
                BOOST_TEST((fields[n].bricks == one.bricks));
                BOOST_TEST((fields[n].inside == one.inside));
                BOOST_TEST(same_bytes(fields[n].values(), one.values(), Output::distance));
                BOOST_TEST(same_bytes(fields[n].values(), one.values(), Output::gradient));
            }
        BOOST_TEST(transform.compute_sparse(std::span<const SparseRequest>()).empty());
        std::vector<SparseRequest> wrong = requests;
        wrong[3].grid.size[1] = 0;
        check_throws(ErrorCode::invalid_argument, {"request 3 of 16"}, [&] { transform.compute_sparse(wrong); });
    }
}

// The bricks that ranks have, whose slabs meet at multiples of 8, are those of the whole, each once.
BOOST_AUTO_TEST_CASE(ranks_have_the_bricks_of_the_whole) {
    const DistanceTransform transform(test_device(), sphere());
    const Grid grid = in_whole_bricks(lattice_around(sphere(), 70, 5, {0, 0, 5}));
    const Band band = Band::symmetric(3 * grid.voxel());
    const SparseField whole = transform.compute_sparse(grid, band);
    SparseField joined;
    const std::int64_t layers = grid.size[2] / 8;
    for (std::int64_t rank = 0, ranks = 3; rank < ranks; ++rank) {
        const std::int64_t begin = layers * rank / ranks * 8, end = layers * (rank + 1) / ranks * 8;
        const Grid own = grid.part({0, 0, begin}, {grid.size[0], grid.size[1], end - begin});
        const SparseField part =
            transform.restrict_to({own.box(), band.widest(), grid.voxel()}).compute_sparse(own, band);
        const std::size_t before = joined.distance().size_bytes();
        joined.bricks.insert(joined.bricks.end(), part.bricks.begin(), part.bricks.end());
        joined.inside.insert(joined.inside.end(), part.inside.begin(), part.inside.end());
        std::memcpy(joined.resize(Output::distance, joined.bricks.size()).data() + before, part.distance().data(),
                    part.distance().size_bytes());
    }
    BOOST_TEST((joined.bricks == whole.bricks));
    BOOST_TEST((joined.inside == whole.inside));
    BOOST_TEST(same_bytes(joined.values(), whole.values(), Output::distance));
}

BOOST_AUTO_TEST_CASE(a_grid_far_from_the_surface_has_no_bricks) {
    const DistanceTransform transform(test_device(), cube(100));
    const Band band = Band::symmetric(2);
    for (const auto& [at, runs] : {std::pair{0.0, std::size_t{5 * 5}}, {300.0, std::size_t{0}}}) {
        const SparseField field = transform.compute_sparse(grid_at({at, 0, 0}, 1, 18), band, all_outputs());
        BOOST_TEST(field.bricks.empty());
        BOOST_TEST(field.distance().empty());
        BOOST_TEST(field.inside.size() == runs);
    }
}

BOOST_AUTO_TEST_CASE(what_is_refused) {
    const DistanceTransform transform(test_device(), sphere());
    const Grid grid = grid_around(sphere(), 20, 2);
    check_throws(ErrorCode::invalid_argument, {"band with an end", "inf"},
                 [&] { transform.compute_sparse(grid, Band::full()); });
    check_throws(ErrorCode::invalid_argument, {"band with an end"}, [&] {
        transform.compute_sparse(grid, Band{std::numeric_limits<double>::infinity(), 1});
    });
    check_throws(ErrorCode::invalid_argument, {"signs alone", "dense"},
                 [&] { transform.compute_sparse(grid, Band::signs_only()); });
    check_throws(ErrorCode::invalid_argument, {"sink", "empty"},
                 [&] { transform.compute_sparse(grid, Band::symmetric(0.1), Output::distance, SparseSink()); });
    check_throws(ErrorCode::unsupported, {"bricks", "dense"}, [&] {
        make_transform(test_device(), sphere(), {.polyhedra = Polyhedra::mauch, .scan = Scan::slices})
            .compute_sparse(grid, Band::symmetric(0.1));
    });
    BOOST_CHECK_THROW(transform.compute_sparse(grid, Band::symmetric(0.1), Output::distance,
                                               [](const SparseSlab&) { throw std::runtime_error("of the sink"); }),
                      std::runtime_error);
}
