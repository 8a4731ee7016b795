#include "io/example_field.hpp"
#include "support/temporary_folder.hpp"
#include "support/throws.hpp"

#include <clsdf/field.hpp>
#include <clsdf/io.hpp>
#include <clsdf/sparse.hpp>

#include <fmt/format.h>
#include <boost/test/unit_test.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>

using namespace clsdf;
using namespace clsdf::test;

#if CLSDF_WITH_NANOVDB

#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wall"
#pragma GCC diagnostic ignored "-Wextra"
#include <nanovdb/util/GridBuilder.h>
#include <nanovdb/util/GridStats.h>
#include <nanovdb/util/GridValidator.h>
#include <nanovdb/util/IO.h>
#pragma GCC diagnostic pop

namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();

// Distances to a ball around the origin, limited to the band; `first` is not a multiple of 8.
Field ball(const clsdf::Band& band, double radius = 1.7, const Vec3& spacing = {0.1, 0.1, 0.1},
           const Index3& first = {-21, -19, -20}, const Index3& size = {43, 39, 41},
           SignRule sign = SignRule::nonzero) {
    Field field({{{0.01, -0.02, 0.03}, spacing, size, first}, band, sign, "ball"}, Output::distance);
    for (std::int64_t k = 0; k < size[2]; ++k)
        for (std::int64_t j = 0; j < size[1]; ++j)
            for (std::int64_t i = 0; i < size[0]; ++i) {
                const clsdf::Vec3 p = field.grid.position(i, j, k);
                double distance = std::hypot(p[0], p[1], p[2]) - radius;
                if (sign == SignRule::none) distance = std::abs(distance);
                field.distance()[field.grid.offset(i, j, k)] =
                    distance > band.outside   ? static_cast<float>(band.outside)
                    : distance < -band.inside ? -static_cast<float>(band.inside)
                                              : static_cast<float>(distance);
            }
    return field;
}

bool is_beyond(const Field& field, float value) {
    const auto same = [&](double fill) {
        return std::isfinite(fill) &&
               std::bit_cast<std::uint32_t>(static_cast<float>(fill)) == std::bit_cast<std::uint32_t>(value);
    };
    return same(field.band.outside) || same(-field.band.inside);
}

using Handle = nanovdb::GridHandle<nanovdb::HostBuffer>;

// Whether each node follows the one before it in the order of the tree.
bool is_breadth_first(const nanovdb::NanoGrid<float>& grid) {
    const auto& tree = grid.tree();
    const auto* upper = tree.getFirstNode<2>();
    const auto* lower = tree.getFirstNode<1>();
    const auto* leaf = tree.getFirstNode<0>();
    bool follows = true;
    for (auto u = tree.root().beginChild(); u; ++u) {
        follows = follows && &*u == upper++;
        for (auto l = u->beginChild(); l; ++l) {
            follows = follows && &*l == lower++;
            for (auto each = l->beginChild(); each; ++each) follows = follows && &*each == leaf++;
        }
    }
    return follows;
}

// A file as NanoVDB reads it, which also finds it valid in all details.
Handle handle_of(const std::string& path) {
    Handle handle = nanovdb::io::readGrid(path);
    const auto* grid = handle.grid<float>();
    BOOST_REQUIRE(grid != nullptr);
    BOOST_TEST(nanovdb::GridValidator<float>::check(*grid, true) == "");
    BOOST_TEST(!nanovdb::GridChecksum(grid->checksum()).isEmpty());
    BOOST_TEST(grid->gridName() == "distance");
    BOOST_TEST(grid->isBreadthFirst());
    BOOST_CHECK(is_breadth_first(*grid));
    return handle;
}

// The field's samples, by an accessor and by their leaves' masks, and the background around the grid.
void check_samples(const nanovdb::NanoGrid<float>& grid, const Field& field) {
    const auto accessor = grid.getAccessor();
    const Grid& block = field.grid;
    std::size_t wrong_values = 0, wrong_states = 0, active = 0;
    for (std::int64_t k = 0; k < block.size[2]; ++k)
        for (std::int64_t j = 0; j < block.size[1]; ++j)
            for (std::int64_t i = 0; i < block.size[0]; ++i) {
                const nanovdb::Coord at(static_cast<int>(block.first[0] + i), static_cast<int>(block.first[1] + j),
                                        static_cast<int>(block.first[2] + k));
                const float expected = field.distance()[block.offset(i, j, k)];
                const bool is_active = !is_beyond(field, expected);
                active += is_active ? 1 : 0;
                wrong_values +=
                    std::bit_cast<std::uint32_t>(accessor.getValue(at)) != std::bit_cast<std::uint32_t>(expected);
                wrong_states += accessor.isActive(at) != is_active;
            }
    BOOST_TEST(wrong_values == 0U);
    BOOST_TEST(wrong_states == 0U);
    BOOST_TEST(grid.activeVoxelCount() == active);
}

// What NanoVDB computes itself from the values: boxes, extrema, averages of the grid and of every node.
void check_statistics(Handle& handle) {
    auto& grid = *handle.grid<float>();
    std::vector<char> stated(handle.size());
    std::memcpy(stated.data(), handle.data(), handle.size());
    const auto& before = *reinterpret_cast<const nanovdb::NanoGrid<float>*>(handle.data());
    const float average = before.tree().root().average(), deviation = before.tree().root().stdDeviation();
    nanovdb::gridStats(grid, nanovdb::StatsMode::All);
    BOOST_TEST(grid.tree().root().average() == average, boost::test_tools::tolerance(1e-5F));
    BOOST_TEST(grid.tree().root().stdDeviation() == deviation, boost::test_tools::tolerance(1e-5F));
    // Averages are sums in another order, and may differ in their last place.
    std::size_t different = 0;
    for (std::size_t begin = 0; begin + 4 <= stated.size(); begin += 4) {
        float here = 0, there = 0;
        std::memcpy(&here, stated.data() + begin, 4);
        std::memcpy(&there, handle.data() + begin, 4);
        if (std::memcmp(&here, &there, 4) != 0 && !(std::abs(here - there) <= 1e-5F * std::abs(there))) ++different;
    }
    BOOST_TEST(different == 0U);
}

void check_field(const Field& field) {
    const TemporaryFolder folder;
    const std::string path = folder.file("field.nvdb");
    write_field(field, path);
    Handle handle = handle_of(path);
    check_samples(*handle.grid<float>(), field);
    if (handle.grid<float>()->activeVoxelCount() > 0 && std::isfinite(field.band.widest())) check_statistics(handle);
    const Field read = read_field(path);
    BOOST_CHECK(same_bits(read.distance(), field.distance()));
    BOOST_CHECK(read.grid == field.grid);
    BOOST_CHECK(read.band == field.band);
    BOOST_CHECK(read.sign == field.sign);
    BOOST_TEST(read.mesh_name == field.mesh_name);
}

// The bricks of a dense field, as compute_sparse() finds them. Samples beyond the grid get a value that no field has.
struct Compact {
    Grid part;
    std::vector<Index3> bricks;
    std::vector<float> distance;
    std::vector<BrickRun> inside;

    SparseSlab slab() const {
        SparseSlab result;
        result.part = part;
        result.bricks = bricks;
        result.inside = inside;
        result.values.set(Output::distance, distance);
        return result;
    }
};

std::int64_t rounded_down(std::int64_t index) {
    return index & ~(brick_side - 1);
}

// Layers of bricks from `z` on.
Compact compact(const Field& field, std::int64_t z, std::int64_t slices) {
    const Grid& grid = field.grid;
    Index3 begin{}, end{};
    for (std::size_t axis = 0; axis < 3; ++axis) {
        begin[axis] = rounded_down(grid.first[axis]);
        end[axis] = rounded_down(grid.first[axis] + grid.size[axis] + brick_side - 1);
    }
    begin[2] = z;
    end[2] = z + slices;
    Compact result;
    result.part = {grid.origin, grid.spacing, {end[0] - begin[0], end[1] - begin[1], slices}, begin};
    for (std::int64_t bz = begin[2]; bz < end[2]; bz += brick_side)
        for (std::int64_t by = begin[1]; by < end[1]; by += brick_side)
            for (std::int64_t bx = begin[0]; bx < end[0]; bx += brick_side) {
                std::array<float, brick_samples> values{};
                values.fill(-1e9F);
                bool has_band = false;
                std::size_t inside = 0, outside = 0;
                for (std::size_t sample = 0; sample < brick_samples; ++sample) {
                    const auto s = static_cast<std::int64_t>(sample);
                    const Index3 at{bx + s % 8 - grid.first[0], by + s / 8 % 8 - grid.first[1],
                                    bz + s / 64 - grid.first[2]};
                    if (std::ranges::any_of(std::array{0U, 1U, 2U},
                                            [&](unsigned axis) { return at[axis] < 0 || at[axis] >= grid.size[axis]; }))
                        continue;
                    const float value = values[sample] = field.distance()[grid.offset(at[0], at[1], at[2])];
                    has_band = has_band || !is_beyond(field, value);
                    ++(std::signbit(value) ? inside : outside);
                }
                if (has_band || (inside > 0 && outside > 0)) {
                    result.bricks.push_back({bx, by, bz});
                    result.distance.insert(result.distance.end(), values.begin(), values.end());
                } else if (inside > 0) {
                    const bool follows = !result.inside.empty() && result.inside.back().first[1] == by &&
                                         result.inside.back().first[2] == bz &&
                                         result.inside.back().first[0] + 8 * result.inside.back().count == bx;
                    if (follows)
                        ++result.inside.back().count;
                    else
                        result.inside.push_back({{bx, by, bz}, 1});
                }
            }
    return result;
}

void write_sparse(const Field& field, const std::string& path, std::int64_t slices) {
    SparseFieldWriter writer(path, field);
    const std::int64_t end = rounded_down(field.grid.first[2] + field.grid.size[2] + brick_side - 1);
    for (std::int64_t z = rounded_down(field.grid.first[2]); z < end; z += slices)
        writer.append(compact(field, z, std::min(slices, end - z)).slab());
    writer.finish();
}

}  // namespace

BOOST_AUTO_TEST_SUITE(a_nvdb_field)

BOOST_AUTO_TEST_CASE(is_read_by_nanovdb_with_the_same_bits_for_every_band) {
    for (const clsdf::Band band :
         {clsdf::Band{0.2, 0.2}, clsdf::Band{0.3, 0.2}, clsdf::Band{0, 0.2}, clsdf::Band{0.2, 0},
          clsdf::Band{0.01, 0.01}, clsdf::Band::signs_only(), clsdf::Band{infinity, 0.2}, clsdf::Band{0.2, infinity},
          clsdf::Band{infinity, infinity}})
        BOOST_TEST_CONTEXT("band " << band.inside << " inside, " << band.outside << " outside") {
            check_field(ball(band));
        }
}

BOOST_AUTO_TEST_CASE(is_a_level_set_whose_background_is_the_half_width_outside) {
    const TemporaryFolder folder;
    write_field(ball({0.3, 0.2}), folder.file("ball.nvdb"));
    const Handle handle = handle_of(folder.file("ball.nvdb"));
    const auto& grid = *handle.grid<float>();
    BOOST_TEST(grid.isLevelSet());
    BOOST_TEST(grid.tree().background() == 0.2F);
    BOOST_TEST(grid.tree().getValue({1000000, 0, 0}) == 0.2F);
    BOOST_TEST(grid.tree().getValue({0, 0, 0}) == -0.3F);
    BOOST_TEST(grid.hasBBox());
    BOOST_TEST(grid.hasMinMax());
    BOOST_TEST(grid.hasAverage());
    BOOST_TEST(grid.hasStdDeviation());
}

BOOST_AUTO_TEST_CASE(without_a_sign_has_no_inside) {
    const Field field = ball({0.2, 0.2}, 1.7, {0.1, 0.1, 0.1}, {-21, -19, -20}, {43, 39, 41}, SignRule::none);
    check_field(field);
    const TemporaryFolder folder;
    write_field(field, folder.file("ball.nvdb"));
    const Handle handle = handle_of(folder.file("ball.nvdb"));
    BOOST_TEST(handle.grid<float>()->isUnknown());
    BOOST_TEST(handle.grid<float>()->tree().getValue({0, 0, 0}) == 0.2F);
}

BOOST_AUTO_TEST_CASE(maps_its_indices_to_the_samples_positions) {
    for (const Vec3& spacing : {Vec3{0.1, 0.1, 0.1}, Vec3{0.1, 0.07, 1.0 / 7}}) {
        const TemporaryFolder folder;
        const Field field = ball({0.2, 0.2}, 1.7, spacing);
        check_field(field);
        write_field(field, folder.file("ball.nvdb"));
        const Handle handle = handle_of(folder.file("ball.nvdb"));
        const auto& grid = *handle.grid<float>();
        const Index3& first = field.grid.first;
        for (const Index3& at : {Index3{0, 0, 0}, Index3{3, 30, 40}}) {
            const auto world = grid.indexToWorld(nanovdb::Vec3d(static_cast<double>(first[0] + at[0]),
                                                                static_cast<double>(first[1] + at[1]),
                                                                static_cast<double>(first[2] + at[2])));
            const Vec3 expected = field.grid.position(at[0], at[1], at[2]);
            const auto index = grid.worldToIndex(world);
            for (int axis = 0; axis < 3; ++axis) {
                const auto a = static_cast<std::size_t>(axis);
                BOOST_CHECK_SMALL(world[axis] - expected[a], 1e-15);
                BOOST_CHECK_SMALL(index[axis] - static_cast<double>(first[a] + at[a]), 1e-12);
                BOOST_TEST(grid.voxelSize()[axis] == spacing[a]);
            }
        }
        BOOST_TEST(grid.isLevelSet() == (spacing[0] == spacing[1]));  // its programs assume cubic voxels
    }
}

BOOST_AUTO_TEST_CASE(has_any_indices_of_the_lattice) {
    // Around corners of upper nodes, whose side is 4096, of lower nodes and of bricks.
    for (const Index3& first : {Index3{-4101, 4085, -5}, Index3{-128, -3, 120}, Index3{8, 16, -24}}) {
        Field field = ball({0.2, 0.2}, 1.1, {0.1, 0.1, 0.1}, {-11, -12, -13}, {23, 25, 27});
        field.grid.first = first;
        check_field(field);
    }
}

BOOST_AUTO_TEST_CASE(may_be_a_single_brick_or_sample) {
    check_field(ball({0.2, 0.2}, 0.3, {0.1, 0.1, 0.1}, {0, 0, 0}, {8, 8, 8}));
    check_field(ball({0.2, 0.2}, 0.3, {0.1, 0.1, 0.1}, {3, 0, -1}, {1, 1, 1}));
}

BOOST_AUTO_TEST_CASE(may_be_far_from_its_surface) {
    check_field(ball({0.2, 0.2}, 0.3, {0.1, 0.1, 0.1}, {100, 0, 0}, {20, 17, 9}));  // all outside
    check_field(ball({0.2, 0.2}, 99, {0.1, 0.1, 0.1}, {100, 0, 0}, {20, 17, 9}));   // all inside
}

BOOST_AUTO_TEST_CASE(has_tiles_for_its_inside) {
    const TemporaryFolder folder;
    const std::string path = folder.file("ball.nvdb");
    const Field field = ball({0.2, 0.2}, 2.6, {0.1, 0.1, 0.1}, {-32, -32, -32}, {64, 64, 64});
    check_field(field);
    write_field(field, path);
    const Handle handle = handle_of(path);
    const auto& tree = handle.grid<float>()->tree();
    BOOST_CHECK(tree.root().probeLeaf({0, 0, 0}) == nullptr);
    BOOST_CHECK(tree.root().probeLeaf({26, 0, 0}) != nullptr);
    BOOST_TEST(tree.activeTileCount(1) == 0U);
    BOOST_TEST(tree.nodeCount(0) < 8U * 8 * 8 - 100);
}

BOOST_AUTO_TEST_CASE(has_one_tile_for_a_whole_node) {
    const TemporaryFolder folder;
    const std::string path = folder.file("solid.nvdb");
    for (const std::int64_t side : {128, 4096}) {
        // Everything is inside but a brick.
        const FieldDescription field{
            {{0, 0, 0}, {1, 1, 1}, {side + 8, side, side}, {-side, 0, 0}}, {2, 3}, SignRule::parity, "solid"};
        Compact solid;
        solid.part = field.grid;
        for (std::int64_t z = 0; z < side; z += 8)
            for (std::int64_t y = 0; y < side; y += 8) solid.inside.push_back({{-side, y, z}, side / 8});
        solid.bricks.push_back({0, 8, 16});
        solid.distance.assign(brick_samples, 0.5F);
        SparseFieldWriter writer(path, field);
        writer.append(solid.slab());
        writer.finish();

        const Handle handle = handle_of(path);
        const auto& tree = handle.grid<float>()->tree();
        BOOST_TEST(tree.nodeCount(0) == 1U);
        BOOST_TEST(tree.nodeCount(1) == 1U);
        BOOST_TEST(tree.nodeCount(2) == (side == 128 ? 2U : 1U));
        BOOST_TEST(tree.root().tileCount() == 2U);
        const int s = static_cast<int>(side);
        BOOST_TEST(tree.getValue({-s, 0, 0}) == -2.0F);
        BOOST_TEST(tree.getValue({-1, s - 1, s - 1}) == -2.0F);
        BOOST_TEST(tree.getValue({-s - 1, 0, 0}) == 3.0F);
        BOOST_TEST(tree.getValue({-1, s, 0}) == 3.0F);
        BOOST_TEST(tree.getValue({0, 0, 0}) == 3.0F);
        BOOST_TEST(tree.getValue({0, 8, 16}) == 0.5F);
        BOOST_TEST(tree.isActive({7, 15, 23}));
        BOOST_TEST(handle.grid<float>()->activeVoxelCount() == brick_samples);
    }
}

BOOST_AUTO_TEST_CASE(has_the_same_bytes_from_slabs_and_from_bricks) {
    const TemporaryFolder folder;
    for (const clsdf::Band band : {clsdf::Band{0.2, 0.2}, clsdf::Band{0.3, 0.2}, clsdf::Band{0.01, 0.01}}) {
        const Field field = ball(band);
        write_field(field, folder.file("dense.nvdb"));
        const std::string expected = content_of(folder.file("dense.nvdb"));
        for (const std::int64_t slices : {8, 16, 64}) {
            write_sparse(field, folder.file("sparse.nvdb"), slices);
            BOOST_CHECK(content_of(folder.file("sparse.nvdb")) == expected);
        }
        FieldWriter writer(folder.file("slabs.nvdb"), field);
        const auto slice = static_cast<std::size_t>(field.grid.size[0] * field.grid.size[1]);
        for (std::size_t begin = 0, count = 1; begin < field.distance().size(); begin += count * slice, ++count) {
            count = std::min(count, field.distance().size() / slice - begin / slice);
            FieldSlab slab;
            slab.set(Output::distance, std::as_const(field).distance().subspan(begin, count * slice));
            writer.append(slab);
        }
        writer.finish();
        BOOST_CHECK(content_of(folder.file("slabs.nvdb")) == expected);
    }
}

BOOST_AUTO_TEST_CASE(of_another_program_has_the_box_of_its_active_samples_and_the_band_of_its_background) {
    const TemporaryFolder folder;
    const std::string path = folder.file("other.nvdb");
    nanovdb::GridBuilder<float> builder(0.25F, nanovdb::GridClass::LevelSet);
    auto accessor = builder.getAccessor();
    accessor.setValue({-3, 5, 7}, 0.125F);
    accessor.setValue({-1, 6, 200}, -0.125F);
    nanovdb::io::writeGrid(path, builder.getHandle(0.5, nanovdb::Vec3d(1, 2, 3), "density"));
    const Field field = read_field(path);
    BOOST_CHECK((field.grid == Grid{{1, 2, 3}, {0.5, 0.5, 0.5}, {3, 2, 194}, {-3, 5, 7}}));
    BOOST_CHECK(field.band == clsdf::Band::symmetric(0.25));
    BOOST_CHECK(field.sign == SignRule::automatic);
    BOOST_TEST(field.distance()[0] == 0.125F);
    BOOST_TEST(field.distance()[1] == 0.25F);
    BOOST_TEST(field.distance()[field.grid.offset(2, 1, 193)] == -0.125F);
}

BOOST_AUTO_TEST_CASE(of_another_program_with_another_type_or_map_or_no_active_sample_is_refused) {
    const TemporaryFolder folder;
    const std::string path = folder.file("other.nvdb");
    nanovdb::GridBuilder<double> doubles(0.25);
    doubles.getAccessor().setValue({0, 0, 0}, 1);
    nanovdb::io::writeGrid(path, doubles.getHandle());
    check_throws(ErrorCode::unreadable_input, {path, "no grid of floats"}, [&] { read_field(path); });

    nanovdb::GridBuilder<float> nothing(0.25F);
    nanovdb::io::writeGrid(path, nothing.getHandle());
    check_throws(ErrorCode::unreadable_input, {path, "active"}, [&] { read_field(path); });

    nanovdb::GridBuilder<float> oblique(0.25F);
    oblique.getAccessor().setValue({0, 0, 0}, 1);
    nanovdb::Map map;
    const std::array<std::array<double, 4>, 4> matrix{{{1, 0.5, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}, {0, 0, 0, 1}}};
    map.set(matrix, matrix, 1);
    nanovdb::io::writeGrid(path, oblique.getHandle(map));
    check_throws(ErrorCode::unreadable_input, {path, "axes"}, [&] { read_field(path); });
}

BOOST_AUTO_TEST_SUITE_END()

#else

BOOST_AUTO_TEST_CASE(nanovdb_is_installed) {
    fmt::print("skipped: NanoVDB is not installed (on Debian: apt-get install libnanovdb-dev)\n");
}

#endif
