#include "surface/walls.hpp"

#include "surface/ray_side.hpp"

#include <algorithm>
#include <utility>

namespace clsdf {

namespace {

std::vector<std::uint32_t> next_corners(const OpenBoundary& boundary) {
    std::vector<std::uint32_t> next(boundary.corners.size());
    for (std::size_t loop = 0; loop + 1 < boundary.begins.size(); ++loop) {
        const std::size_t begin = boundary.begins[loop], end = boundary.begins[loop + 1];
        for (std::size_t i = begin; i < end; ++i) next[i] = static_cast<std::uint32_t>(i + 1 < end ? i + 1 : begin);
    }
    return next;
}

std::vector<Box> boxes_of_walls(const OpenBoundary& boundary, const std::vector<std::uint32_t>& next) {
    std::vector<Box> boxes(next.size());
    for (std::size_t i = 0; i < boxes.size(); ++i) {
        const Vec3 &a = boundary.corners[i], &b = boundary.corners[next[i]];
        boxes[i] = {{std::min(a[0], b[0]), std::min(a[1], b[1]), *boundary.floor},
                    {std::max(a[0], b[0]), std::max(a[1], b[1]), std::max(a[2], b[2])}};
    }
    return boxes;
}

}  // namespace

Walls::Walls(std::shared_ptr<const OpenBoundary> boundary)
    : boundary_(std::move(boundary)), next_(next_corners(*boundary_)), index_(boxes_of_walls(*boundary_, next_)) {}

int Walls::crossings(const Vec3& point) const {
    Box ray{point, point};
    ray.lower[0] = -infinite_length;
    int winding = 0;
    index_.any(ray, [&](std::size_t corner) {
        const auto [from, to] = edge(corner);
        winding += crossing_of_wall(from, to, floor(), point);
        return false;
    });
    return winding;
}

bool Walls::may_meet(const Box& box) const {
    return index_.any(box, [&](std::size_t corner) {
        // From above the wall is a segment. Its box overlaps the other one: they are apart if its line is.
        const auto [from, to] = edge(corner);
        int least = 1, most = -1;
        for (const double x : {box.lower[0], box.upper[0]})
            for (const double y : {box.lower[1], box.upper[1]}) {
                const int side = side_of_line(from, to, {x, y, 0}, 0, 1);
                least = std::min(least, side);
                most = std::max(most, side);
            }
        return least <= 0 && most >= 0;
    });
}

}  // namespace clsdf
