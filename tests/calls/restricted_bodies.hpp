#pragma once

#include "calls/regions.hpp"
#include "support/doubtful_meshes.hpp"
#include "support/hostile_meshes.hpp"
#include "support/open_meshes.hpp"
#include "support/random_meshes.hpp"

#include <clsdf/distance_transform.hpp>
#include <clsdf/sparse.hpp>

#include <algorithm>
#include <cstdint>
#include <utility>
#include <vector>

/// Bodies that transforms are restricted of, and the comparison of two restricted transforms.
namespace clsdf::test {

struct Body {
    Mesh mesh;
    TransformOptions options{};
};

/// Meshes for all sign rules, some with another surface than the mesh for the sign.
inline std::vector<Body> bodies() {
    Random random(23);
    std::vector<Body> bodies;
    bodies.push_back({tilted(make_shape("knot"))});
    bodies.push_back({tilted(make_shape("noisy")), {.sign = SignRule::none}});
    bodies.push_back({together({cube(1), shifted(cube(1), {0.5, 0.6, 0.7})}, "two"), {.sign = SignRule::parity}});
    bodies.push_back({without_triangle(make_shape("sphere4"), 7)});
    bodies.push_back({seamed_torus()});
    bodies.push_back({boxes_with_membrane()});
    bodies.push_back({random_slivers(random, 300)});
    std::vector<Mesh> cubes;  // neighbours share an edge of four faces
    for (int i = 0; i < 6; ++i) cubes.push_back(shifted(cube(0.5), {i + 0.5, i + 0.5, 0.5}));
    bodies.push_back({weld(together(cubes, "cubes"))});
    std::vector<Vec3> heights;
    std::vector<Triangle> triangles;
    for (std::uint32_t y = 0; y < 9; ++y)
        for (std::uint32_t x = 0; x < 9; ++x) {
            heights.push_back({x / 8.0, y / 8.0, 0.1 * random.uniform(0, 1)});
            if (x == 8 || y == 8) continue;
            const std::uint32_t at = 9 * y + x;
            triangles.push_back({at, at + 1, at + 10});
            triangles.push_back({at, at + 10, at + 9});
        }
    bodies.push_back({Mesh(heights, triangles, "terrain"), {.sign = SignRule::below, .floor = -0.5}});
    return bodies;
}

/// Fields, sparse fields and points in a region.
inline void check_same_answers(const DistanceTransform& expected, const DistanceTransform& found, const Region& region,
                               const Vec3& origin, OutputSet outputs = all_outputs()) {
    const Band band{0.6 * region.half_width, region.half_width};
    const Grid grid = samples_in(region.box, region.spacing, origin);
    if (is_inside(grid, region.box)) {
        check_same(expected.compute(grid, band, outputs), found.compute(grid, band, outputs));
        const SparseField one = expected.compute_sparse(grid, band), other = found.compute_sparse(grid, band);
        BOOST_TEST((one.bricks == other.bricks));
        BOOST_TEST((bits_of(one.distance()) == bits_of(other.distance())));
    }
    Random random(3);
    std::vector<Vec3> points(400);
    for (Vec3& point : points)
        for (std::size_t axis = 0; axis < 3; ++axis)
            point[axis] = std::clamp(random.uniform(region.box.lower[axis], region.box.upper[axis]),
                                     region.box.lower[axis], region.box.upper[axis]);
    check_same(query(expected, points, region.half_width, outputs), query(found, points, region.half_width, outputs));
}

}  // namespace clsdf::test
