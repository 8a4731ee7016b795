// What is outside can be reached without crossing a face: bodies whose faces meet in edges of three or more
// (docs/sign.md, 'Walls within a body').

#include "surface/regions.hpp"

#include <clsdf/outer.hpp>
#include <clsdf/topology.hpp>

#include "mesh/face_crossings.hpp"
#include "support/doubtful_meshes.hpp"
#include "support/open_meshes.hpp"
#include "support/winding.hpp"
#include "surface/parts.hpp"
#include "surface/topology.hpp"

#include <boost/test/unit_test.hpp>

#include <algorithm>
#include <array>
#include <functional>
#include <map>
#include <string>
#include <utility>
#include <vector>

namespace clsdf {

using namespace test;

namespace {

/// Boxes between planes, each of a region. Regions meet in walls that are there once; 0 is not within anything.
struct Cells {
    using RegionOf = std::function<int(std::size_t, std::size_t, std::size_t)>;

    std::array<std::vector<double>, 3> planes;
    RegionOf region;

    Cells(std::vector<double> x, std::vector<double> y, std::vector<double> z, RegionOf region_of_cell)
        : planes{std::move(x), std::move(y), std::move(z)}, region(std::move(region_of_cell)) {}

    std::size_t count(std::size_t axis) const { return planes[axis].size() - 1; }
    int region_of(const std::array<std::size_t, 3>& cell) const {
        for (std::size_t axis = 0; axis < 3; ++axis)
            if (cell[axis] >= count(axis)) return 0;  // also before the first
        return region(cell[0], cell[1], cell[2]);
    }
    Vec3 middle(const std::array<std::size_t, 3>& cell) const {
        Vec3 point{};
        for (std::size_t axis = 0; axis < 3; ++axis)
            point[axis] = (planes[axis][cell[axis]] + planes[axis][cell[axis] + 1]) / 2;
        return point;
    }
    template <typename Function>
    void for_each_cell(const Function& f) const {
        for (std::size_t z = 0; z < count(2); ++z)
            for (std::size_t y = 0; y < count(1); ++y)
                for (std::size_t x = 0; x < count(0); ++x) f(std::array{x, y, z});
    }
};

/// looks_up(below, above): whether a wall between two regions looks along its axis.
Mesh walls_of(const Cells& cells, const std::function<bool(int, int)>& looks_up) {
    std::map<std::array<std::size_t, 3>, std::uint32_t> numbers;
    std::vector<Vec3> vertices;
    std::vector<Triangle> triangles;
    const auto vertex = [&](const std::array<std::size_t, 3>& at) {
        const auto [found, is_new] = numbers.emplace(at, static_cast<std::uint32_t>(vertices.size()));
        if (is_new) vertices.push_back({cells.planes[0][at[0]], cells.planes[1][at[1]], cells.planes[2][at[2]]});
        return found->second;
    };
    for (std::size_t axis = 0; axis < 3; ++axis) {
        const std::size_t first = (axis + 1) % 3, second = (axis + 2) % 3;
        for (std::size_t k = 0; k <= cells.count(axis); ++k)
            for (std::size_t i = 0; i < cells.count(first); ++i)
                for (std::size_t j = 0; j < cells.count(second); ++j) {
                    std::array<std::size_t, 3> above{}, below{};
                    above[axis] = k;
                    above[first] = i;
                    above[second] = j;
                    below = above;
                    below[axis] = k - 1;
                    const int of_below = cells.region_of(below), of_above = cells.region_of(above);
                    if (of_below == of_above) continue;
                    std::array<std::uint32_t, 4> corners{};
                    for (std::size_t n = 0; n < 4; ++n) {
                        std::array<std::size_t, 3> at = above;
                        at[first] += n == 1 || n == 2 ? 1U : 0U;
                        at[second] += n > 1 ? 1U : 0U;
                        corners[n] = vertex(at);
                    }
                    if (!looks_up(of_below, of_above)) std::swap(corners[1], corners[3]);
                    triangles.push_back({corners[0], corners[1], corners[2]});
                    triangles.push_back({corners[0], corners[2], corners[3]});
                }
    }
    return {std::move(vertices), std::move(triangles), "cells"};
}
bool to_lower(int below, int above) {  // walls look at the region with the lower number
    return above < below;
}

/// Of the surface that decides the sign.
double winding_at(const Mesh& mesh, const Vec3& point, SignRule asked = SignRule::automatic) {
    const SignSurface surface = describe_mesh(mesh, asked).surface;
    std::vector<Triangle> triangles;
    for (std::size_t face = 0; face < mesh.triangles().size(); ++face)
        triangles.push_back(surface.triangle(mesh.triangles()[face], face));
    std::erase_if(triangles, has_repeated_vertex);
    return winding_by_faces(Mesh(mesh.vertices(), std::move(triangles), ""), point);
}
bool is_inside(const Mesh& mesh, const Vec3& point) {
    return std::abs(winding_at(mesh, point)) > 0.5;
}

void check_inside(const Mesh& mesh, const Cells& cells, const std::function<bool(int)>& is_meant) {
    const Topology topology = describe_topology(mesh);
    BOOST_TEST(topology.balanced);
    BOOST_TEST(name_of(resolve_sign_rule(SignRule::automatic, topology).rule) == name_of(SignRule::nonzero));
    cells.for_each_cell([&](const std::array<std::size_t, 3>& cell) {
        BOOST_TEST_CONTEXT("cell " << cell[0] << ", " << cell[1] << ", " << cell[2])
        BOOST_TEST(is_inside(mesh, cells.middle(cell)) == is_meant(cells.region_of(cell)));
    });
}
bool is_any(int region) {
    return region != 0;
}

}  // namespace

BOOST_AUTO_TEST_SUITE(regions)

BOOST_AUTO_TEST_CASE(faces_cross_if_their_insides_have_a_line_or_an_area_in_common) {
    const std::vector<Vec3> at{{0, 0, 0},  {4, 0, 0},    {0, 4, 0},    // 0 to 2: the face
                               {1, 1, -1}, {1, 1, 1},    {9, 9, 0},    // 3 to 5: through its inside and its edge
                               {1, 1, 0},  {2, 1, 0},    {1, 2, 0},    // 6 to 8: in its plane, within
                               {4, 4, 0},  {2, 2, 0},    {0, 0, 5},    // 9: beyond; 10: on its edge; 11: above
                               {2, 2, 5},  {-1, -1, -1}, {-1, -1, 1},  // 12 to 14
                               {5, 5, -1}, {5, 5, 1},    {1, 1, 5}};   // 15 to 17
    const Triangle face{0, 1, 2};
    const auto cross = [&](const Triangle& other) {
        const bool result = faces_cross(at, face, other);
        for (Triangle turned : {Triangle{other[1], other[2], other[0]}, Triangle{other[0], other[2], other[1]}}) {
            BOOST_TEST(faces_cross(at, face, turned) == result);
            BOOST_TEST(faces_cross(at, turned, face) == result);
        }
        return result;
    };
    BOOST_TEST(cross({3, 4, 5}));     // through it
    BOOST_TEST(cross({0, 15, 16}));   // from a common vertex, across
    BOOST_TEST(!cross({0, 13, 14}));  // from a common vertex, away
    BOOST_TEST(cross({6, 7, 8}));     // within it
    BOOST_TEST(cross({0, 6, 7}));     // from a common vertex
    BOOST_TEST(cross({0, 1, 8}));     // over a common edge, back
    BOOST_TEST(!cross({1, 9, 2}));    // over a common edge
    BOOST_TEST(!cross({0, 1, 11}));   // upright on a common edge
    BOOST_TEST(!cross({6, 17, 11}));  // stands on a point
    BOOST_TEST(!cross({6, 7, 17}));   // stands on a line
    BOOST_TEST(!cross({10, 9, 12}));  // touches the edge in a point
    BOOST_TEST(!cross({5, 9, 12}));   // apart
    BOOST_TEST(cross({13, 4, 5}));    // from below, through the corner's side
}

BOOST_AUTO_TEST_CASE(every_region_of_a_body_is_inside_however_its_walls_look) {
    for (std::uint64_t seed = 1; seed <= 24; ++seed) {
        BOOST_TEST_CONTEXT("seed " << seed) {
            Random random(seed);
            Cells cells({}, {}, {}, {});
            for (std::size_t axis = 0; axis < 3; ++axis) {
                cells.planes[axis] = {0};
                for (std::size_t n = 0; n < 3; ++n)
                    cells.planes[axis].push_back(cells.planes[axis].back() + (random.index(3) == 0 ? 0.02 : 1.3));
            }
            std::array<int, 27> regions{};
            for (int& region : regions) region = 1 + static_cast<int>(random.index(4));
            cells.region = [&](std::size_t x, std::size_t y, std::size_t z) { return regions[9 * z + 3 * y + x]; };
            check_inside(walls_of(cells, [&](int, int) { return random.index(2) == 0; }), cells, is_any);
        }
    }
}

BOOST_AUTO_TEST_CASE(walls_of_bolts_layers_lumps_and_tanks_are_left_out) {
    const std::vector<double> thirds{0, 1, 2, 3}, one{0, 1}, wide{0, 32};
    const std::vector<std::pair<const char*, Cells>> all{
        {"bolt", {thirds, thirds, thirds, [](auto x, auto y, auto) { return x == 1 && y == 1 ? 2 : 1; }}},
        {"layers", {wide, wide, {0, 0.3, 0.6, 1}, [](auto, auto, auto z) { return 1 + static_cast<int>(z); }}},
        {"many layers",
         {wide,
          wide,
          {0, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 1},
          [](auto, auto, auto z) { return 1 + static_cast<int>(z); }}},
        {"lump", {thirds, thirds, thirds, [](auto x, auto y, auto z) { return x + y + z == 6 ? 2 : 1; }}},
        {"bulkheads", {{0, 10, 10.05, 20}, one, one, [](auto x, auto, auto) { return 1 + static_cast<int>(x); }}},
        {"crate", {thirds, thirds, {0, 0.1}, [](auto x, auto y, auto) { return 1 + static_cast<int>(3 * y + x); }}},
        {"a lump in a corner of another one",
         {thirds, thirds, thirds, [](auto x, auto y, auto z) { return x == 0 && y == 0 ? (z == 0 ? 3 : 2) : 1; }}}};
    for (const auto& [name, cells] : all)
        for (const auto& looks :
             {std::function<bool(int, int)>(to_lower),
              std::function<bool(int, int)>([](int a, int b) { return a == 0 || (b != 0 && a < b); })}) {
            BOOST_TEST_CONTEXT(name) {
                const Mesh mesh = walls_of(cells, looks);
                check_inside(mesh, cells, is_any);
                const Topology topology = describe_topology(mesh);
                BOOST_TEST(topology.inner_wall_faces > 0U);
                BOOST_TEST(topology.sheet_faces == topology.inner_wall_faces);
                // Each face between two regions, and no other one.
                const SignSurface surface = describe_mesh(mesh).surface;
                std::size_t walls = 0;
                Cells outer = cells;
                outer.region = [&cells = cells](auto x, auto y, auto z) { return cells.region(x, y, z) != 0 ? 1 : 0; };
                for (std::size_t face = 0; face < mesh.triangles().size(); ++face)
                    walls += surface.count(face) == 0 ? 1U : 0U;
                BOOST_TEST(mesh.triangles().size() - walls == walls_of(outer, to_lower).triangles().size());
            }
        }
}

BOOST_AUTO_TEST_CASE(the_order_of_faces_and_their_sizes_change_nothing) {
    // More small faces in a side along x than lines that are tried, before all others and after them.
    const Cells layers({0, 32}, {0, 32}, {0, 0.3, 0.6, 1}, [](auto, auto, auto z) { return 1 + static_cast<int>(z); });
    for (const std::size_t axis : {1U, 2U})
        for (const bool are_first : {true, false}) {
            const Mesh given = walls_of(layers, to_lower);
            std::vector<Vec3> vertices = given.vertices();
            std::vector<Triangle> triangles = given.triangles(), fine;
            const auto is_in_side = [&](const Triangle& face) {
                return std::ranges::all_of(
                    face, [&](std::uint32_t v) { return vertices[v][axis] == given.box().upper[axis]; });
            };
            const auto side = std::ranges::find_if(triangles, is_in_side);
            Triangle last = *side;
            triangles.erase(side);
            for (int n = 0; n < 40; ++n) {
                Vec3 middle{};
                for (const std::uint32_t v : last)
                    for (std::size_t k = 0; k < 3; ++k) middle[k] += vertices[v][k] / 3;
                middle[axis] = given.box().upper[axis];
                const auto number = static_cast<std::uint32_t>(vertices.size());
                vertices.push_back(middle);
                fine.push_back({last[0], last[1], number});
                fine.push_back({last[1], last[2], number});
                last = {last[2], last[0], number};
            }
            fine.push_back(last);
            triangles.insert(are_first ? triangles.begin() : triangles.end(), fine.begin(), fine.end());
            check_inside(Mesh(vertices, triangles, "layers with a fine side"), layers, is_any);
        }
}

BOOST_AUTO_TEST_CASE(corners_in_edges_are_no_holes_of_chambers) {
    const Cells two({0, 1, 2}, {0, 1}, {0, 1}, [](auto x, auto, auto) { return 1 + static_cast<int>(x); });
    for (const std::size_t axis : {0U, 1U}) {  // along which the bottom of a chamber is divided
        const Mesh given = walls_of(two, to_lower);
        std::vector<Vec3> vertices = given.vertices();
        std::vector<Triangle> triangles = given.triangles();
        const auto is_bottom = [&](const Triangle& face) {
            return std::ranges::all_of(face,
                                       [&](std::uint32_t v) { return vertices[v][2] == 0 && vertices[v][0] <= 1; });
        };
        const auto number_of = [&](const Vec3& at) {
            const auto found = std::ranges::find(vertices, at);
            if (found == vertices.end()) vertices.push_back(at);
            return static_cast<std::uint32_t>(std::ranges::find(vertices, at) - vertices.begin());
        };
        const bool looks_up = [&] {
            const Triangle& face = *std::ranges::find_if(triangles, is_bottom);
            const Vec3 &a = vertices[face[0]], &b = vertices[face[1]], &c = vertices[face[2]];
            return (b[0] - a[0]) * (c[1] - a[1]) > (b[1] - a[1]) * (c[0] - a[0]);
        }();
        std::erase_if(triangles, is_bottom);
        for (const double low : {0.0, 0.5}) {
            std::array<std::uint32_t, 4> corners{};
            for (std::size_t n = 0; n < 4; ++n) {
                Vec3 at{n == 1 || n == 2 ? 1.0 : 0.0, n > 1 ? 1.0 : 0.0, 0};
                at[axis] = low + at[axis] / 2;
                corners[n] = number_of(at);
            }
            if (!looks_up) std::swap(corners[1], corners[3]);
            triangles.push_back({corners[0], corners[1], corners[2]});
            triangles.push_back({corners[0], corners[2], corners[3]});
        }
        const Mesh mesh(vertices, triangles, "two chambers");
        BOOST_TEST(describe_topology(mesh).inner_wall_faces == 2U);
        two.for_each_cell([&](const auto& cell) { BOOST_TEST(is_inside(mesh, two.middle(cell))); });
        BOOST_TEST(!is_inside(mesh, {1, 0.5, -0.1}));
        const OuterSurface surface = outer(mesh);
        BOOST_TEST(std::abs(surface.volume - 2) < 1e-12);
        BOOST_TEST(std::abs(surface.area - 10) < 1e-12);
    }
}

BOOST_AUTO_TEST_CASE(a_rim_that_crosses_the_skin_by_a_rounding_touches_it) {
    const Cells tank({0, 1, 2}, {0, 1}, {0, 3}, [](auto, auto, auto) { return 1; });
    const Mesh skin = walls_of(tank, to_lower);
    std::vector<Vec3> vertices = skin.vertices();
    std::vector<Triangle> triangles = skin.triangles();
    // A baffle that stands on the bottom; its sides lie on those of the tank.
    const auto number_of = [&](const Vec3& at) {
        return static_cast<std::uint32_t>(std::ranges::find(vertices, at) - vertices.begin());
    };
    const std::uint32_t a = number_of({1, 0, 0}), b = number_of({1, 1, 0}),
                        top = static_cast<std::uint32_t>(vertices.size());
    BOOST_REQUIRE(std::max(a, b) < top);
    vertices.insert(vertices.end(), {{1, 0, 0.9}, {1, 1, 0.9}});
    triangles.insert(triangles.end(), {{a, b, top + 1}, {a, top + 1, top}});
    constexpr std::uint64_t seed = 6;
    BOOST_TEST_MESSAGE("seed " << seed);
    Random random(seed);
    for (int trial = 0; trial < 40; ++trial) {
        const double angle = random.uniform(0, 6), other = random.uniform(0, 6);
        const auto turned = [&](const Vec3& v) {
            const Vec3 once{std::cos(angle) * v[0] - std::sin(angle) * v[1],
                            std::sin(angle) * v[0] + std::cos(angle) * v[1], v[2]};
            return Vec3{once[0], std::cos(other) * once[1] - std::sin(other) * once[2],
                        std::sin(other) * once[1] + std::cos(other) * once[2]};
        };
        std::vector<Vec3> at;
        for (const Vec3& v : vertices) at.push_back(turned(v));
        const Mesh mesh(at, triangles, "tank " + std::to_string(trial));
        BOOST_TEST(describe_topology(mesh).sheet_faces == 2U, trial);
        for (const Vec3& point : {Vec3{0.9, 0.5, 0.5}, Vec3{1.1, 0.5, 0.5}, Vec3{1, 0.5, 2}})
            BOOST_TEST(is_inside(mesh, turned(point)), trial);
        BOOST_TEST(!is_inside(mesh, turned({1, 0.5, -0.2})));
    }
}

BOOST_AUTO_TEST_CASE(free_baffles_within_a_body_enclose_nothing) {
    // Two of them beside the end of a box of 2 x 2 x 1, turned; the box around them reaches beyond the body.
    const Mesh mesh({{0, 0, 0},
                     {-1.655129548170382, -0.060262052677034716, 1.1211220557015444},
                     {-0.9751842988569948, 1.0668488875880944, -1.3823346318149006},
                     {-2.630313847027377, 1.0065868349110596, -0.26121257611335613},
                     {-0.27819137389398785, -0.8453108800996227, -0.4561349312168237},
                     {-1.93332092206437, -0.9055729327766575, 0.6649871244847207},
                     {-1.2533756727509826, 0.22153800748847163, -1.8384695630317243},
                     {-2.9085052209213647, 0.16127595481143686, -0.7173475073301798},
                     {-1.5291436548303654, -0.05033154879579094, 0.9820348089389191},
                     {-2.4653205817330806, 0.9738433832887798, -0.34500643760338545},
                     {-2.732384300671309, 0.162344938393142, -0.7828959715715362},
                     {-1.7962073737685937, -0.8618299936914288, 0.5441452749707684},
                     {-1.5338255650480979, -0.05050201371225746, 0.9852061575585583},
                     {-2.4700024919508126, 0.9736729183723133, -0.34183508898374626},
                     {-2.737066210889041, 0.16217447347667546, -0.779724622951897},
                     {-1.8008892839863262, -0.8620004586078952, 0.5473166235904076}},
                    {{0, 2, 3},
                     {0, 3, 1},
                     {4, 5, 7},
                     {4, 7, 6},
                     {0, 1, 4},
                     {1, 5, 4},
                     {2, 6, 3},
                     {6, 7, 3},
                     {0, 4, 6},
                     {0, 6, 2},
                     {1, 3, 7},
                     {1, 7, 5},
                     {8, 9, 10},
                     {8, 10, 11},
                     {12, 13, 14},
                     {12, 14, 15}},
                    "baffles");
    const Topology topology = describe_topology(mesh);
    BOOST_TEST(topology.sheet_faces == 4U);
    BOOST_TEST(name_of(resolve_sign_rule(SignRule::automatic, topology).rule) == name_of(SignRule::nonzero));
}

BOOST_AUTO_TEST_CASE(a_free_triangle_brings_no_walls_back) {
    const Cells layers({0, 32}, {0, 32}, {0, 0.25, 0.5, 0.75, 1},
                       [](auto, auto, auto z) { return 1 + static_cast<int>(z); });
    for (const double size : {0.05, 10.0})
        for (const double z : {3.0, 0.3}) {
            const Mesh mesh = together({walls_of(layers, to_lower),
                                        Mesh({{10, 10, z}, {10 + size, 10, z}, {10, 10 + size, z}}, {{0, 1, 2}}, "")},
                                       "layers and a triangle");
            layers.for_each_cell([&](const auto& cell) { BOOST_TEST(is_inside(mesh, layers.middle(cell))); });
            BOOST_TEST(!is_inside(mesh, {16, 16, 2}));
        }
}

BOOST_AUTO_TEST_CASE(a_region_that_looks_like_a_cavity_is_one) {
    // A cavity in the middle of a rod of another region that goes through a body.
    const std::vector<double> fives{0, 1, 2, 3, 4, 5};
    const Cells cells{fives, fives, fives, [](auto x, auto y, auto z) {
                          return y != 2 || z != 2 ? 1 : x == 2 ? 0 : 2;
                      }};
    const Mesh mesh = walls_of(cells, to_lower);
    check_inside(mesh, cells, is_any);
    // One wall of the cavity that looks away from it is enough: the region is inside.
    const Mesh other =
        walls_of(cells, [](int below, int above) { return (below == 0 && above == 2) || to_lower(below, above); });
    BOOST_TEST(is_inside(other, {2.5, 2.5, 2.5}));
    // Turned inside out, the mesh has the same inside.
    check_inside(reversed(mesh), cells, is_any);
    BOOST_TEST(describe_topology(reversed(mesh)).inside_out);
    // A cavity that touches the skin in an edge; there its body has no inside in between.
    const Cells touching{fives, fives, fives, [](auto x, auto y, auto z) {
                             return x == 4 && y == 4 && z == 2 ? 0 : x == 3 && y == 3 && z == 2 ? 2 : 1;
                         }};
    const Mesh notched = walls_of(touching, to_lower);
    check_inside(notched, touching, is_any);
}

BOOST_AUTO_TEST_CASE(a_cavity_that_one_wall_joins_to_the_skin_stays_a_cavity) {
    const Mesh body = weld(together({box({0, 0, 0}, {4, 4, 4}), reversed(box({1, 1, 1}, {2, 2, 2}))}, ""));
    const auto vertex = [&](const Vec3& at) {
        return static_cast<std::uint32_t>(std::ranges::find(body.vertices(), at) - body.vertices().begin());
    };
    const std::uint32_t a = vertex({0, 0, 0}), b = vertex({0, 0, 4}), c = vertex({1, 1, 1}), d = vertex({1, 1, 2});
    for (const std::vector<Triangle>& wall : {std::vector<Triangle>{{a, b, d}, {a, d, c}}, {{a, d, b}, {a, c, d}}}) {
        const Mesh mesh = with_faces(body, wall, "");
        const Topology topology = describe_topology(mesh);
        BOOST_TEST(topology.balanced);
        BOOST_TEST(topology.inner_wall_faces == 2U);
        BOOST_TEST(!is_inside(mesh, {1.5, 1.5, 1.5}));
        BOOST_TEST(is_inside(mesh, {3, 3, 3}));
        BOOST_TEST(is_inside(mesh, {0.5, 0.6, 2}));
    }
}

BOOST_AUTO_TEST_CASE(sheets_that_stand_on_a_body_are_left_out) {
    // Fins over the width of a block, on edges of their own.
    for (const std::size_t fins : {1U, 2U, 10U})
        for (unsigned looks = 0; looks < (fins == 2 ? 4U : 2U); ++looks) {
            BOOST_TEST_CONTEXT(fins << " fins, " << looks) {
                std::vector<double> along{0};
                for (std::size_t n = 0; n < fins; ++n) along.push_back(9 + 0.1 * static_cast<double>(n));
                along.push_back(20);
                const Mesh block = walls_of({along, {0, 1}, {0, 1}, [](auto, auto, auto) { return 1; }}, to_lower);
                std::vector<Vec3> vertices = block.vertices();
                std::vector<Triangle> triangles = block.triangles();
                const auto vertex = [&](const Vec3& at) {
                    return static_cast<std::uint32_t>(std::ranges::find(vertices, at) - vertices.begin());
                };
                for (std::size_t n = 0; n < fins; ++n) {
                    const double x = along[n + 1];
                    const std::uint32_t a = vertex({x, 0, 1}), b = vertex({x, 1, 1});
                    const auto c = static_cast<std::uint32_t>(vertices.size()), d = c + 1;
                    vertices.push_back({x, 0, 2});
                    vertices.push_back({x, 1, 2});
                    const bool is_turned = (looks >> n % 2 & 1U) != 0;
                    triangles.push_back(is_turned ? Triangle{a, d, b} : Triangle{a, b, d});
                    triangles.push_back(is_turned ? Triangle{a, c, d} : Triangle{a, d, c});
                }
                const Mesh mesh(vertices, triangles, "");
                const Topology topology = describe_topology(mesh);
                BOOST_TEST(topology.balanced);
                BOOST_TEST(topology.sheet_faces == 2 * fins);
                BOOST_TEST(topology.inner_wall_faces == 0U);
                BOOST_TEST(topology.first_sheet_face == block.triangles().size());
                for (const double x : {8.9, 9.05, 9.15, 10.5}) {
                    BOOST_TEST(!is_inside(mesh, {x, 0.5, 1.5}));
                    BOOST_TEST(is_inside(mesh, {x, 0.5, 0.5}));
                }
                const std::string warning = resolve_sign_rule(SignRule::automatic, topology).warning;
                BOOST_TEST(warning.find("left out (the first is triangle") != std::string::npos, warning);
                BOOST_TEST(warning.find("close it") != std::string::npos, warning);
            }
        }
    // Apart from the block, and looking the same way.
    const auto sheet = [](double x) {
        return Mesh({{x, 0, 1.01}, {x, 1, 1.01}, {x, 1, 2}, {x, 0, 2}}, {{0, 1, 2}, {0, 2, 3}}, "sheet");
    };
    const Mesh apart = together({box({0, 0, 0}, {20, 1, 1}), sheet(10), sheet(10.05)}, "");
    const Topology topology = describe_topology(apart);
    BOOST_TEST(topology.balanced);
    BOOST_TEST(topology.sheet_faces == 4U);
    BOOST_TEST(topology.enclosing_faces == 0U);
}

BOOST_AUTO_TEST_CASE(a_hole_lets_out_the_chamber_that_has_it) {
    const Cells cells{{0, 4}, {0, 4}, {0, 1, 2, 3}, [](auto, auto, auto z) { return 1 + static_cast<int>(z); }};
    const Mesh whole = walls_of(cells, to_lower);
    // A triangle of the top, one of the bottom, or one of a wall between two chambers.
    const auto without = [&](double height) {
        for (std::size_t face = 0;; ++face)
            if (std::ranges::all_of(whole.triangles()[face],
                                    [&](std::uint32_t v) { return whole.vertices()[v][2] == height; }))
                return without_triangle(whole, face);
    };
    for (const auto& [height, open] : {std::pair(3.0, 3), {0.0, 1}}) {
        const Mesh mesh = without(height);
        check_inside(mesh, cells, [open = open](int region) { return region != open; });
        const Topology topology = describe_topology(mesh);
        BOOST_TEST(topology.sheet_faces > topology.inner_wall_faces);
        BOOST_TEST(topology.inner_wall_faces == 2U);
        const std::string warning = resolve_sign_rule(SignRule::automatic, topology).warning;
        BOOST_TEST(warning.find("close it") != std::string::npos, warning);
    }
    check_inside(without(1), cells, is_any);
    // A body that is all one chamber has a film over its hole, as before, whatever bubbles it has at its skin.
    const std::vector<double> fours{0, 1, 2, 3, 4};
    const Cells bubbles{fours, fours, fours, [](auto x, auto y, auto z) { return x == 0 && y == 1 && z == 1 ? 2 : 1; }};
    const Mesh skin = walls_of(bubbles, to_lower);
    std::size_t face = skin.triangles().size();
    const auto is_top = [&](std::uint32_t v) { return skin.vertices()[v][2] == 4; };
    do --face;
    while (!std::ranges::all_of(skin.triangles()[face], is_top));
    const Topology topology = describe_topology(without_triangle(skin, face));
    BOOST_TEST(!topology.balanced);
    BOOST_TEST(name_of(resolve_sign_rule(SignRule::automatic, topology).rule) == name_of(SignRule::solid_angle));
}

BOOST_AUTO_TEST_CASE(what_is_not_of_that_kind_keeps_its_rules) {
    // Balanced, also with edges of four faces; a closed surface without an orientation; bodies apart.
    const Mesh touching = weld(together({box({0, 0, 0}, {1, 1, 1}), box({1, 1, 0}, {2, 2, 1})}, ""));
    BOOST_TEST(describe_mesh(touching).surface.is_mesh());
    // A wall that crosses the skin elsewhere than at an edge.
    const Mesh membrane = boxes_with_membrane();
    std::vector<Vec3> vertices = membrane.vertices();
    const std::size_t wall = [&] {
        for (std::size_t face = 0;; ++face)
            if (std::ranges::all_of(membrane.triangles()[face],
                                    [&](std::uint32_t v) { return membrane.vertices()[v][0] == 1; }))
                return face;
    }();
    const Triangle corners = membrane.triangles()[wall];
    std::vector<Triangle> triangles = membrane.triangles();
    vertices.push_back({1.4, 0.5, 3});  // a fin on the wall's edge that goes through the lid
    triangles.push_back({corners[0], corners[1], static_cast<std::uint32_t>(vertices.size() - 1)});
    triangles.push_back({corners[1], corners[2], static_cast<std::uint32_t>(vertices.size() - 1)});
    std::vector<Triangle> all = triangles;
    BOOST_TEST(roles_by_reach(Mesh(vertices, all, ""), all).empty());
    BOOST_TEST(!roles_by_reach(membrane, membrane.triangles()).empty());
}

BOOST_AUTO_TEST_CASE(blocks_on_both_sides_that_touch_in_walls_count_once) {
    const auto several = [](std::size_t count) {
        std::vector<double> planes;
        for (std::size_t n = 0; n <= count; ++n) planes.push_back(static_cast<double>(n));
        return planes;
    };
    for (const std::size_t high : {1U, 2U}) {
        const Cells cells{several(2), several(high), several(high),
                          [](auto x, auto y, auto z) { return 1 + static_cast<int>(x + 2 * y + 4 * z); }};
        const Mesh once = walls_of(cells, to_lower);
        std::vector<Triangle> twice, of_each;  // each wall both ways; each block with walls of its own
        for (const Triangle& face : once.triangles()) {
            bool is_wall = false;
            for (std::size_t axis = 0; axis < 3; ++axis) {
                const double at = once.vertices()[face[0]][axis];
                is_wall = is_wall ||
                          (at > 0 && at < cells.planes[axis].back() &&
                           std::ranges::all_of(face, [&](std::uint32_t v) { return once.vertices()[v][axis] == at; }));
            }
            for (std::vector<Triangle>* const faces : {&twice, &of_each})
                faces->insert(faces->end(), {face, turned(face)});
            if (is_wall) of_each.insert(of_each.end(), {face, turned(face)});
        }
        for (const std::vector<Triangle>& faces : {twice, of_each}) {
            const Mesh mesh(once.vertices(), faces, "");
            check_inside(mesh, cells, is_any);
            BOOST_TEST(describe_topology(mesh).double_sided_faces == (high == 1 ? 20U : 48U));
        }
    }
    // Both ways, but with other diagonals: nothing is inside, and the warning says so.
    const Mesh one = open_box({0, 0, 0}, {1, 1, 1}, 6), other = reversed(open_box({0, 0, 0}, {1, 1, 1}, 6, 1));
    const Mesh mesh = together({one, other, one, reversed(one)}, "");
    const std::string warning = resolve_sign_rule(SignRule::automatic, describe_topology(mesh)).warning;
    BOOST_TEST(warning.find("perhaps nothing is") != std::string::npos, warning);
}

BOOST_AUTO_TEST_CASE(a_face_without_an_area_stands_where_its_neighbour_does) {
    // The lid on one side of a wall is divided finer; a face without an area joins the wall's edge to its halves.
    const Cells cells{{0, 1, 2}, {0, 1}, {0, 1}, [](auto x, auto, auto) { return 1 + static_cast<int>(x); }};
    const Mesh mesh = walls_of(cells, to_lower);
    const auto vertex = [&](const Vec3& at) {
        return static_cast<std::uint32_t>(std::ranges::find(mesh.vertices(), at) - mesh.vertices().begin());
    };
    const std::uint32_t a = vertex({1, 0, 1}), b = vertex({1, 1, 1});
    std::vector<Vec3> vertices = mesh.vertices();
    const auto middle = static_cast<std::uint32_t>(vertices.size());
    vertices.push_back({1, 0.25, 1});
    std::vector<Triangle> triangles;
    for (const Triangle& face : mesh.triangles()) {
        const auto place = [&](std::uint32_t v) { return std::ranges::find(face, v) - face.begin(); };
        const auto apex = std::ranges::find_if(face, [&](std::uint32_t v) { return v != a && v != b; });
        const bool is_on_left_lid = place(a) < 3 && place(b) < 3 && vertices[*apex][0] == 0 && vertices[*apex][2] == 1;
        if (!is_on_left_lid) {
            triangles.push_back(face);
            continue;
        }
        for (const std::uint32_t end : {a, b}) {
            Triangle half = face;
            half[static_cast<std::size_t>(place(end))] = middle;
            triangles.push_back(half);
        }
    }
    triangles.push_back({a, middle, b});
    BOOST_TEST(triangles.size() == mesh.triangles().size() + 2);
    for (const Triangle& last : {Triangle{a, middle, b}, {a, b, middle}}) {
        triangles.back() = last;
        check_inside(Mesh(vertices, triangles, ""), cells, is_any);
    }
}

BOOST_AUTO_TEST_CASE(doubled_faces_and_turned_ones_change_nothing) {
    const Cells cells{
        {0, 1, 2}, {0, 1}, {0, 1, 2}, [](auto x, auto, auto z) { return 1 + static_cast<int>(2 * z + x); }};
    const Mesh mesh = walls_of(cells, to_lower);
    for (std::uint64_t seed = 1; seed <= 12; ++seed) {
        BOOST_TEST_CONTEXT("seed " << seed) {
            Random random(seed);
            std::vector<Triangle> triangles = mesh.triangles();
            for (int n = 0; n < 5; ++n) {
                const Triangle face = triangles[random.index(static_cast<std::uint32_t>(triangles.size()))];
                triangles.push_back(random.index(2) == 0 ? face : turned(face));
            }
            check_inside(Mesh(mesh.vertices(), triangles, ""), cells, is_any);
            check_inside(reordered(unwelded(mesh), random), cells, is_any);
        }
    }
}

BOOST_AUTO_TEST_SUITE_END()

}  // namespace clsdf
