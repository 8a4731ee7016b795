#include "cutting/patches.hpp"

#include "core/parallel.hpp"
#include "core/vectors.hpp"
#include "mesh/box_index.hpp"
#include "mesh/disjoint_sets.hpp"
#include "mesh/one_rings.hpp"
#include "mesh/predicates.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <utility>

namespace clsdf::cutting {

namespace {

double twice_area(const CutPoints& points, const Triangle& corners) {
    const Vec3& a = points.rounded(corners[0]);
    return length(cross(difference(points.rounded(corners[1]), a), difference(points.rounded(corners[2]), a)));
}

/// The lowest piece of each piece's patch.
std::vector<std::uint32_t> patches_of(std::span<const Piece> pieces, std::size_t point_count) {
    std::vector<Triangle> triangles(pieces.size());
    for_each_index(pieces.size(), [&](std::size_t i) { triangles[i] = pieces[i].corners; });
    const OneRings rings(triangles, point_count);
    SharedDisjointSets sets(pieces.size());
    for_each_range(point_count, [&](std::size_t begin, std::size_t end) {
        std::vector<EdgeEntry> entries;
        for (std::size_t v = begin; v != end; ++v) {
            const auto lower = static_cast<std::uint32_t>(v);
            const auto is_forward = [&](const Corner& edge) { return triangles[edge.face][edge.vertex] == lower; };
            edges_above(triangles, rings, lower, entries);
            for_each_edge(entries, [&](std::span<const EdgeEntry> edges) {
                if (edges.size() != 2) return;
                const Corner one = edges[0].edge(), other = edges[1].edge();
                if (is_forward(one) != is_forward(other)) sets.join(one.face, other.face);
            });
        }
    });
    std::vector<std::uint32_t> patches(pieces.size());
    for_each_index(pieces.size(), [&](std::size_t i) { patches[i] = sets.root(static_cast<std::uint32_t>(i)); });
    return patches;
}

/// The winding numbers beside a point of a face, above it along an axis and below, and the face of the lowest patch in
/// which it lies.
struct Windings {
    int above = 0, below = 0;
    std::uint32_t lowest = 0;
};

/// Nothing if the ray upwards meets an edge.
std::optional<Windings> windings_at(CutPoints::Inner& point, std::uint32_t own, const View& view,
                                    const CutPoints& points, const FaceBoxes& boxes, const PlanePatches& planes,
                                    const SignSurface& surface) {
    Windings found{0, 0, own};
    const auto rank = [&](std::uint32_t face) { return std::pair(planes.lowest(face), face); };
    const std::size_t axis = view.axis;
    const auto corner = [&](std::uint32_t face, std::size_t i) { return points.vertex(points.triangles()[face][i]); };
    // Whether the face lies in the plane of its own.
    const auto is_in_plane = [&](std::uint32_t face) {
        for (std::size_t i = 0; i < 3 && face != own; ++i)
            if (orientation(corner(own, 0), corner(own, 1), corner(own, 2), corner(face, i)) != 0) return false;
        return true;
    };
    Box above = point.box();
    above.upper[axis] = infinite_length;
    const bool is_hit = boxes.any(above, [&](std::uint32_t face) {
        const Triangle& corners = points.triangles()[face];
        int direction = view.direction;
        if (face != own) {
            bool is_left = false, is_right = false, is_on_edge = false;
            for (std::size_t i = 0; i < 3 && !(is_left && is_right); ++i) {
                const int side = point.orientation(corners[i], corners[(i + 1) % 3], axis);
                is_left = is_left || side > 0;
                is_right = is_right || side < 0;
                is_on_edge = is_on_edge || side == 0;
            }
            if (is_left && is_right) return false;
            if (is_on_edge) return true;
            direction = is_left ? 1 : -1;
        }
        const int side = is_in_plane(face) ? 0 : point.side(corners);  // with the direction's sign: above the face
        const int count = direction * surface.count(face);
        if (side == 0) {
            found.below += count;
            if (rank(face) < rank(found.lowest)) found.lowest = face;
        } else if (side * direction < 0) {
            found.above += count;
        }
        return false;
    });
    if (is_hit) return std::nullopt;
    found.below += found.above;
    return found;
}

}  // namespace

std::vector<Fate> fates_of(const CutPoints& points, std::span<const View> views, const FaceBoxes& boxes,
                           std::span<const Piece> pieces, const PlanePatches& planes, const SignSurface& surface,
                           SignRule rule, const Cancellation& cancellation) {
    const std::vector<std::uint32_t> patches = patches_of(pieces, points.size());
    std::vector<double> areas(pieces.size());
    for_each_index(pieces.size(), [&](std::size_t i) { areas[i] = twice_area(points, pieces[i].corners); });
    std::vector<std::uint32_t> largest(pieces.size());  // by the lowest piece of a patch
    for (std::uint32_t i = 0; i < pieces.size(); ++i) largest[i] = i;
    for (std::uint32_t i = 0; i < pieces.size(); ++i)
        if (areas[i] > areas[largest[patches[i]]]) largest[patches[i]] = i;

    std::vector<Fate> fates(pieces.size(), Fate::dropped);
    for_each_index(
        pieces.size(),
        [&](std::size_t patch) {
            if (patches[patch] != patch) return;
            const Piece& piece = pieces[largest[patch]];
            const View& view = views[piece.face];
            std::optional<Windings> windings;
            // Of these points at most two lie on a line, and each edge that a ray may meet is a line: one is free.
            for (double t = 1; !windings; ++t) {
                cancellation.check();
                const Vec3 weights{1, t, t * t};
                CutPoints::Inner point(points, piece.corners, weights);
                windings = windings_at(point, piece.face, view, points, boxes, planes, surface);
            }
            if (windings->lowest != piece.face) return;
            int front = windings->above, back = windings->below;
            if (view.direction < 0) std::swap(front, back);
            const auto is_inside = [&](int winding) {
                return rule == SignRule::parity ? winding % 2 != 0 : winding != 0;
            };
            if (is_inside(front) != is_inside(back)) fates[patch] = is_inside(back) ? Fate::kept : Fate::flipped;
        },
        8);
    for (std::size_t i = 0; i < pieces.size(); ++i) fates[i] = fates[patches[i]];
    return fates;
}

}  // namespace clsdf::cutting
