// Links and crossings of open meshes, whose film has walls without a triangle.
#include "support/exact_field.hpp"
#include "support/open_meshes.hpp"
#include "support/queries.hpp"

#include <algorithm>
#include <cmath>
#include <string>

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
    std::size_t rows = 0, films = 0, from_edges = 0;
    for (const Mesh& mesh : cubes_with_a_gap()) {
        const DistanceTransform transform(test_device(), mesh, {.sign = SignRule::solid_angle});
        for (const Grid& grid : lattices_of_cubes()) {
            const Links links = transform.links(grid, all_directions);
            std::vector<Vec3> before, behind;
            std::vector<std::size_t> of_before, of_behind;
            std::size_t wrong = 0;
            std::string which;
            const auto place = [&](std::size_t n, double t) {
                Vec3 p{};
                for (std::size_t axis = 0; axis < 3; ++axis)
                    p[axis] = grid.origin[axis] + grid.spacing[axis] * (links.samples[n][axis] +
                                                                        t * all_directions[links.directions[n]][axis]);
                return p;
            };
            constexpr double near = 1e-4;
            for (std::size_t n = 0; n < links.size(); ++n) {
                const double q = links.q[n];
                const bool is_film = links.flags[n] == SegmentFlag::film;
                films += is_film;
                from_edges += is_film && q == 0;
                for (const double part : {0.03, 0.3, 0.6, 0.9}) {
                    if (q < 3 * near) continue;
                    before.push_back(place(n, part * (q - near)));
                    of_before.push_back(n);
                }
                if (q < 3 * near) continue;
                before.push_back(place(n, q - near));
                of_before.push_back(n);
            }
            for (std::size_t n = 0; n < links.size(); ++n) {
                if (links.counts[n] != 1) continue;
                const double q = links.q[n];
                for (const double part : {0.0, 0.1, 0.4, 0.7, 0.97}) {
                    if (1 - q < 3 * near) continue;
                    behind.push_back(place(n, q + near + part * (1 - q - near)));
                    of_behind.push_back(n);
                }
            }
            rows += links.size();
            const auto look_at = [&](const std::vector<Vec3>& points, const std::vector<std::size_t>& of,
                                     bool expected) {
                const Sides sides = sides_of(transform, points);
                for (std::size_t i = 0; i < points.size(); ++i) {
                    if (!sides.are_known[i] || sides.are_inside[i] == expected) continue;
                    if (wrong++ == 0) {
                        const std::size_t n = of[i];
                        const auto& s = links.samples[n];
                        const auto& d = all_directions[links.directions[n]];
                        which = fmt::format(
                            "sample ({} {} {}) direction ({} {} {}): q {}, flag {}, count {}, at ({} {} {})", s[0],
                            s[1], s[2], d[0], d[1], d[2], links.q[n], static_cast<int>(links.flags[n]), links.counts[n],
                            points[i][0], points[i][1], points[i][2]);
                    }
                }
            };
            look_at(before, of_before, false);
            look_at(behind, of_behind, true);
            BOOST_TEST_CONTEXT(mesh.name() << ", lattice at " << grid.origin[0] << " " << grid.origin[1])
            BOOST_TEST(wrong == 0U, wrong << " of " << before.size() + behind.size() << " points; " << which);
        }
    }
    BOOST_TEST_MESSAGE(rows << " links, " << films << " with the film, " << from_edges << " from open edges");
    BOOST_TEST(films > 1000U);
    BOOST_TEST(from_edges > 10U);
}

BOOST_AUTO_TEST_SUITE_END()
