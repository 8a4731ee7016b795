#pragma once

#include <clsdf/mesh.hpp>

#include "mesh/box_index.hpp"

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <utility>
#include <vector>

namespace clsdf {

/// Triangles of one group, from this one up to the next run.
struct GroupRun {
    std::size_t first_triangle;
    std::string name;
};

/// The arrays of a mesh in the making.
struct MeshArrays {
    std::vector<Vec3> vertices;
    std::vector<Triangle> triangles;
    std::vector<GroupRun> runs{};  ///< in the order of the triangles; empty without groups

    /// Adds a polygon as a fan around its first corner.
    void add_polygon(std::span<const std::uint32_t> corners) {
        for (std::size_t k = 2; k < corners.size(); ++k) triangles.push_back({corners[0], corners[k - 1], corners[k]});
    }
};

inline bool is_finite(const Vec3& point) {
    return std::isfinite(point[0]) && std::isfinite(point[1]) && std::isfinite(point[2]);
}

/// The box of positions, and whether all of them are finite: without branches.
struct Extent {
    Box box = empty_box;
    double zero = 0;  ///< NaN after a coordinate that is not finite

    void add(const Vec3& position) {
        clsdf::add(box, {position, position});
        zero += (position[0] - position[0]) + (position[1] - position[1]) + (position[2] - position[2]);
    }
    void add(const Extent& other) {
        clsdf::add(box, other.box);
        zero += other.zero;
    }
    bool is_finite() const { return zero == 0; }
};

/// Which of the zeros of both signs a box has depends on the order of vertices.
inline Box without_negative_zeros(Box box) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
        box.lower[axis] += 0.0;
        box.upper[axis] += 0.0;
    }
    return box;
}

}  // namespace clsdf
