#include "cutting/closed_gaps.hpp"

#include "core/parallel.hpp"
#include "core/vectors.hpp"
#include "mesh/predicates.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <iterator>
#include <limits>
#include <map>
#include <utility>

namespace clsdf::cutting {

namespace {

constexpr std::uint32_t none = std::numeric_limits<std::uint32_t>::max();

Triangle sorted(Triangle face) {
    std::ranges::sort(face);
    return face;
}

/// Faces that may have a gap between them: the corners of `moved` are all near the plane of `fixed`, or stay apart.
/// With two common vertices they may be halves of one quadrilateral that is divided along both diagonals.
struct Gap {
    std::uint32_t moved, fixed;
    bool is_narrow, has_common_edge;
};

class Gaps {
public:
    Gaps(std::vector<Vec3>& vertices, std::vector<Triangle>& triangles, const SignSurface& surface, bool are_inside_out)
        : vertices_(vertices), triangles_(triangles), surface_(surface), way_(are_inside_out ? -1 : 1) {}

    /// Adds the gap between two faces that look at each other, one above the other, if there is one.
    void find(std::uint32_t first, std::uint32_t second, std::vector<Gap>& gaps) const {
        const auto common = std::ranges::count_if(triangles_[first], [&](std::uint32_t v) {
            return std::ranges::find(triangles_[second], v) != triangles_[second].end();
        });
        if (common == 3) return;
        if (surface_.count(first) == 0 || surface_.count(second) == 0) return;
        const Vec3 normal = outward(first), of_other = outward(second);
        if (dot(normal, of_other) > -0.999 * length(normal) * length(of_other)) return;
        for (const auto& [moved, fixed] : {std::pair(second, first), {first, second}}) {
            const double farthest = distance(moved, fixed);
            if (farthest > (common > 0 ? gap_width : gap_margin) || !are_in_front(moved, fixed) ||
                !overlap(first, second))
                continue;
            gaps.push_back({moved, fixed, farthest <= gap_width, common == 2});
            return;
        }
    }

    /// Divides the quadrilateral of a face along the diagonal of the one that lies on it. face_of: by sorted vertices.
    /// Returns whether it did.
    bool divide_alike(const Gap& gap, const std::map<Triangle, std::uint32_t>& face_of) {
        const Triangle given = triangles_[gap.fixed], own = triangles_[gap.moved];
        std::uint32_t theirs = none, ours = none;  // vertices of one alone
        for (std::size_t k = 0; k < 3; ++k) {
            if (std::ranges::find(own, given[k]) == own.end()) theirs = given[k];
            if (std::ranges::find(given, own[k]) == given.end()) ours = own[k];
        }
        if (theirs == none || ours == none) return false;  // they are alike already
        std::vector<std::uint32_t> others;                 // the other halves: one has the diagonal of each
        for (const std::uint32_t common : given) {
            if (common == theirs) continue;
            const Triangle half = sorted({common, theirs, ours});
            const auto found = face_of.find(half);
            if (found != face_of.end() && sorted(triangles_[found->second]) == half) others.push_back(found->second);
        }
        if (others.size() != 2) return false;
        // The half of `given` runs along their diagonal in the other direction.
        const auto runs = [](const Triangle& face, std::uint32_t from, std::uint32_t to) {
            for (std::size_t k = 0; k < 3; ++k)
                if (face[k] == from && face[(k + 1) % 3] == to) return true;
            return false;
        };
        const auto is_other_half = [&](std::uint32_t half, const Triangle& face) {
            for (std::size_t k = 0; k < 3; ++k)
                if (runs(triangles_[half], face[(k + 1) % 3], face[k])) return true;
            return false;
        };
        for (const auto& [of_given, of_own] : {std::pair(others[0], others[1]), {others[1], others[0]}}) {
            if (!is_other_half(of_given, given) || !is_other_half(of_own, own) ||
                surface_.count(of_given) != surface_.count(gap.fixed) ||
                surface_.count(of_own) != surface_.count(gap.moved) ||
                surface_.count(gap.fixed) != surface_.count(gap.moved))
                continue;
            triangles_[gap.moved] = {given[0], given[2], given[1]};
            const Triangle half = triangles_[of_given];
            triangles_[of_own] = {half[0], half[2], half[1]};
            return true;
        }
        return false;
    }

    /// Moves the corners that are in front. Returns whether all of them could be moved.
    bool close(const Gap& gap, std::vector<Vec3>& first_moves, std::vector<bool>& is_moved) {
        const Vec3 normal = outward(gap.fixed);
        const double size = length(normal);
        bool are_closed = true;
        for (const std::uint32_t v : triangles_[gap.moved]) {
            if (!is_in_front(gap.fixed, vertices_[v])) continue;
            if (is_moved[v] && dot(first_moves[v], normal) < 0) {
                are_closed = false;
                continue;
            }
            const Vec3 from = vertices_[v];
            for (int step = 1; step <= 32; ++step) {
                for (std::size_t axis = 0; axis < 3; ++axis)
                    vertices_[v][axis] = from[axis] - step * (gap_width / 8) / size * normal[axis];
                if (!is_in_front(gap.fixed, vertices_[v])) break;
            }
            if (is_in_front(gap.fixed, vertices_[v])) {
                vertices_[v] = from;
                are_closed = false;
                continue;
            }
            if (!is_moved[v]) first_moves[v] = normal;
            is_moved[v] = true;
        }
        return are_closed;
    }

private:
    int direction(std::uint32_t face) const { return way_ * surface_.count(face); }
    const Vec3& corner(std::uint32_t face, std::size_t k) const { return vertices_[triangles_[face][k]]; }
    Vec3 outward(std::uint32_t face) const {
        Vec3 normal = cross(difference(corner(face, 1), corner(face, 0)), difference(corner(face, 2), corner(face, 0)));
        for (double& x : normal) x *= direction(face);
        return normal;
    }
    bool is_in_front(std::uint32_t face, const Vec3& point) const {
        return direction(face) * orientation(corner(face, 0), corner(face, 1), corner(face, 2), point) > 0;
    }
    bool are_in_front(std::uint32_t moved, std::uint32_t fixed) const {
        return std::ranges::any_of(triangles_[moved],
                                   [&](std::uint32_t v) { return is_in_front(fixed, vertices_[v]); });
    }
    /// Of the corner that is farthest from the other face's plane.
    double distance(std::uint32_t moved, std::uint32_t fixed) const {
        const Vec3 normal = outward(fixed);
        double farthest = 0;
        for (const std::uint32_t v : triangles_[moved])
            farthest = std::max(farthest, std::abs(dot(difference(vertices_[v], corner(fixed, 0)), normal)));
        return farthest / length(normal);
    }
    /// Whether two faces overlap as seen along an axis.
    bool overlap(std::uint32_t first, std::uint32_t second) const {
        const Vec3 normal = outward(first);
        std::size_t axis = 0;
        for (std::size_t k = 1; k < 3; ++k)
            if (std::abs(normal[k]) > std::abs(normal[axis])) axis = k;
        const auto seen = [&](std::uint32_t face, std::size_t k) {
            const Vec3& at = corner(face, k % 3);
            return std::array{at[(axis + 1) % 3], at[(axis + 2) % 3]};
        };
        // An edge of one has all of the other one on its outer side.
        for (const auto& [one, other] : {std::pair(first, second), {second, first}}) {
            const int turn = orientation(seen(one, 0), seen(one, 1), seen(one, 2));
            for (std::size_t k = 0; k < 3; ++k) {
                bool is_outside = true;
                for (std::size_t n = 0; n < 3; ++n)
                    is_outside = is_outside && turn * orientation(seen(one, k), seen(one, k + 1), seen(other, n)) <= 0;
                if (is_outside) return false;
            }
        }
        return true;
    }

    std::vector<Vec3>& vertices_;
    std::vector<Triangle>& triangles_;
    const SignSurface& surface_;
    int way_;
};

}  // namespace

ClosedGaps close_gaps(std::vector<Vec3>& vertices, std::vector<Triangle>& triangles, const FaceBoxes& boxes,
                      const SignSurface& surface, bool are_inside_out, const Cancellation& cancellation) {
    Gaps all(vertices, triangles, surface, are_inside_out);
    std::vector<std::vector<Gap>> by_group(boxes.pair_groups());
    for_each_index(
        by_group.size(),
        [&](std::size_t group) {
            cancellation.check();
            boxes.for_each_pair(group, [&](std::uint32_t a, std::uint32_t b) { all.find(a, b, by_group[group]); });
        },
        16);
    std::vector<Gap> gaps;
    for (std::vector<Gap>& group : by_group) std::ranges::move(group, std::back_inserter(gaps));
    std::ranges::sort(gaps, {}, [](const Gap& gap) { return std::pair(gap.moved, gap.fixed); });
    ClosedGaps result;
    if (gaps.empty()) return result;
    if (std::ranges::any_of(gaps, &Gap::has_common_edge)) {
        std::map<Triangle, std::uint32_t> face_of;
        for (const Gap& gap : gaps)
            for (const std::uint32_t face : {gap.moved, gap.fixed}) face_of.emplace(sorted(triangles[face]), face);
        for (const Gap& gap : gaps)
            if (gap.has_common_edge && all.divide_alike(gap, face_of)) result.is_changed = true;
        if (result.is_changed) {
            std::vector<Gap> left;
            for (const Gap& gap : gaps) all.find(std::min(gap.moved, gap.fixed), std::max(gap.moved, gap.fixed), left);
            gaps = std::move(left);
        }
    }
    std::vector<Vec3> first_moves(vertices.size());
    result.is_moved.resize(vertices.size());
    // A corner that is moved for one face may come before another one's plane by rounding.
    constexpr int passes = 3;
    for (int pass = 0; pass < passes; ++pass) {
        result.left = 0;
        for (const Gap& gap : gaps)
            if (!gap.is_narrow || !all.close(gap, first_moves, result.is_moved)) ++result.left;
    }
    if (std::ranges::count(result.is_moved, true) == 0) result.is_moved.clear();
    return result;
}

}  // namespace clsdf::cutting
