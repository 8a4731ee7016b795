#pragma once

#include "support/exact_field.hpp"

#include <clsdf/grid.hpp>
#include <clsdf/mesh.hpp>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

/// Regions of transforms that are restricted.
namespace clsdf::test {

inline void check_same(const Field& whole, const Field& part) {
    for (const OutputInfo& info : output_table())
        BOOST_TEST(same_bytes(whole.slab(), part.slab(), info.output), info.name << " differs");
}

/// Awkward ones: within the mesh, at its end, thin, around all of it, beside it and far from it.
inline std::vector<Box> boxes_about(const Mesh& mesh) {
    const Box all = mesh.box();
    const auto at = [&](const Vec3& lower, const Vec3& upper) {
        Box box;
        for (std::size_t axis = 0; axis < 3; ++axis) {
            const double side = all.upper[axis] - all.lower[axis];
            box.lower[axis] = all.lower[axis] + lower[axis] * side;
            box.upper[axis] = all.lower[axis] + upper[axis] * side;
        }
        return box;
    };
    return {at({0.4, 0.3, 0.2}, {0.6, 0.7, 0.5}),     at({0.7, -0.2, -0.2}, {1.3, 0.4, 0.4}),
            at({-0.3, 0.1, 0.55}, {1.3, 0.9, 0.551}), at({-0.1, -0.1, -0.1}, {1.1, 1.1, 1.1}),
            at({1.2, 0.2, 0.2}, {1.5, 0.8, 0.8}),     at({-0.6, 0.2, 0.2}, {-0.2, 0.8, 0.8}),
            at({40, 40.5, 41}, {40.2, 40.7, 41.2}),   at({0.2, 0.2, 0.95}, {0.8, 0.8, 1.05})};
}

/// The block of a lattice that has all samples in a box.
inline Grid samples_in(const Box& box, double h, const Vec3& origin) {
    Grid grid = grid_at(origin, h, 1);
    grid.origin = origin;
    for (std::size_t axis = 0; axis < 3; ++axis) {
        grid.first[axis] = static_cast<std::int64_t>(std::ceil((box.lower[axis] - origin[axis]) / h));
        const auto last = static_cast<std::int64_t>(std::floor((box.upper[axis] - origin[axis]) / h));
        grid.size[axis] = std::max<std::int64_t>(1, last - grid.first[axis] + 1);
    }
    return grid;
}

/// Whether its samples lie in the box: a thin one may have none.
inline bool is_inside(const Grid& grid, const Box& box) {
    const Vec3 first = grid.position(0, 0, 0),
               last = grid.position(grid.size[0] - 1, grid.size[1] - 1, grid.size[2] - 1);
    for (std::size_t axis = 0; axis < 3; ++axis)
        if (first[axis] < box.lower[axis] || last[axis] > box.upper[axis]) return false;
    return true;
}

}  // namespace clsdf::test
