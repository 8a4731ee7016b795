#pragma once

#include <clsdf/mesh.hpp>

#include <cstdint>
#include <span>
#include <utility>
#include <vector>

namespace clsdf {

/// The arrays of a mesh in the making.
struct MeshArrays {
    std::vector<Vec3> vertices;
    std::vector<Triangle> triangles;

    /// Adds a polygon as a fan around its first corner.
    void add_polygon(std::span<const std::uint32_t> corners) {
        for (std::size_t k = 2; k < corners.size(); ++k) triangles.push_back({corners[0], corners[k - 1], corners[k]});
    }
};

}  // namespace clsdf
