#pragma once

#include <clsdf/mesh.hpp>

#include "solid_angle.h"
#include "surface/ray_side.hpp"

#include <cstddef>

namespace clsdf {

/// Turns by a loop of open edges, seen from a point as given, with exact sides of edges. corner(i): its position, of so
/// many. unit: a power of two; positions divided by it are of moderate size.
template <typename Corner>
Turns turned_by_loop(Turns turns, std::size_t count, const Corner& corner, const Vec3& point, double unit) {
    const double scale = 1 / unit;
    const auto seen = [&](const Vec3& position) {
        // A product with a power of two is exact, and cannot overflow where the difference of the given ones does.
        const double x = position[0] * scale - point[0] * scale, y = position[1] * scale - point[1] * scale,
                     z = position[2] * scale - point[2] * scale;
        return seen_vertex(x, y, z, y, z);
    };
    const SeenVertex first = seen(corner(0));
    SeenVertex from = first;
    for (std::size_t i = 0; i < count; ++i) {
        const std::size_t next = i + 1 < count ? i + 1 : 0;
        const SeenVertex to = next != 0 ? seen(corner(next)) : first;
        const double re = edge_re(from, to), im = edge_im(from, to);
        const int side = re < 0 ? (displaced_side(corner(i), corner(next), point) > 0 ? 1 : -1) : 0;
        turns = turned(turns, re, im, side);
        from = to;
    }
    return turns;
}

}  // namespace clsdf
