#pragma once

#include "tree/one_lane.hpp"
#include "tree/wide_tree.hpp"

#include <clsdf/mesh.hpp>

#include <bit>
#include <cstdint>

/// The walk of a ray, or of a segment, down the wide tree.
namespace clsdf::engine {

/// A ray as boxes are compared with it. Places on it are multiples of its slope, in units.
struct TreeRay {
    one_lane::BoxRay boxes{};
    double begin = 0;        ///< the place where it comes near the mesh's box
    bool is_beside = false;  ///< it misses the box

    /// The bound for a place `end` on the ray, in the walk.
    float end_at(double end) const;
};

/// from: in the caller's coordinates. slope: within 2^-50 of the true one on each axis; the greatest is 1/2 to 1.
TreeRay tree_ray(const PointMesh& mesh, const Vec3& from, const Vec3& slope);

/// See kernels/tree/ray_boxes.h.
std::uint32_t children_on_ray(const PointNode& node, const one_lane::BoxRay& ray, float end, float* distances);

/// Calls visit(face) for all faces whose boxes the ray may meet before `end`, until it returns true. Returns whether it
/// did. Nearer boxes come first, so that visits may reduce `end`, which is read again: a bound by TreeRay::end_at().
template <typename Visit>
bool visit_faces(const WideTree& tree, const TreeRay& ray, const float& end, const Visit& visit) {
    if (ray.is_beside) return false;
    float distances[CLSDF_TREE_LEVELS + 1][CLSDF_TREE_WIDTH];
    return traverse(
        tree,
        [&](const PointNode& node, std::uint32_t level) {
            return children_on_ray(node, ray.boxes, end, distances[level]);
        },
        [&](std::uint32_t bits, std::uint32_t level) {
            const float* const of_level = distances[level];
            auto nearest = static_cast<std::uint32_t>(std::countr_zero(bits));
            for (std::uint32_t left = bits & (bits - 1); left != 0; left &= left - 1) {
                const auto child = static_cast<std::uint32_t>(std::countr_zero(left));
                if (of_level[child] < of_level[nearest]) nearest = child;
            }
            return of_level[nearest] <= end ? nearest : CLSDF_NO_CHILD;
        },
        visit);
}

}  // namespace clsdf::engine
