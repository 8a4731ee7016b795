// Links and crossings of open meshes, whose film has walls without a triangle.
#include "support/exact_field.hpp"
#include "support/open_meshes.hpp"
#include "support/queries.hpp"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

using namespace clsdf;
using namespace clsdf::test;

namespace {

const std::vector<LinkDirection> all_directions = stencil("D3Q27");

/// The side of points: known unless they lie on a face or an open edge, where eight points around one differ, or a
/// winding number is near one half.
struct Sides {
    std::vector<bool> are_inside, are_known;
};

Sides sides_of(const DistanceTransform& transform, std::span<const Vec3> points) {
    constexpr Vec3 apart{1e-7, 3e-9, 1e-10};
    std::vector<Vec3> looks;
    for (const Vec3& p : points)
        for (unsigned look = 0; look < 8; ++look) {
            Vec3 at = p;
            for (std::size_t axis = 0; axis < 3; ++axis)
                at[axis] += (look >> axis & 1U) != 0 ? apart[axis] : -apart[axis];
            looks.push_back(at);
        }
    std::vector<double> windings(looks.size());
    transform.winding(looks, windings);
    Sides sides;
    for (std::size_t i = 0; i < points.size(); ++i) {
        const std::span<const double> of_looks(windings.data() + 8 * i, 8);
        const auto count = std::ranges::count_if(of_looks, [](double w) { return std::abs(w) > 0.5; });
        sides.are_inside.push_back(count == 8);
        sides.are_known.push_back((count == 0 || count == 8) && std::ranges::all_of(of_looks, [](double w) {
                                      return std::abs(std::abs(w) - 0.5) > 1e-4;
                                  }));
    }
    return sides;
}

/// A segment from outside to inside, and the part of it up to its first wall.
struct Walled {
    Vec3 from, to;
    double q;
    bool has_one_wall;

    Vec3 at(double part) const {
        Vec3 p{};
        for (std::size_t axis = 0; axis < 3; ++axis) p[axis] = from[axis] + part * (to[axis] - from[axis]);
        return p;
    }
};

/// Points of segments that lie on another side than the walls say. They are outside up to the first wall, and inside
/// behind an only one.
struct Judged {
    std::size_t known = 0, wrong = 0;
    std::string first;
};
Judged judge(const DistanceTransform& transform, const std::vector<Walled>& segments) {
    constexpr double near = 1e-4;  // a wall is not looked at
    std::vector<Vec3> points;
    std::vector<std::size_t> segment_of;
    std::vector<bool> expected;
    const auto add = [&](std::size_t n, double part, bool is_inside) {
        points.push_back(segments[n].at(part));
        segment_of.push_back(n);
        expected.push_back(is_inside);
    };
    for (std::size_t n = 0; n < segments.size(); ++n) {
        const double q = segments[n].q, rest = 1 - q - near;
        if (q > 3 * near)
            for (const double part : {0.03, 0.3, 0.6, 0.9, 1.0}) add(n, part * (q - near), false);
        if (rest > 2 * near && segments[n].has_one_wall)
            for (const double part : {0.0, 0.1, 0.4, 0.7, 0.97}) add(n, q + near + part * rest, true);
    }
    Judged judged;
    const Sides sides = sides_of(transform, points);
    for (std::size_t i = 0; i < points.size(); ++i) {
        if (!sides.are_known[i]) continue;
        ++judged.known;
        if (sides.are_inside[i] == expected[i] || judged.wrong++ > 0) continue;
        const Walled& one = segments[segment_of[i]];
        judged.first =
            fmt::format("from ({} {} {}) to ({} {} {}): q {}, at ({} {} {})", one.from[0], one.from[1], one.from[2],
                        one.to[0], one.to[1], one.to[2], one.q, points[i][0], points[i][1], points[i][2]);
    }
    return judged;
}

std::vector<Walled> walled(const Grid& grid, const Links& links) {
    std::vector<Walled> segments;
    for (std::size_t n = 0; n < links.size(); ++n) {
        Walled one{{}, {}, links.q[n], links.counts[n] == 1};
        for (std::size_t axis = 0; axis < 3; ++axis) {
            const double from = links.samples[n][axis], to = from + all_directions[links.directions[n]][axis];
            one.from[axis] = grid.origin[axis] + grid.spacing[axis] * from;
            one.to[axis] = grid.origin[axis] + grid.spacing[axis] * to;
        }
        segments.push_back(one);
    }
    return segments;
}

std::vector<Walled> walled(const Grid& grid, const Crossings& crossings) {
    std::vector<Walled> segments;
    for (std::size_t axis = 0; axis < 3; ++axis) {
        const EdgeCrossings& edges = crossings.axes[axis];
        for (std::size_t n = 0; n < edges.coordinates.size(); ++n) {
            if (std::isnan(edges.coordinates[n])) continue;
            const auto number = static_cast<std::int64_t>(n);
            Index3 from{number % edges.size[0], number / edges.size[0] % edges.size[1],
                        number / edges.size[0] / edges.size[1]},
                to = from;
            ++to[axis];
            if (crossings.inside.is_inside(from)) std::swap(from, to);
            Walled one{grid.position(from[0], from[1], from[2]), grid.position(to[0], to[1], to[2]), 0,
                       edges.counts[n] == 1};
            one.q = (edges.coordinates[n] - one.from[axis]) / (one.to[axis] - one.from[axis]);
            segments.push_back(one);
        }
    }
    return segments;
}

/// The cube from 2 to 6 without one of its six sides, or without one of its twelve triangles.
std::vector<Mesh> cubes_with_a_gap() {
    constexpr std::size_t none = 6;
    std::vector<Mesh> meshes;
    for (const std::size_t turn : {std::size_t{0}, std::size_t{1}}) {
        for (std::size_t side = 0; side < 6; ++side) meshes.push_back(open_box({2, 2, 2}, {6, 6, 6}, side, turn));
        const Mesh cube = open_box({2, 2, 2}, {6, 6, 6}, none, turn);
        for (std::size_t missing = 0; missing < cube.triangles().size(); ++missing)
            meshes.push_back(with_chosen_faces(cube, "cube without triangle " + std::to_string(missing),
                                               [&](std::size_t i) { return i != missing; }));
    }
    return meshes;
}

/// Lattices through sides, edges, corners and diagonals of these cubes.
std::vector<Grid> lattices_of_cubes() {
    return {{{0, 0, 0}, {1, 1, 1}, {9, 9, 9}, {}},
            {{0.5, 0.5, 0.5}, {1, 1, 1}, {8, 8, 8}, {}},
            {{0.5, 1, 0.25}, {1, 1, 1}, {8, 8, 8}, {}},
            {{1, 0.5, 1}, {0.5, 0.75, 0.5}, {11, 8, 11}, {}}};
}

}  // namespace

BOOST_AUTO_TEST_SUITE(film_of_links)

BOOST_AUTO_TEST_CASE(the_film_of_an_open_mesh_is_met) {
    constexpr std::size_t lid = 5;
    const Mesh mesh = open_box({1, 1, 1}, {9, 9, 9}, lid);
    const DistanceTransform transform(test_device(), mesh, {.sign = SignRule::solid_angle});
    const Grid grid{{0.3, 0.4, 0.2}, {0.7, 0.7, 0.7}, {15, 15, 16}, {}};
    const Links links = transform.links(grid, all_directions);
    const Field field = query(transform, samples_of(grid), no_limit);
    const auto is_inside = [&](const Index3& p) { return field.distance()[grid.offset(p[0], p[1], p[2])] < 0; };
    std::size_t wrong = 0, films = 0, rows = 0, expected = 0;
    for (std::int64_t z = 0; z < 16; ++z)
        for (std::int64_t y = 0; y < 15; ++y)
            for (std::int64_t x = 0; x < 15; ++x) {
                wrong += links.inside.is_inside({x, y, z}) != is_inside({x, y, z});
                for (const auto& [cx, cy, cz] : all_directions) {
                    const Index3 q{x + cx, y + cy, z + cz};
                    bool is_in = true;
                    for (std::size_t axis = 0; axis < 3; ++axis)
                        is_in = is_in && q[axis] >= 0 && q[axis] < grid.size[axis];
                    expected += is_in && !is_inside({x, y, z}) && is_inside(q);
                }
            }
    double worst = 0;
    for (std::size_t n = 0; n < links.size(); ++n) {
        const auto& sample = links.samples[n];
        const auto& c = all_directions[links.directions[n]];
        Vec3 at{};
        bool is_in = true;
        for (std::size_t axis = 0; axis < 3; ++axis) {
            at[axis] = grid.origin[axis] + grid.spacing[axis] * (sample[axis] + links.q[n] * c[axis]);
            is_in = is_in && sample[axis] + c[axis] >= 0 && sample[axis] + c[axis] < grid.size[axis];
        }
        rows += is_in;
        if (links.flags[n] != SegmentFlag::film) {
            wrong += links.triangles[n] == no_triangle;
            continue;
        }
        ++films;
        wrong += links.triangles[n] != no_triangle;
        double winding = 0;
        const std::vector<Vec3> points{at};
        transform.winding(points, std::span(&winding, 1));
        worst = std::max(worst, std::abs(std::abs(winding) - 0.5));
    }
    BOOST_TEST(wrong == 0);
    BOOST_TEST(rows == expected);
    BOOST_TEST(films > 500);
    BOOST_TEST(worst < 1e-8);
}

BOOST_AUTO_TEST_CASE(the_first_wall_is_where_the_side_changes_also_at_open_edges_and_from_them) {
    std::size_t films = 0, from_edges = 0, known_on_links = 0, known_on_edges = 0;
    for (const Mesh& mesh : cubes_with_a_gap()) {
        const DistanceTransform transform(test_device(), mesh, {.sign = SignRule::solid_angle});
        for (const Grid& grid : lattices_of_cubes()) {
            const Links links = transform.links(grid, all_directions);
            for (std::size_t n = 0; n < links.size(); ++n) {
                if (links.flags[n] != SegmentFlag::film) continue;
                ++films;
                from_edges += links.q[n] == 0 ? 1U : 0U;
            }
            const Judged on_links = judge(transform, walled(grid, links)),
                         on_edges = judge(transform, walled(grid, transform.crossings(grid, {.with_counts = true})));
            known_on_links += on_links.known;
            known_on_edges += on_edges.known;
            BOOST_TEST_CONTEXT(mesh.name() << ", lattice at " << grid.origin[0] << " " << grid.origin[1]) {
                BOOST_TEST(on_links.wrong == 0U, on_links.wrong << " of " << on_links.known << " " << on_links.first);
                BOOST_TEST(on_edges.wrong == 0U, on_edges.wrong << " of " << on_edges.known << " " << on_edges.first);
            }
        }
    }
    BOOST_TEST_MESSAGE(films << " films on links, " << from_edges << " from open edges, " << known_on_links << " and "
                             << known_on_edges << " points");
    BOOST_TEST(films > 1000U);
    BOOST_TEST(from_edges > 10U);
    BOOST_TEST(known_on_links > 200000U);
    BOOST_TEST(known_on_edges > 20000U);
}

BOOST_AUTO_TEST_SUITE_END()
