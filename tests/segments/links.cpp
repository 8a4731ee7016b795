// Links of a lattice, against whole numbers of any size.
#include "segments/segment_families.hpp"
#include "segments/segment_judge.hpp"
#include "support/exact_field.hpp"
#include "support/throws.hpp"

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

BOOST_AUTO_TEST_SUITE_END()
