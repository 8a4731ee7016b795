#include "support/float_width.hpp"
#include "support/random_meshes.hpp"

#include <array>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

// Polyhedra of few samples a row, which processors scan row by row: triangles with edges of their own, strips with
// common ones, and every eighth triangle in a plane of samples.

using namespace clsdf;
using namespace clsdf::test;

namespace {

/// A coarse brick of the lattice, and triangles in and around it. Lengths are in units of the mesh.
struct Case {
    Index3 coarse;
    Vec3 spacing;
    double half_width;
    double size;  ///< of the triangles
    std::size_t count = 120;
};

constexpr std::int64_t coarse_size = 32;

Mesh random_triangles(Random& random, const Grid& grid, const Case& c) {
    std::vector<Vec3> vertices;
    std::vector<Triangle> triangles;
    while (triangles.size() < c.count) {
        const auto n = static_cast<std::uint32_t>(vertices.size());
        Vec3 centre = grid.position(0, 0, 0);
        for (std::size_t axis = 0; axis < 3; ++axis)
            centre[axis] += c.spacing[axis] * random.uniform(-0.3, 1.3) * coarse_size;
        const bool is_flat = triangles.size() % 8 == 0;
        const std::uint32_t corners = 3 + random.index(4);
        for (std::uint32_t k = 0; k < corners; ++k) {
            Vec3 corner = along(centre, c.size * random.uniform(0.3, 1), random.direction());
            if (is_flat) corner[2] = grid.position(0, 0, random.index(coarse_size))[2];
            vertices.push_back(corner);
            if (k >= 2) triangles.push_back({n + k - 2, n + k - 1, n + k});
        }
    }
    return {std::move(vertices), std::move(triangles), "triangles of " + std::to_string(c.size)};
}

}  // namespace

BOOST_AUTO_TEST_CASE(triangles_of_any_size_are_exact_by_vectors_of_either_width) {
    const std::vector<Case> cases{
        {{0, 0, 0}, {1, 1, 1}, 1.5, 25},        {{-3, 2, 7}, {1, 1, 1}, 0.4, 25},
        {{5, -1, 0}, {1.3, 1.3, 1.3}, 2, 4},    {{1, 1, 1}, {1.4, 1, 1.2}, 2, 20},
        {{0, -2, 0}, {1, 1, 1}, 3, 12},         {{4000, 9, -70000}, {1, 1, 1}, 1, 30},
        {{2, 0, -1}, {1, 1, 1}, 1.5, 1.5},      {{2, 0, -1}, {1, 1.1, 1}, 3, 1},
        {{0, 0, 0}, {1, 1, 1}, 1, 60},          {{0, 1, 0}, {1, 1, 1}, 2, 5, 6},
        {{0, 1, 0}, {1, 1, 1}, 1.5, 0.2, 4000},
    };
    constexpr std::uint64_t seed = 20261121;
    const std::array devices{with_float_width(8), with_float_width(16)};
    for (const Case& c : cases) {
        Grid grid;
        grid.spacing = c.spacing;
        grid.size = {coarse_size, coarse_size, coarse_size};
        for (std::size_t axis = 0; axis < 3; ++axis) grid.first[axis] = c.coarse[axis] * coarse_size;
        Random random(seed);
        const Mesh mesh = random_triangles(random, grid, c);
        for (const Device& device : devices) {
            const DistanceTransform transform(device, mesh, {.body = KernelBody::by_vector});
            for (const OutputSet outputs : {OutputSet(Output::distance), OutputSet(Output::triangle)})
                BOOST_TEST_CONTEXT("half width " << c.half_width << ", seed " << seed) {
                    const Field field = transform.compute(grid, Band::symmetric(c.half_width), outputs);
                    BOOST_TEST(check_exact(mesh, field, guaranteed).band_samples > 0U);
                }
        }
    }
}
