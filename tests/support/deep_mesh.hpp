#pragma once

#include <clsdf/mesh.hpp>

#include "support/random_meshes.hpp"

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

namespace clsdf::test {

/// Faces each of which is half as far from a corner as the one before, and many in the corner's cell. With 4096 of
/// these, the tree of GPUs is deeper than its small stack.
inline Mesh deep_mesh(std::size_t in_cell) {
    std::vector<Vec3> vertices;
    std::vector<Triangle> triangles;
    const auto add = [&](const Vec3& p, double size) {
        const auto first = static_cast<std::uint32_t>(vertices.size());
        vertices.insert(vertices.end(), {p, {p[0] + size, p[1], p[2]}, {p[0], p[1] + size, p[2] + size / 2}});
        triangles.push_back({first, first + 1, first + 2});
    };
    for (int level = 0; level < 8; ++level)
        for (std::size_t axis = 0; axis < 3; ++axis) {
            Vec3 p{};
            p[axis] = std::ldexp(0.75, -level);
            add(p, std::ldexp(1e-3, -level));
        }
    Random random(3);
    for (std::size_t i = 0; i < in_cell; ++i) add(random.point(0, 1e-3), 1e-4);
    return {std::move(vertices), std::move(triangles), "deep"};
}

}  // namespace clsdf::test
