// Links of a lattice, against whole numbers of any size.
#include "segments/segment_families.hpp"
#include "segments/segment_judge.hpp"
#include "support/exact_field.hpp"
#include "support/hostile_meshes.hpp"
#include "support/queries.hpp"
#include "support/supposes.hpp"
#include "support/throws.hpp"

#include "device/opencl.hpp"

#include <clsdf/tuning.hpp>

#include <tbb/global_control.h>

#include <map>
#include <tuple>

using namespace clsdf;
using namespace clsdf::test;

namespace {

struct Row {
    double q;
    std::uint32_t triangle, count;
    SegmentFlag flag;

    friend bool operator==(const Row&, const Row&) = default;
};
/// By sample (z, y, x) and direction.
using Rows = std::map<std::tuple<std::int32_t, std::int32_t, std::int32_t, std::uint8_t>, Row>;

Rows rows_of(const Links& links) {
    Rows rows;
    auto last = std::tuple(std::numeric_limits<std::int32_t>::min(), 0, 0, std::uint8_t{0});
    bool is_sorted = true;
    for (std::size_t n = 0; n < links.size(); ++n) {
        const auto& [x, y, z] = links.samples[n];
        const auto key = std::tuple(z, y, x, links.directions[n]);
        is_sorted = is_sorted && last < key;
        last = key;
        rows[key] = {links.q[n], links.triangles[n], links.counts[n], links.flags[n]};
    }
    BOOST_TEST(is_sorted);
    return rows;
}

std::array<std::vector<double>, 3> places_of(const Grid& grid, std::int64_t margin) {
    const Grid all = grid.grown(margin);
    std::array<std::vector<double>, 3> places;
    for (std::size_t axis = 0; axis < 3; ++axis)
        for (std::int64_t i = 0; i < all.size[axis]; ++i) places[axis].push_back(all.position(i, i, i)[axis]);
    return places;
}

Vec3 position(const std::array<std::vector<double>, 3>& places, const Index3& sample) {
    return {places[0][static_cast<std::size_t>(sample[0])], places[1][static_cast<std::size_t>(sample[1])],
            places[2][static_cast<std::size_t>(sample[2])]};
}

/// The families, and meshes of many faces that nothing lies on.
std::vector<Family> tilted_families() {
    std::vector<Family> all = families();
    for (const char* const shape : {"knot", "sphere4"}) {
        const Mesh mesh = tilted(make_shape(shape));
        all.push_back({shape, mesh, Grid::around(mesh, 30, Band::full())});
    }
    return all;
}

struct Totals {
    std::size_t links = 0, rows = 0, between = 0, on_wall = 0, several = 0;
};

/// Compares all links of the grid, and the sides of its samples.
Totals check_family(const Family& family, std::span<const LinkDirection> directions, std::int64_t margin) {
    Totals totals;
    const DistanceTransform transform(test_device(), family.mesh, {.sign = family.rule});
    const Links found = transform.links(family.grid, directions, {.with_between = true});
    const Rows rows = rows_of(found);
    const auto places = places_of(family.grid, margin);
    const SegmentJudge judge(family.mesh, family.rule, places);
    const Index3& size = family.grid.size;
    const Index3 all{size[0] + 2 * margin, size[1] + 2 * margin, size[2] + 2 * margin};
    const auto number = [&](const Index3& p) {
        return static_cast<std::size_t>((p[2] * all[1] + p[1]) * all[0] + p[0]);
    };
    std::vector<LookWindings> windings(static_cast<std::size_t>(all[0] * all[1] * all[2]));
    std::size_t missed = 0, invented = rows.size(), wrong = 0, wrong_sides = 0;
    double most_ulps = 0;
    for (std::int64_t z = 0; z < all[2]; ++z)
        for (std::int64_t y = 0; y < all[1]; ++y)
            for (std::int64_t x = 0; x < all[0]; ++x)
                windings[number({x, y, z})] = judge.windings(position(places, {x, y, z}));
    for (std::int64_t z = 0; z < size[2]; ++z)
        for (std::int64_t y = 0; y < size[1]; ++y)
            for (std::int64_t x = 0; x < size[0]; ++x) {
                const Index3 p{x + margin, y + margin, z + margin};
                const bool is_inside = judge.is_inside(windings[number(p)]);
                wrong_sides += found.inside.is_inside({x, y, z}) != is_inside;
                if (is_inside) continue;
                for (std::size_t d = 0; d < directions.size(); ++d) {
                    const auto& [cx, cy, cz] = directions[d];
                    const Index3 q{p[0] + cx, p[1] + cy, p[2] + cz};
                    ++totals.links;
                    const std::vector<JudgedWall> walls =
                        judge.walls(position(places, p), position(places, q), windings[number(p)]);
                    const bool differ = judge.is_inside(windings[number(q)]);
                    BOOST_REQUIRE((walls.size() % 2 == 1) == differ);
                    const auto row =
                        rows.find({static_cast<std::int32_t>(z + family.grid.first[2]),
                                   static_cast<std::int32_t>(y + family.grid.first[1]),
                                   static_cast<std::int32_t>(x + family.grid.first[0]), static_cast<std::uint8_t>(d)});
                    if (walls.empty()) continue;  // a row would be left over
                    if (row == rows.end()) {
                        ++missed;
                        continue;
                    }
                    --invented;
                    most_ulps = std::max(most_ulps, walls[0].place.ulps_from(row->second.q));
                    wrong += row->second.triangle != walls[0].triangle || row->second.count != walls.size() ||
                             row->second.flag != (differ ? SegmentFlag::none : SegmentFlag::between) ||
                             (row->second.q == 0) != (walls[0].place.numerator == 0);
                    ++(differ ? totals.rows : totals.between);
                    totals.on_wall += row->second.q == 0;
                    totals.several += walls.size() > 1;
                }
            }
    BOOST_TEST_CONTEXT(family.name) {
        BOOST_TEST(missed == 0);
        BOOST_TEST(invented == 0);
        BOOST_TEST(wrong == 0);
        BOOST_TEST(wrong_sides == 0);
        BOOST_TEST(most_ulps <= 0.51);
    }
    return totals;
}

const std::vector<LinkDirection> all_directions = stencil("D3Q27");

/// A sphere of triangles without whole coordinates.
Mesh ball() {
    return make_shape("sphere3");
}

Grid grid_of(const Mesh& mesh, std::int64_t samples) {
    return Grid::around(mesh.box(), {.resolution = samples});
}

bool is_same(const Links& a, const Links& b) {
    return a.samples == b.samples && a.directions == b.directions && a.q == b.q && a.triangles == b.triangles &&
           a.counts == b.counts && a.flags == b.flags && a.inside.bits == b.inside.bits;
}

}  // namespace

BOOST_AUTO_TEST_SUITE(links)

BOOST_AUTO_TEST_CASE(links_are_those_of_exact_arithmetic) {
    Totals all;
    for (const Family& family : families()) {
        const Totals totals = check_family(family, all_directions, 1);
        all.links += totals.links;
        all.rows += totals.rows;
        all.between += totals.between;
        all.on_wall += totals.on_wall;
        all.several += totals.several;
    }
    BOOST_TEST_MESSAGE(all.links << " links, " << all.rows << " rows, " << all.between << " with a body between, "
                                 << all.on_wall << " on a wall, " << all.several << " with several walls");
    BOOST_TEST(all.rows > 10000);
    BOOST_TEST(all.between > 100);
    BOOST_TEST(all.on_wall > 1000);
}

BOOST_AUTO_TEST_CASE(long_directions_are_those_of_exact_arithmetic) {
    const std::vector<LinkDirection> directions{{2, 0, 0},   {-2, 0, 0}, {2, 3, 0}, {-3, 2, 5},
                                                {3, -2, -5}, {0, -4, 2}, {6, 6, 6}, {1, 7, -3}};
    for (const Family& family : families())
        if (family.name.find("soup") != std::string::npos || family.name == "cube on planes" ||
            family.name == "slivers") {
            Family small = family;
            small.grid = family.grid.part({1, 1, 1}, {4, 4, 3});
            check_family(small, directions, 7);
        }
}

BOOST_AUTO_TEST_CASE(sides_are_those_of_queries) {
    for (const Family& family : families()) {
        const DistanceTransform transform(test_device(), family.mesh, {.sign = family.rule});
        const SampleSides sides = transform.links(family.grid, all_directions).inside;
        const Field field = query(transform, samples_of(family.grid), no_limit);
        std::size_t n = 0, wrong = 0;
        for (std::int64_t z = 0; z < family.grid.size[2]; ++z)
            for (std::int64_t y = 0; y < family.grid.size[1]; ++y)
                for (std::int64_t x = 0; x < family.grid.size[0]; ++x, ++n)
                    if (const float distance = field.distance()[n]; distance != 0)
                        wrong += sides.is_inside({x, y, z}) != (distance < 0);
        BOOST_TEST_CONTEXT(family.name) BOOST_TEST(wrong == 0);
    }
}

BOOST_AUTO_TEST_CASE(the_part_is_the_distance_over_the_approach) {
    // A tetrahedron with the face x + 2 y + 3 z = 12, whose other faces are the planes of the axes.
    const Parts corner = tetrahedron({{{0, 0, 0}, {12, 0, 0}, {0, 6, 0}, {0, 0, 4}}});
    const DistanceTransform transform(test_device(), corner.mesh("corner"));
    const Links links = transform.links({{0.25, 0.5, 0.125}, {0.5, 0.5, 0.5}, {30, 20, 15}, {}}, all_directions);
    std::size_t compared = 0, wrong = 0;
    for (std::size_t n = 0; n < links.size(); ++n) {
        if (links.triangles[n] != 2) continue;
        const auto& [i, j, k] = links.samples[n];
        const auto& [cx, cy, cz] = all_directions[links.directions[n]];
        const double distance = 0.25 + 0.5 * i + 2 * (0.5 + 0.5 * j) + 3 * (0.125 + 0.5 * k) - 12;
        const double approach = -0.5 * (cx + 2 * cy + 3 * cz);
        wrong += links.q[n] != distance / approach;  // all is exact but the quotient
        ++compared;
    }
    BOOST_TEST(wrong == 0);
    BOOST_TEST(compared > 500);
}

BOOST_AUTO_TEST_CASE(mirrored_meshes_have_mirrored_links) {
    for (const Family& family : families()) {
        if (family.grid.spacing != Vec3{1, 1, 1} || family.grid.origin != Vec3{} || family.grid.first != Index3{})
            continue;
        if (family.name == "slivers" || family.name == "soup, random") continue;  // mirrored, they would be rounded
        const Rows rows = rows_of(DistanceTransform(test_device(), family.mesh, {.sign = family.rule})
                                      .links(family.grid, all_directions, {.with_between = true}));
        for (std::size_t axis = 0; axis < 3; ++axis) {
            const auto top = static_cast<double>(family.grid.size[axis] - 1);
            const Mesh mirrored = reversed(clsdf::test::moved(family.mesh, [&](Vec3 v) {
                v[axis] = top - v[axis];
                return v;
            }));
            const Links links = DistanceTransform(test_device(), mirrored, {.sign = family.rule})
                                    .links(family.grid, all_directions, {.with_between = true});
            std::size_t wrong = links.size() != rows.size();
            for (std::size_t n = 0; n < links.size(); ++n) {
                std::array<std::int32_t, 3> sample = links.samples[n];
                sample[axis] = static_cast<std::int32_t>(top) - sample[axis];
                LinkDirection direction = all_directions[links.directions[n]];
                direction[axis] *= -1;
                const auto number = std::ranges::find(all_directions, direction) - all_directions.begin();
                const auto found = rows.find({sample[2], sample[1], sample[0], static_cast<std::uint8_t>(number)});
                wrong += found == rows.end() || found->second.q != links.q[n] ||
                         found->second.triangle != links.triangles[n] || found->second.count != links.counts[n];
            }
            BOOST_TEST_CONTEXT(family.name << " on axis " << axis) BOOST_TEST(wrong == 0);
        }
    }
}

BOOST_AUTO_TEST_CASE(both_ends_add_up_to_one) {
    const Mesh mesh = ball();
    const DistanceTransform transform(test_device(), mesh);
    const Grid grid = grid_of(mesh, 40);
    const Links links = transform.links(grid, all_directions);
    // From the inside: the faces as given, as all links are crossed once.
    const Links faces = transform.links(grid, all_directions, {.hits = Hits::faces});
    const Rows rows = rows_of(faces);
    double worst = 0;
    std::size_t compared = 0;
    for (std::size_t n = 0; n < links.size(); ++n) {
        if (links.counts[n] != 1) continue;
        std::array<std::int32_t, 3> other = links.samples[n];
        LinkDirection back = all_directions[links.directions[n]];
        for (std::size_t axis = 0; axis < 3; ++axis) {
            other[axis] += back[axis];
            back[axis] = -back[axis];
        }
        const auto number = std::ranges::find(all_directions, back) - all_directions.begin();
        const auto found = rows.find({other[2], other[1], other[0], static_cast<std::uint8_t>(number)});
        if (found == rows.end()) continue;  // it is not in the grid
        worst = std::max(worst, std::abs(links.q[n] + found->second.q - 1));
        ++compared;
    }
    BOOST_TEST(compared > 10000);
    BOOST_TEST(worst <= 0x1p-52);
}

BOOST_AUTO_TEST_CASE(parts_and_threads_have_the_bytes_of_the_whole) {
    const Mesh mesh = ball();
    const DistanceTransform transform(test_device(), mesh);
    const Grid grid = grid_of(mesh, 48);
    const Links whole = transform.links(grid, all_directions, {.with_between = true});
    {
        const tbb::global_control one(tbb::global_control::max_allowed_parallelism, 1);
        BOOST_TEST(is_same(transform.links(grid, all_directions, {.with_between = true}), whole));
    }
    const Rows rows = rows_of(whole);
    std::size_t found = 0, wrong = 0;
    for (std::int64_t z = 0; z < 48; z += 16)
        for (std::int64_t x = 0; x < 48; x += 24) {
            const Grid part = grid.part({x, 0, z}, {24, grid.size[1], std::min<std::int64_t>(16, grid.size[2] - z)});
            for (const auto& [key, row] : rows_of(transform.links(part, all_directions, {.with_between = true}))) {
                const auto same = rows.find(key);
                wrong += same == rows.end() || !(same->second == row);
                ++found;
            }
        }
    BOOST_TEST(found == rows.size());
    BOOST_TEST(wrong == 0);
    // One direction alone.
    const Links alone = transform.links(grid, std::span(all_directions).subspan(5, 1));
    BOOST_TEST(alone.size() == static_cast<std::size_t>(std::ranges::count(
                                   transform.links(grid, all_directions).directions, std::uint8_t{5})));
}

BOOST_AUTO_TEST_CASE(moved_and_restricted_meshes_have_the_links_of_their_positions) {
    const Mesh mesh = ball();
    const Mesh other = tilted(mesh);
    DistanceTransform transform(test_device(), mesh);
    const Grid grid = grid_of(other, 40);
    transform.links(grid, all_directions);
    transform.set_positions(other.vertices());
    const Links moved = transform.links(grid, all_directions);
    BOOST_TEST(is_same(moved, DistanceTransform(test_device(), other).links(grid, all_directions)));

    const Grid part = grid.part({20, 3, 5}, {10, 20, 12});
    const DistanceTransform restricted =
        transform.restrict_to({.box = part.grown(1).box(), .half_width = 0.1, .spacing = grid.voxel()});
    BOOST_TEST(is_same(restricted.links(part, all_directions), transform.links(part, all_directions)));
    check_throws(ErrorCode::invalid_argument, {"restricted", "region"},
                 [&] { restricted.links(part.grown(1), all_directions); });
}

// Kernels find them for the body by_group, the host for the other one.
BOOST_AUTO_TEST_CASE(kernels_find_the_rows_of_the_host) {
    std::vector<LinkDirection> long_ones{{3, 1, -2}, {-3, -1, 2}, {16, -5, 1}, {0, 2, 0}, {1, 0, 0}};
    const std::vector<std::vector<LinkDirection>> asked{stencil("D3Q15"), stencil("D3Q27", "OpenLB"), long_ones};
    std::size_t rows = 0;
    for (const Family& family : tilted_families())
        for (const auto& directions : asked)
            BOOST_TEST_CONTEXT(family.name << ", " << directions.size() << " directions") {
                const auto found_by = [&](KernelBody body) {
                    return DistanceTransform(test_device(), family.mesh, {.sign = family.rule, .body = body});
                };
                const DistanceTransform by_kernels = found_by(KernelBody::by_group),
                                        by_host = found_by(KernelBody::by_vector);
                for (const Grid& grid : {family.grid, family.grid.part({1, 0, 1}, {3, family.grid.size[1], 3})}) {
                    const Links found = by_kernels.links(grid, directions), expected = by_host.links(grid, directions);
                    BOOST_TEST(is_same(found, expected));
                    BOOST_TEST(by_kernels.count_links(grid, directions) == expected.size());
                    rows += found.size();
                }
            }
    BOOST_TEST_MESSAGE(rows << " rows");
    BOOST_TEST(rows > 10000U);
}

BOOST_AUTO_TEST_CASE(links_are_counted_and_written_into_the_callers_arrays) {
    const Mesh mesh = ball();
    const DistanceTransform transform(test_device(), mesh);
    const Grid grid = grid_of(mesh, 24);
    for (const LinkOptions& options :
         {LinkOptions{}, LinkOptions{.with_between = true}, LinkOptions{.hits = Hits::faces}}) {
        const Links links = transform.links(grid, all_directions, options);
        BOOST_TEST(transform.count_links(grid, all_directions, options) == links.size());
    }
    const Links links = transform.links(grid, all_directions);
    const std::size_t room = links.size() + 3;
    std::vector<std::array<std::int32_t, 3>> samples(room);
    std::vector<std::uint8_t> directions(room), flags(room, 77);
    std::vector<float> q(room, -7);
    std::vector<std::int32_t> triangles(room);
    std::vector<std::uint32_t> counts(room);
    std::vector<std::uint8_t> inside(grid.sample_count(), 9);
    LinkTargets targets{room, samples, directions, q, triangles, counts, flags, inside};
    std::size_t count = 0;
    transform.links(grid, all_directions, targets, count);
    BOOST_TEST(count == links.size());
    std::size_t wrong = 0;
    for (std::size_t n = 0; n < count; ++n)
        wrong += samples[n] != links.samples[n] || directions[n] != links.directions[n] ||
                 std::abs(static_cast<double>(q[n]) - links.q[n]) > 1e-7 ||
                 static_cast<std::uint32_t>(triangles[n]) != links.triangles[n] || counts[n] != links.counts[n];
    std::size_t sample = 0;
    for (std::int64_t z = 0; z < grid.size[2]; ++z)
        for (std::int64_t y = 0; y < grid.size[1]; ++y)
            for (std::int64_t x = 0; x < grid.size[0]; ++x)
                wrong += inside[sample++] != (links.inside.is_inside({x, y, z}) ? 1 : 0);
    BOOST_TEST(wrong == 0);
    BOOST_TEST(q[count] == -7);
    BOOST_TEST(static_cast<int>(flags[count]) == 77);
    std::vector<float> few(10, -7);
    check_throws(ErrorCode::invalid_argument, {fmt::format("{}", count), "room for 10"},
                 [&] { transform.links(grid, all_directions, {.room = 10, .q = few}, count); });
    BOOST_TEST(count == links.size());
    BOOST_TEST(std::ranges::all_of(few, [](float x) { return x == -7; }));
}

BOOST_AUTO_TEST_CASE(dense_fields_have_the_part_of_each_link) {
    const Mesh mesh = ball();
    const DistanceTransform transform(test_device(), mesh);
    Grid grid = grid_of(mesh, 20);
    grid.first = {3, -2, 40};
    grid.origin = grid_of(mesh, 20).position(-3, 2, -40);
    for (const LinkOptions& options : {LinkOptions{.with_between = true}, LinkOptions{.hits = Hits::faces}}) {
        const Links links = transform.links(grid, all_directions, options);
        BOOST_TEST(links.size() > 1000U);
        const std::size_t samples = grid.sample_count();
        std::vector<double> expected(27 * samples, -1);
        for (std::size_t n = 0; n < links.size(); ++n) {
            const auto& [x, y, z] = links.samples[n];
            expected[links.directions[n] * samples +
                     grid.offset(x - grid.first[0], y - grid.first[1], z - grid.first[2])] = links.q[n];
        }
        std::size_t count = 0;
        std::vector<double> dense(27 * samples, 7);
        transform.links(grid, all_directions, {.dense = dense}, count, options);
        BOOST_TEST(count == links.size());
        BOOST_TEST((dense == expected));
        // With strides: z fastest, a float beside each number, directions side by side.
        const auto [nx, ny, nz] = grid.size;
        std::vector<float> strided(2 * 27 * samples, 7);
        transform.links(grid, all_directions,
                        {.dense = OutputArray(strided.data(), {8 * 27 * nz * ny, 8 * 27 * nz, 8 * 27}, 8)}, count,
                        options);
        std::size_t wrong = 0;
        for (std::int64_t z = 0; z < nz; ++z)
            for (std::int64_t y = 0; y < ny; ++y)
                for (std::int64_t x = 0; x < nx; ++x)
                    for (std::size_t d = 0; d < 27; ++d) {
                        const std::size_t at = 2 * (static_cast<std::size_t>((x * ny + y) * nz + z) * 27 + d);
                        const double q = expected[d * samples + grid.offset(x, y, z)];
                        wrong += strided[at] != as_float_part(q) || strided[at + 1] != 7;
                    }
        BOOST_TEST(wrong == 0);
    }
    // With rows: these need room, and without it nothing is written.
    std::vector<float> dense(27 * grid.sample_count(), 7);
    std::vector<std::uint8_t> inside(grid.sample_count(), 7);
    std::vector<double> q(5);
    std::size_t count = 0;
    check_throws(ErrorCode::invalid_argument, {"room for 5"}, [&] {
        transform.links(grid, all_directions, {.room = 5, .q = q, .inside = inside, .dense = dense}, count);
    });
    BOOST_TEST(std::ranges::all_of(dense, [](float x) { return x == 7; }));
    std::vector<float> small(26 * grid.sample_count());
    check_throws(ErrorCode::invalid_argument, {"dense array", fmt::format("{} are needed", dense.size())},
                 [&] { transform.links(grid, all_directions, {.dense = small}, count); });
    check_throws(ErrorCode::invalid_argument, {"dense array", "component_stride 0", "all of them"}, [&] {
        transform.links(grid, all_directions, {.dense = OutputArray(dense.data(), {4, 80, 1600})}, count);
    });
    check_throws(ErrorCode::unsupported, {"dense array", "uint8", "double or float"},
                 [&] { transform.links(grid, all_directions, {.dense = inside}, count); });
    check_throws(ErrorCode::invalid_argument, {"dense array", "array of inside", "same bytes"}, [&] {
        auto* const bytes = reinterpret_cast<std::uint8_t*>(dense.data());
        transform.links(grid, all_directions, {.inside = OutputArray(bytes), .dense = dense}, count);
    });
}

BOOST_AUTO_TEST_CASE(slabs_have_the_rows_of_the_whole) {
    const Mesh mesh = ball();
    const DistanceTransform transform(test_device(), mesh);
    // Slabs of 32 slices.
    Grid grid{{-3, -2, -1.07}, {0.01, 0.01, 0.03}, {700, 500, 70}, {}};
    const std::vector<Grid> slabs = DistanceTransform::slabs_of(grid);
    BOOST_REQUIRE(slabs.size() > 1U);
    const std::vector<LinkDirection> directions{{0, 0, 1}, {1, 0, -2}, {-1, 3, 1}};
    const Links whole = transform.links(grid, directions, {.with_between = true});
    BOOST_TEST(whole.size() > 1000U);
    Links all;
    std::size_t count = 0, wrong = 0;
    std::vector<double> fractions;
    const TransformStatistics statistics = transform.links(
        grid, directions,
        [&](const Grid& part, const Links& links) {
            wrong += !(part == slabs[count++]);
            for (std::size_t n = 0; n < links.size(); ++n)
                wrong += links.samples[n][2] < part.first[2] || links.samples[n][2] >= part.first[2] + part.size[2];
            const auto add = [](auto& to, const auto& from) { to.insert(to.end(), from.begin(), from.end()); };
            add(all.samples, links.samples);
            add(all.directions, links.directions);
            add(all.q, links.q);
            add(all.triangles, links.triangles);
            add(all.counts, links.counts);
            add(all.flags, links.flags);
            for (std::int64_t z = 0; z < part.size[2]; ++z)
                for (std::int64_t y = 0; y < part.size[1]; y += 7)
                    for (std::int64_t x = 0; x < part.size[0]; ++x)
                        wrong += links.inside.is_inside({x, y, z}) !=
                                 whole.inside.is_inside({x, y, z + part.first[2] - grid.first[2]});
            // It may use the transform.
            wrong += transform.count_links(part, directions, {.with_between = true}) != links.size();
        },
        {.with_between = true}, {.progress = [&](const Progress& p) { fractions.push_back(p.fraction); }});
    all.inside = whole.inside;
    BOOST_TEST(wrong == 0);
    BOOST_TEST(is_same(all, whole));
    BOOST_TEST(count == slabs.size());
    BOOST_TEST(statistics.slabs == slabs.size());
    BOOST_TEST(std::ranges::is_sorted(fractions));
    BOOST_TEST(fractions.size() > 3 * slabs.size());
    BOOST_TEST(fractions.back() == 1);
    // An error of the sink, and a stop between slabs.
    count = 0;
    const auto taking = [&](const auto& take) {
        return [&count, take](const Grid&, const Links&) {
            ++count;
            take();
        };
    };
    BOOST_CHECK_THROW(transform.links(grid, directions, taking([] { throw std::domain_error("mine"); })),
                      std::domain_error);
    BOOST_TEST(count == 1U);
    check_throws(ErrorCode::out_of_memory, {},
                 [&] { transform.links(grid, directions, taking([] { throw std::bad_alloc(); })); });
    count = 0;
    check_throws(ErrorCode::cancelled, {}, [&] {
        transform.links(grid, directions, taking([] {}), {}, {.should_stop = [&] { return count > 0; }});
    });
    BOOST_TEST(count == 1U);
    check_throws(ErrorCode::invalid_argument, {"sink", "empty"},
                 [&] { transform.links(grid, directions, LinkSink()); });
}

BOOST_AUTO_TEST_CASE(too_little_memory_names_the_grid_and_the_bytes, *boost::unit_test::precondition(on_usual_memory)) {
    const DistanceTransform transform(test_device(), ball());
    // Beyond the addresses that a process can have.
    const Grid grid{{0, 0, 0}, {1, 1, 1}, {200000, 200000, 200000}, {}};
    check_throws(ErrorCode::out_of_memory,
                 {"for the crossings of 200000 x 200000 x 200000 samples", "which take 288998560000000000 bytes",
                  "a part of the grid"},
                 [&] { transform.crossings(grid); });
    for (const bool is_counted : {false, true})
        check_throws(ErrorCode::out_of_memory,
                     {is_counted ? "to count the links" : "for the links", "200000 x 200000 x 200000 samples",
                      "1000000000000000 bytes", "a part of the grid"},
                     [&] {
                         if (is_counted)
                             transform.count_links(grid, all_directions);
                         else
                             transform.links(grid, all_directions);
                     });
}

BOOST_AUTO_TEST_CASE(links_are_written_to_memory_of_the_device) {
    const Mesh mesh = ball();
    const DistanceTransform transform(test_device(), mesh);
    const Grid grid = grid_of(mesh, 20);
    const Links links = transform.links(grid, all_directions);
    const std::size_t room = links.size() + 2;
    const cl::Context context(test_device().context(), true);
    const cl::CommandQueue queue(context, context.getInfo<CL_CONTEXT_DEVICES>().front());
    const auto filled = [&](std::size_t bytes) {
        std::vector<std::uint8_t> values(bytes, 77);
        return cl::Buffer(context, CL_MEM_READ_WRITE | CL_MEM_COPY_HOST_PTR, bytes, values.data());
    };
    // Rows with a stride and an offset, in one buffer with the sides.
    const cl::Buffer rows = filled(24 * room + grid.sample_count()), samples = filled(12 * room),
                     dense = filled(4 * 27 * grid.sample_count());
    const auto in_rows = [&](ElementType type, std::size_t offset) {
        OutputArray array(rows(), type);
        array.offset = offset;
        array.strides[0] = 24;
        return array;
    };
    OutputArray inside(rows(), ElementType::uint8);
    inside.offset = 24 * room;
    std::size_t count = 0;
    transform.links(grid, all_directions,
                    {.room = room,
                     .samples = {samples(), ElementType::int32},
                     .directions = in_rows(ElementType::uint8, 0),
                     .q = in_rows(ElementType::float64, 8),
                     .triangles = in_rows(ElementType::uint32, 16),
                     .inside = inside,
                     .dense = {dense(), ElementType::float32}},
                    count);
    BOOST_TEST(count == links.size());
    std::vector<std::uint8_t> read_rows(24 * room + grid.sample_count());
    std::vector<std::array<std::int32_t, 3>> read_samples(room);
    std::vector<float> read_dense(27 * grid.sample_count());
    queue.enqueueReadBuffer(rows, CL_TRUE, 0, read_rows.size(), read_rows.data());
    queue.enqueueReadBuffer(samples, CL_TRUE, 0, 12 * room, read_samples.data());
    queue.enqueueReadBuffer(dense, CL_TRUE, 0, 4 * read_dense.size(), read_dense.data());
    const auto at = [&]<typename T>(std::size_t n, std::size_t offset, T value) {
        std::memcpy(&value, read_rows.data() + 24 * n + offset, sizeof value);
        return value;
    };
    std::size_t wrong = 0;
    for (std::size_t n = 0; n < count; ++n)
        wrong += read_samples[n] != links.samples[n] || read_rows[24 * n] != links.directions[n] ||
                 at(n, 8, 0.0) != links.q[n] || at(n, 16, 0U) != links.triangles[n] ||
                 at(n, 20, 0U) != 77U * 0x01010101U;
    wrong += at(count, 8, std::uint64_t{0}) != 77 * 0x0101010101010101U;  // nothing behind the last row
    std::vector<float> expected(read_dense.size());
    transform.links(grid, all_directions, {.dense = expected}, count);
    BOOST_TEST((read_dense == expected));
    std::size_t sample = 24 * room;
    for (std::int64_t z = 0; z < grid.size[2]; ++z)
        for (std::int64_t y = 0; y < grid.size[1]; ++y)
            for (std::int64_t x = 0; x < grid.size[0]; ++x)
                wrong += read_rows[sample++] != (links.inside.is_inside({x, y, z}) ? 1 : 0);
    BOOST_TEST(wrong == 0);
    check_throws(ErrorCode::invalid_argument, {"array of samples", "buffer"}, [&] {
        transform.links(grid, all_directions, {.room = room + 1, .samples = {samples(), ElementType::int32}}, count);
    });
    BOOST_TEST(count == 0U);
    const cl::Buffer closed(context, CL_MEM_READ_WRITE | CL_MEM_HOST_NO_ACCESS, 8 * room);
    check_throws(ErrorCode::unsupported, {"array of q", "CL_MEM_HOST_NO_ACCESS"},
                 [&] { transform.links(grid, all_directions, {.room = room, .q = closed()}, count); });
    OutputArray shifted(rows(), ElementType::uint8);
    shifted.offset = 23 * room + 1;
    check_throws(ErrorCode::invalid_argument, {"array of flags", "array of inside", "same bytes"}, [&] {
        transform.links(grid, all_directions, {.room = room, .flags = shifted, .inside = inside}, count);
    });
}

BOOST_AUTO_TEST_CASE(a_part_that_is_not_0_or_1_is_neither_as_a_float) {
    const DistanceTransform transform(test_device(), box_between({0x1p-60, 0, 0}, {3, 1, 1}).mesh("box"));
    std::vector<float> q(1);
    std::size_t count = 0;
    transform.links({{0, 0.5, 0.5}, {1, 1, 1}, {1, 1, 1}, {}}, std::vector<LinkDirection>{{1, 0, 0}},
                    {.room = 1, .q = q}, count);
    BOOST_TEST(q[0] == 0x1p-60F);
    const DistanceTransform near(test_device(), box_between({1 - 0x1p-40, 0, 0}, {3, 1, 1}).mesh("box"));
    near.links({{0, 0.5, 0.5}, {1, 1, 1}, {1, 1, 1}, {}}, std::vector<LinkDirection>{{1, 0, 0}}, {.room = 1, .q = q},
               count);
    BOOST_TEST(q[0] == std::nextafter(1.0F, 0.0F));
}

BOOST_AUTO_TEST_CASE(faces_as_given_are_met_without_a_sign) {
    // One square, seen from both sides.
    const Mesh sheet({{0, 0, 0.25}, {8, 0, 0.25}, {8, 8, 0.25}, {0, 8, 0.25}}, {{0, 1, 2}, {0, 2, 3}}, "sheet");
    const DistanceTransform transform(test_device(), sheet, {.sign = SignRule::none});
    const std::vector<LinkDirection> directions{{0, 0, 1}, {0, 0, -1}};
    const Grid grid{{0.5, 1.25, 0}, {1, 1, 1}, {6, 6, 2}, {}};
    const Links links = transform.links(grid, directions, {.hits = Hits::faces});
    BOOST_TEST(links.size() == 72U);
    for (std::size_t n = 0; n < links.size(); ++n) {
        BOOST_TEST(links.q[n] == (links.directions[n] == 0 ? 0.25 : 0.75));
        BOOST_TEST((links.flags[n] == SegmentFlag::sheet));
        BOOST_TEST(links.counts[n] == 1U);
    }
    check_throws(ErrorCode::unsupported, {"sheet", "sign", "faces"}, [&] { transform.links(grid, directions); });
}

// All eight looks at the edge of a groove along y are inside.
BOOST_AUTO_TEST_CASE(a_sample_at_the_bottom_of_a_groove_may_be_inside_and_links_agree) {
    const std::vector<Vec3> profile{{-4, 0, -4}, {4, 0, -4}, {4, 0, 1}, {0, 0, 0}, {-4, 0, 1}};
    std::vector<Vec3> vertices;
    for (const double y : {-4.0, 4.0})
        for (const Vec3& p : profile) vertices.push_back({p[0], y, p[2]});
    std::vector<Triangle> triangles{{0, 1, 3}, {1, 2, 3}, {0, 3, 4}, {5, 8, 6}, {6, 8, 7}, {5, 9, 8}};
    for (std::uint32_t k = 0; k < 5; ++k) {
        const std::uint32_t next = (k + 1) % 5;
        triangles.push_back({k, k + 5, next});
        triangles.push_back({next, k + 5, next + 5});
    }
    const DistanceTransform transform(test_device(), Mesh(vertices, triangles, "groove"));
    BOOST_REQUIRE(transform.topology().balanced);
    const Grid grid{{0, 0, 0}, {1, 1, 1}, {1, 1, 2}, {}};  // at the bottom, and above it
    const Links links = transform.links(grid, std::vector<LinkDirection>{{0, 0, -1}});
    BOOST_TEST(links.inside.is_inside({0, 0, 0}));
    BOOST_TEST(!links.inside.is_inside({0, 0, 1}));
    BOOST_REQUIRE(links.size() == 1U);
    BOOST_TEST(links.q[0] == 1);
}

BOOST_AUTO_TEST_CASE(what_cannot_be_done_is_refused_by_name) {
    const DistanceTransform transform(test_device(), ball());
    const Grid grid{{0, 0, 0}, {1, 1, 1}, {4, 4, 4}, {}};
    check_throws(ErrorCode::invalid_argument, {"with_between", "faces"},
                 [&] { transform.count_links(grid, stencil("D3Q19"), {.hits = Hits::faces, .with_between = true}); });
    check_throws(ErrorCode::invalid_argument, {"direction 1", "17"}, [&] {
        transform.links(grid, std::vector<LinkDirection>{{1, 0, 0}, {17, 0, 0}});
    });
    check_throws(ErrorCode::invalid_argument, {"directions 0 and 2"}, [&] {
        transform.links(grid, std::vector<LinkDirection>{{1, 0, 0}, {0, 1, 0}, {1, 0, 0}});
    });
    check_throws(ErrorCode::invalid_argument, {"33 directions", "32"},
                 [&] { transform.links(grid, std::vector<LinkDirection>(33)); });
    check_throws(ErrorCode::invalid_argument, {"2^-22", "axis y"}, [&] {
        transform.links({{0, 1e12, 0}, {1e-4, 1e-4, 1e-4}, {2, 2, 2}, {}}, all_directions);
    });
    check_throws(ErrorCode::invalid_argument, {"2^-300"}, [&] {
        transform.links({{1e-200, 0, 0}, {1, 1, 1}, {2, 2, 2}, {1, 0, 0}}, all_directions);
        transform.links({{1e-200, 0, 0}, {1, 1, 1}, {2, 2, 2}, {}}, all_directions);
    });
    // So small that it is 0 in units.
    const DistanceTransform large(test_device(), box_between({0, 0, 0}, {1e10, 1e10, 1e10}).mesh("large box"));
    check_throws(ErrorCode::invalid_argument, {"5e-324", "2^-300"}, [&] {
        large.links({{5e-324, 0, 0}, {1, 1, 1}, {1, 1, 1}, {}}, all_directions);
    });
    check_throws(ErrorCode::invalid_argument, {"D3Q99", "OpenLB"}, [&] { stencil("D3Q99"); });
    check_throws(ErrorCode::cancelled, {},
                 [&] { transform.links(grid, all_directions, {}, {.should_stop = [] { return true; }}); });
    std::vector<double> fractions;
    transform.links(grid, all_directions, {},
                    {.progress = [&](const Progress& p) { fractions.push_back(p.fraction); }});
    BOOST_TEST(std::ranges::is_sorted(fractions));
    BOOST_TEST(fractions.size() > 2U);
    BOOST_TEST(fractions.back() == 1);
}

BOOST_AUTO_TEST_CASE(crossings_are_the_links_along_the_axes) {
    std::size_t all_crossed = 0;
    for (const Family& family : families()) {
        const DistanceTransform transform(test_device(), family.mesh, {.sign = family.rule});
        const Crossings crossings = transform.crossings(family.grid, {.with_counts = true});
        const auto places = places_of(family.grid, 0);
        const SegmentJudge judge(family.mesh, family.rule, places);
        std::size_t wrong = 0, crossed = 0;
        for (std::size_t axis = 0; axis < 3; ++axis) {
            const EdgeCrossings& edges = crossings.axes[axis];
            std::size_t n = 0;
            for (std::int64_t z = 0; z < edges.size[2]; ++z)
                for (std::int64_t y = 0; y < edges.size[1]; ++y)
                    for (std::int64_t x = 0; x < edges.size[0]; ++x, ++n) {
                        Index3 next{x, y, z};
                        ++next[axis];
                        const Vec3 from = position(places, {x, y, z}), to = position(places, next);
                        const LookWindings at = judge.windings(from);
                        const auto walls = judge.walls(from, to, at);
                        wrong += edges.counts[n] != walls.size();
                        if (walls.size() % 2 == 0) {
                            wrong += !std::isnan(edges.coordinates[n]) || edges.triangles[n] != no_triangle;
                            continue;
                        }
                        ++crossed;
                        const bool is_inside = judge.is_inside(at);
                        const Fraction& place = (is_inside ? walls.back() : walls.front()).place;
                        const double t =
                            static_cast<double>(boost::multiprecision::cpp_bin_float_100(place.numerator) /
                                                boost::multiprecision::cpp_bin_float_100(place.denominator));
                        const double expected = from[axis] + t * (to[axis] - from[axis]);
                        wrong += std::abs(edges.coordinates[n] - expected) >
                                 2e-16 * (std::abs(from[axis]) + std::abs(to[axis]));
                        wrong += edges.triangles[n] == no_triangle;
                    }
        }
        BOOST_TEST_CONTEXT(family.name) BOOST_TEST(wrong == 0);
        all_crossed += crossed;
        // Without counts the same but those.
        const Crossings without = transform.crossings(family.grid);
        for (std::size_t axis = 0; axis < 3; ++axis) {
            BOOST_TEST(without.axes[axis].counts.empty());
            BOOST_TEST((without.axes[axis].triangles == crossings.axes[axis].triangles));
        }
    }
    BOOST_TEST(all_crossed > 1000);
}

BOOST_AUTO_TEST_SUITE_END()
