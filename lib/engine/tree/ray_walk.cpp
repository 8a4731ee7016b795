#include "tree/ray_walk.hpp"

#include "core/parallel.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace clsdf::engine {

namespace {

// Greater than the roundings of the places where a ray enters and leaves a slab, relative to them.
constexpr double rounding = 0x1p-48;

}  // namespace

float TreeRay::end_at(double end) const {
    const double distance = (end - begin) + rounding * (end + begin);
    return distance < static_cast<double>(std::numeric_limits<float>::max())
               ? std::nextafter(static_cast<float>(distance), std::numeric_limits<float>::infinity())
               : std::numeric_limits<float>::infinity();
}

TreeRay tree_ray(const PointMesh& mesh, const Vec3& from, const Vec3& slope) {
    TreeRay ray;
    const Vec3 begin = mesh.in_units(from), upper = mesh.in_units(mesh.box.upper);
    double leaves = std::numeric_limits<double>::infinity();
    for (std::size_t axis = 0; axis < 3; ++axis) {
        // More around the box than the rounding of both.
        const double around = 1 + rounding * std::abs(begin[axis]);
        const double below = -around - begin[axis], above = upper[axis] + around - begin[axis];
        if (slope[axis] == 0) {
            ray.is_beside = ray.is_beside || below > 0 || above < 0;
            continue;
        }
        const auto [first, last] = std::minmax({below / slope[axis], above / slope[axis]});
        ray.begin = std::max(ray.begin, first);
        leaves = std::min(leaves, last);
    }
    ray.is_beside = ray.is_beside || ray.begin * (1 - rounding) > leaves * (1 + rounding) || leaves < 0;
    if (ray.is_beside) return ray;
    Vec3 near, margin;
    for (std::size_t axis = 0; axis < 3; ++axis) {
        near[axis] = begin[axis] + ray.begin * slope[axis];
        margin[axis] = rounding * (std::abs(begin[axis]) + ray.begin);
    }
    ray.boxes = one_lane::box_ray(near.data(), slope.data(), margin.data());
    return ray;
}

namespace {

CLSDF_SEVERAL_TARGETS std::uint32_t children_by_vectors(const PointNode& node, const one_lane::BoxRay& ray, float end,
                                                        float* distances) {
    return one_lane::children_on_ray(&node, &ray, end, distances);
}

}  // namespace

std::uint32_t children_on_ray(const PointNode& node, const one_lane::BoxRay& ray, float end, float* distances) {
    return children_by_vectors(node, ray, end, distances);
}

}  // namespace clsdf::engine
