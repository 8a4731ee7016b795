#include "plan/near_parts.hpp"

#include "mesh/box_index.hpp"

#include <algorithm>
#include <cmath>

namespace clsdf::engine {

namespace {

/// The box of the samples of the grid's bricks, in the mesh's units.
Box box_of_bricks(const Grid& grid, const Layout& layout) {
    Box box;
    for (std::size_t axis = 0; axis < 3; ++axis) {
        const double first = static_cast<double>(layout.brick_first[axis]) * CLSDF_BRICK;
        const double last = first + static_cast<double>(layout.bricks[axis]) * CLSDF_BRICK - 1;
        box.lower[axis] = grid.origin[axis] + first * grid.spacing[axis];
        box.upper[axis] = grid.origin[axis] + last * grid.spacing[axis];
    }
    return box;
}

/// Triangles farther than this from a brick, in the mesh's units, decide none of its samples: they are farther than the
/// half width from each, by more than the rounding of distances and of the tests in kernels/lists/coarse_clusters.h.
double greatest_distance_of(const Layout& layout) {
    const auto half_width = static_cast<double>(layout.half_width);
    const double units = half_width * (1 + static_cast<double>(layout.slack_rate)) +
                         static_cast<double>(layout.coarse_slack) + static_cast<double>(layout.brick_slack);
    return units * (1 + 1e-4) * static_cast<double>(layout.unit);
}

}  // namespace

std::optional<Box> box_near_bricks(const Job& job) {
    const Layout& layout = job.layout;
    const bool is_bounded = std::isfinite(layout.outside_squared) && std::isfinite(layout.inside_squared);
    if (!is_bounded) return std::nullopt;
    // Near the bricks alone: triangles near the rest of their coarse bricks decide none of the samples.
    return widened(box_of_bricks(job.grid, layout), greatest_distance_of(layout));
}

Box box_near_rows(const Job& job) {
    Box box = box_of_bricks(job.grid, job.layout);
    box.lower[0] = -infinite_length;  // rows run along x
    return widened(box, job.grid.voxel());
}

double share_of(const Box& mesh, const Box& box) {
    double share = 1;
    for (std::size_t axis = 0; axis < 3; ++axis) {
        const double length = mesh.upper[axis] - mesh.lower[axis];
        const double common = std::min(mesh.upper[axis], box.upper[axis]) - std::max(mesh.lower[axis], box.lower[axis]);
        if (length > 0) share *= std::clamp(common / length, 0.0, 1.0);
    }
    return share;
}

}  // namespace clsdf::engine
