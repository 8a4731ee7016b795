#include "mesh/face_crossings.hpp"

#include "mesh/predicates.hpp"

#include <algorithm>
#include <array>
#include <cstddef>

namespace clsdf {

namespace {

using Corners = std::array<Vec3, 3>;
using Signs = std::array<int, 3>;

/// Of a point in a face: -1: outside, 0: on the boundary, 1: inside. signs: on which side of each edge it lies.
int place_within(const Signs& signs) {
    const auto [least, most] = std::ranges::minmax(signs);
    return least < 0 && most > 0 ? -1 : least == 0 || most == 0 ? 0 : 1;
}

/// Two faces of one plane, seen along an axis along which they have an area.
bool overlap_in_plane(const Corners& first, const Corners& second) {
    const auto seen = [](const Vec3& point, std::size_t axis) {
        return std::array{point[(axis + 1) % 3], point[(axis + 2) % 3]};
    };
    std::size_t axis = 0;
    while (axis < 2 && orientation(seen(first[0], axis), seen(first[1], axis), seen(first[2], axis)) == 0) ++axis;
    // Insides that have no point in common lie on two sides of an edge.
    const auto is_divided_by_edge = [&](const Corners& face, const Corners& other) {
        const int turn = orientation(seen(face[0], axis), seen(face[1], axis), seen(face[2], axis));
        for (std::size_t i = 0; i < 3; ++i)
            if (std::ranges::all_of(other, [&](const Vec3& corner) {
                    return turn * orientation(seen(face[i], axis), seen(face[(i + 1) % 3], axis), seen(corner, axis)) <=
                           0;
                }))
                return true;
        return false;
    };
    return !is_divided_by_edge(first, second) && !is_divided_by_edge(second, first);
}

/// The ends of the line that a face has in common with another one's plane. sides: of the face's corners, seen from
/// that plane; the face has corners on both sides.
struct Ends {
    bool are_inside = false;  ///< one of them lies inside the other face
    std::size_t on_edge = 0;  ///< how many lie on its boundary
};
Ends ends_of(const Corners& face, const Signs& sides, const Corners& other) {
    Ends ends;
    for (std::size_t i = 0; i < 3; ++i) {
        const std::size_t next = (i + 1) % 3;
        // At a corner on the plane any line through it will do.
        if (sides[i] != 0 && sides[i] * sides[next] >= 0) continue;
        Signs signs{};
        for (std::size_t k = 0; k < 3; ++k) signs[k] = orientation(face[i], face[next], other[k], other[(k + 1) % 3]);
        const int place = place_within(signs);
        ends.are_inside = ends.are_inside || place > 0;
        ends.on_edge += place == 0 ? 1U : 0U;
    }
    return ends;
}

}  // namespace

bool faces_cross(std::span<const Vec3> vertices, const Triangle& first, const Triangle& second) {
    const std::array<const Triangle*, 2> faces{&first, &second};
    std::array<Corners, 2> corners{};
    std::array<Signs, 2> sides{};
    for (std::size_t n = 0; n < 2; ++n)
        for (std::size_t i = 0; i < 3; ++i) corners[n][i] = vertices[(*faces[n])[i]];
    std::array<bool, 2> are_flat{}, are_divided{};
    for (std::size_t n = 0; n < 2; ++n) {
        const Corners& other = corners[1 - n];
        for (std::size_t i = 0; i < 3; ++i) {
            const bool is_shared = std::ranges::find(*faces[1 - n], (*faces[n])[i]) != faces[1 - n]->end();
            sides[n][i] = is_shared ? 0 : orientation(other[0], other[1], other[2], corners[n][i]);
        }
        const auto [least, most] = std::ranges::minmax(sides[n]);
        are_flat[n] = least == 0 && most == 0;
        are_divided[n] = least < 0 && most > 0;
    }
    if (are_flat[0]) return overlap_in_plane(corners[0], corners[1]);
    if (!are_divided[0] || !are_divided[1]) return false;
    const Ends ends = ends_of(corners[0], sides[0], corners[1]);
    // Two ends on the boundary: both faces have the same line. One: they touch, or the other face's line ends inside.
    return ends.are_inside || ends.on_edge > 1 || ends_of(corners[1], sides[1], corners[0]).are_inside;
}

}  // namespace clsdf
