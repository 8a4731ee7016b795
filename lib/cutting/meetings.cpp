#include "cutting/meetings.hpp"

#include "core/parallel.hpp"
#include "core/vectors.hpp"
#include "mesh/disjoint_sets.hpp"
#include "mesh/predicates.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <iterator>
#include <tuple>
#include <utility>

namespace clsdf::cutting {

namespace {

using Corners = std::array<Vec3, 3>;

std::array<double, 2> seen(const Vec3& point, std::size_t axis) {
    return {point[(axis + 1) % 3], point[(axis + 2) % 3]};
}

/// A face and what cuts it.
using NumberedSegment = std::pair<std::uint32_t, FaceSegment>;
using FacePairs = std::vector<std::array<std::uint32_t, 2>>;

View view_of(const Corners& corners) {
    const Vec3 normal = cross(difference(corners[1], corners[0]), difference(corners[2], corners[0]));
    std::array<std::uint8_t, 3> axes{0, 1, 2};
    std::ranges::sort(axes, {}, [&](std::uint8_t axis) { return std::pair(-std::abs(normal[axis]), axis); });
    for (const std::uint8_t axis : axes)
        if (const int sign = orientation(seen(corners[0], axis), seen(corners[1], axis), seen(corners[2], axis));
            sign != 0)
            return {axis, static_cast<std::int8_t>(sign)};
    return {};
}

/// What cuts a face, without numbers for the ends.
struct RawSegment {
    std::uint32_t face;
    std::array<std::uint32_t, 2> pair;  ///< of faces, the lower first
    Cutter cutter;
    std::vector<CutPoints::Found> ends;
};

/// Two faces.
class Pair {
public:
    /// patches: null: there are none.
    Pair(const CutPoints& points, std::span<const View> views, const PlanePatches* patches, std::uint32_t first,
         std::uint32_t second)
        : points_(points), views_(views), patches_(patches), faces_{first, second} {
        for (std::size_t side = 0; side < 2; ++side) {
            triangles_[side] = points.triangles()[faces_[side]];
            for (std::size_t i = 0; i < 3; ++i) corners_[side][i] = points.vertex(triangles_[side][i]);
        }
    }

    /// Adds the segments of both faces. Returns whether the faces lie in one plane.
    bool add_to(std::vector<RawSegment>& segments) const {
        const auto [ours, theirs, shared] = shared_corners();
        if (shared == 3) return false;
        std::array<std::array<int, 3>, 2> sides{};
        for (std::size_t side = 0; side < 2; ++side) {
            bool is_above = false, is_below = false;
            for (std::size_t i = 0; i < 3; ++i) {
                const bool is_shared = ((side == 0 ? ours : theirs) >> i & 1U) != 0;
                const Corners& other = corners_[1 - side];
                sides[side][i] = is_shared ? 0 : orientation(other[0], other[1], other[2], corners_[side][i]);
                is_above = is_above || sides[side][i] > 0;
                is_below = is_below || sides[side][i] < 0;
            }
            if (!is_above && !is_below) {
                add_coplanar(segments);
                return true;
            }
            const bool is_on_one_side = is_above != is_below;
            const auto on_plane = std::ranges::count(sides[side], 0);
            // A face on one side that touches the other's plane there alone where the two have vertices in common.
            if (is_on_one_side && on_plane == shared) return false;
        }
        std::vector<CutPoints::Found> ends;
        for (std::size_t side = 0; side < 2; ++side) add_ends(side, sides[side], ends);
        if (ends.empty() || (shared == 1 && are_one_vertex(ends))) return false;
        segments.push_back({faces_[0], faces_, Cutter::face(faces_[1]), ends});
        segments.push_back({faces_[1], faces_, Cutter::face(faces_[0]), std::move(ends)});
        return false;
    }

private:
    struct Shared {
        unsigned first = 0, second = 0;  ///< bits
        int count = 0;
    };
    Shared shared_corners() const {
        Shared shared;
        for (unsigned i = 0; i < 3; ++i)
            for (unsigned j = 0; j < 3; ++j)
                if (triangles_[0][i] == triangles_[1][j]) {
                    shared.first |= 1U << i;
                    shared.second |= 1U << j;
                    ++shared.count;
                }
        return shared;
    }

    static bool are_one_vertex(const std::vector<CutPoints::Found>& ends) {
        return std::ranges::all_of(ends, [&](const CutPoints::Found& end) {
            return end.source.kind == Source::vertex && end.source == ends.front().source;
        });
    }

    /// Whether a point of the plane of a face is in the face.
    bool is_within(const Vec3& point, std::size_t face) const {
        const std::size_t axis = views_[faces_[face]].axis;
        bool is_left = false, is_right = false;
        for (std::size_t i = 0; i < 3; ++i) {
            const int sign =
                orientation(seen(corners_[face][i], axis), seen(corners_[face][(i + 1) % 3], axis), seen(point, axis));
            is_left = is_left || sign > 0;
            is_right = is_right || sign < 0;
        }
        return !(is_left && is_right);
    }

    /// The ends of the meeting that lie on the boundary of a face. sides: of its corners, of the other's plane.
    void add_ends(std::size_t side, const std::array<int, 3>& sides, std::vector<CutPoints::Found>& ends) const {
        const std::size_t other = 1 - side;
        for (std::size_t i = 0; i < 3; ++i) {
            const std::size_t next = (i + 1) % 3;
            const Vec3 &a = corners_[side][i], &b = corners_[side][next];
            if (sides[i] == 0 && is_within(a, other))
                ends.push_back(points_.find(Source::of_vertex(triangles_[side][i])));
            if (sides[i] * sides[next] >= 0) continue;
            bool is_left = false, is_right = false;
            for (std::size_t k = 0; k < 3; ++k) {
                const int sign = orientation(a, b, corners_[other][k], corners_[other][(k + 1) % 3]);
                is_left = is_left || sign > 0;
                is_right = is_right || sign < 0;
            }
            if (is_left && is_right) continue;
            ends.push_back(points_.find(
                Source::of_edge(triangles_[side][i], triangles_[side][next], Cutter::face(faces_[other]))));
        }
    }

    bool is_within_patch(std::size_t side, std::size_t edge) const {
        return patches_ != nullptr && patches_->is_within(faces_[side], edge);
    }
    /// Each face is cut along the other's edges, but for those within the other's patch.
    void add_coplanar(std::vector<RawSegment>& segments) const {
        for (std::size_t side = 0; side < 2; ++side) {
            const std::size_t other = 1 - side, axis = views_[faces_[side]].axis;
            for (std::size_t i = 0; i < 3; ++i) {
                if (!is_within_patch(other, i))
                    add_edge(side, axis, triangles_[other][i], triangles_[other][(i + 1) % 3], segments);
            }
        }
    }
    void add_edge(std::size_t side, std::size_t axis, std::uint32_t a, std::uint32_t b,
                  std::vector<RawSegment>& segments) const {
        const Triangle& face = triangles_[side];
        const auto is_corner = [&](std::uint32_t v) { return std::ranges::find(face, v) != face.end(); };
        if (is_corner(a) && is_corner(b)) return;
        const auto at = [&](std::uint32_t v) { return seen(points_.vertex(v), axis); };
        std::vector<CutPoints::Found> ends;
        for (const std::uint32_t v : {a, b})
            if (is_corner(v) || is_within(points_.vertex(v), side)) ends.push_back(points_.find(Source::of_vertex(v)));
        for (std::size_t i = 0; i < 3; ++i) {
            const std::uint32_t c = face[i], d = face[(i + 1) % 3];
            if (c != a && c != b && orientation(at(a), at(b), at(c)) == 0 && is_between(c, a, b))
                ends.push_back(points_.find(Source::of_vertex(c)));
            if (c == a || c == b || d == a || d == b) continue;
            if (orientation(at(a), at(b), at(c)) * orientation(at(a), at(b), at(d)) < 0 &&
                orientation(at(c), at(d), at(a)) * orientation(at(c), at(d), at(b)) < 0)
                ends.push_back(points_.find(crossing(a, b, c, d, axis)));
        }
        if (ends.empty() ||
            (ends.size() == 1 && ends[0].source.kind == Source::vertex && is_corner(ends[0].source.vertices[0])))
            return;
        segments.push_back({faces_[side], faces_, Cutter::edge(a, b, axis), std::move(ends)});
    }
    /// Of two edges in a plane; the same for both orders.
    static Source crossing(std::uint32_t a, std::uint32_t b, std::uint32_t c, std::uint32_t d, std::size_t axis) {
        if (std::pair(std::min(a, b), std::max(a, b)) > std::pair(std::min(c, d), std::max(c, d))) {
            std::swap(a, c);
            std::swap(b, d);
        }
        return Source::of_edge(a, b, Cutter::edge(c, d, axis));
    }
    /// Whether a vertex on the line of two others is between them.
    bool is_between(std::uint32_t v, std::uint32_t a, std::uint32_t b) const {
        const Vec3 &p = points_.vertex(v), &from = points_.vertex(a), &to = points_.vertex(b);
        for (std::size_t axis = 0; axis < 3; ++axis)
            if (from[axis] != to[axis])
                return std::min(from[axis], to[axis]) < p[axis] && p[axis] < std::max(from[axis], to[axis]);
        return false;
    }

    const CutPoints& points_;
    std::span<const View> views_;
    const PlanePatches* patches_;
    std::array<std::uint32_t, 2> faces_;
    std::array<Triangle, 2> triangles_{};
    std::array<Corners, 2> corners_{};
};

/// Where faces lie in each other, the edges within the patch of one end in points at which the faces of the others need
/// not be cut. There an outline, or another face, may have a patch with the point on one side, and one without it on
/// the other: each face that is cut by something gets the points that the faces of its plane have on it.
void add_points_of_others(const CutPoints& points, std::span<const View> views, const PlanePatches& patches,
                          std::span<const FacePairs> coplanar, std::vector<NumberedSegment>& segments) {
    DisjointSets planes(points.triangles().size());  // by the patches' lowest faces
    std::vector<bool> is_overlapped(points.triangles().size());
    bool is_any = false;
    for (const FacePairs& pairs : coplanar)
        for (const auto& [a, b] : pairs) {
            const std::uint32_t one = patches.lowest(a), other = patches.lowest(b);
            if (one == other) continue;
            planes.join(one, other);
            is_overlapped[one] = is_overlapped[other] = is_any = true;
        }
    if (!is_any) return;

    struct Mark {
        std::uint32_t plane;
        Cutter cutter;
        std::uint32_t point;
        auto operator<=>(const Mark&) const = default;
    };
    std::vector<Mark> marks;
    // Faces of one plane may be seen along different axes.
    const auto line_by = [](Cutter cutter) {
        if (cutter.axis != Cutter::of_face) cutter.axis = 0;
        return cutter;
    };
    const auto is_alone = [&](std::uint32_t face) { return !is_overlapped[patches.lowest(face)]; };
    for (const auto& [face, segment] : segments) {
        if (is_alone(face)) continue;
        const std::uint32_t plane = planes.root(patches.lowest(face));
        for (const std::uint32_t end : {segment.from, segment.to})
            marks.push_back({plane, line_by(segment.cutter), end});
    }
    std::ranges::sort(marks);
    marks.erase(std::ranges::unique(marks).begin(), marks.end());
    // Each line's points in their order along it.
    CutPoints::Cache cache;
    const auto axis_of = [&](std::uint32_t from, std::uint32_t to) {
        std::size_t axis = 0;
        while (axis < 2 && points.compare(from, to, axis, cache) == 0) ++axis;
        return axis;
    };
    const auto is_of_line = [](const Mark& one) {
        return [one](const Mark& other) { return one.plane == other.plane && one.cutter == other.cutter; };
    };
    const auto is_before = [&](std::size_t axis) {
        return [&, axis](std::uint32_t a, std::uint32_t b) { return points.compare(a, b, axis, cache) < 0; };
    };
    for (auto begin = marks.begin(); begin != marks.end();) {
        const auto end = std::find_if_not(begin, marks.end(), is_of_line(*begin));
        if (end - begin > 2) {
            const std::size_t axis = axis_of(begin->point, std::next(begin)->point);
            std::sort(begin, end, [&](const Mark& a, const Mark& b) { return is_before(axis)(a.point, b.point); });
        }
        begin = end;
    }
    const auto line_of = [&](std::uint32_t face, const Cutter& cutter) {
        const std::pair line(planes.root(patches.lowest(face)), line_by(cutter));
        return std::ranges::equal_range(marks, line, {},
                                        [](const Mark& mark) { return std::pair(mark.plane, mark.cutter); });
    };
    const std::size_t count = segments.size();
    for (std::size_t i = 0; i < count; ++i) {
        const auto [face, segment] = segments[i];
        if (segment.from == segment.to || is_alone(face)) continue;
        const auto line = line_of(face, segment.cutter);
        if (line.size() <= 2) continue;
        const std::size_t axis = axis_of(segment.from, segment.to);
        std::uint32_t from = segment.from, to = segment.to;
        const bool is_ascending = points.compare(line.front().point, line.back().point, axis, cache) < 0;
        if ((points.compare(from, to, axis, cache) < 0) != is_ascending) std::swap(from, to);
        const auto is_earlier = [&](std::uint32_t a, std::uint32_t b) {
            return is_ascending ? is_before(axis)(a, b) : is_before(axis)(b, a);
        };
        for (auto mark = std::ranges::upper_bound(line, from, is_earlier, &Mark::point);
             mark != line.end() && is_earlier(mark->point, to); ++mark)
            segments.push_back({face, {mark->point, mark->point, segment.cutter}});
    }
    // A face's own edges cut the others alone.
    for (std::uint32_t face = 0; face < points.triangles().size(); ++face) {
        if (is_alone(face)) continue;
        const Triangle& corners = points.triangles()[face];
        for (std::size_t k = 0; k < 3; ++k) {
            const Cutter edge = Cutter::edge(corners[k], corners[(k + 1) % 3], views[face].axis);
            for (const Mark& mark : line_of(face, edge))
                if (std::ranges::find(corners, mark.point) == corners.end())
                    segments.push_back({face, {mark.point, mark.point, edge}});
        }
    }
}

}  // namespace

std::vector<View> views_of(std::span<const Vec3> vertices, std::span<const Triangle> triangles) {
    std::vector<View> views(triangles.size());
    for_each_index(triangles.size(), [&](std::size_t face) {
        const auto& [a, b, c] = triangles[face];
        if (a != b && b != c && c != a) views[face] = view_of({vertices[a], vertices[b], vertices[c]});
    });
    return views;
}

FaceBoxes::FaceBoxes(std::span<const Vec3> vertices, std::span<const Triangle> triangles, std::span<const View> views,
                     double margin) {
    for (std::uint32_t face = 0; face < triangles.size(); ++face)
        if (views[face].direction != 0) faces_.push_back(face);
    std::vector<Box> boxes(faces_.size(), empty_box);
    for_each_index(faces_.size(), [&](std::size_t i) {
        for (const std::uint32_t v : triangles[faces_[i]]) add(boxes[i], {vertices[v], vertices[v]});
        if (margin > 0) boxes[i] = widened(boxes[i], margin);
    });
    index_.emplace(boxes);
}

Meetings::Meetings(CutPoints& points, std::span<const View> views, const FaceBoxes& boxes, const PlanePatches& patches,
                   const Cancellation& cancellation) {
    find(
        points, views, &patches, boxes.pair_groups(), 16,
        [&](std::size_t group, const auto& f) { boxes.for_each_pair(group, f); }, cancellation);
}

Meetings::Meetings(CutPoints& points, std::span<const View> views, std::span<const std::array<std::uint32_t, 2>> pairs,
                   const Cancellation& cancellation) {
    constexpr std::size_t in_group = 64;
    find(
        points, views, nullptr, chunk_count(pairs.size(), in_group), 1,
        [&](std::size_t group, const auto& f) {
            const std::size_t begin = group * in_group;
            for (const auto& [a, b] : pairs.subspan(begin, std::min(in_group, pairs.size() - begin))) f(a, b);
        },
        cancellation);
}

template <typename ForEachPair>
void Meetings::find(CutPoints& points, std::span<const View> views, const PlanePatches* patches, std::size_t groups,
                    std::size_t grain, const ForEachPair& for_each_pair, const Cancellation& cancellation) {
    begins_.assign(views.size() + 1, 0);
    std::vector<std::vector<RawSegment>> by_group(groups);
    std::vector<FacePairs> coplanar_by_group(patches != nullptr ? groups : 0);
    for_each_index(
        groups,
        [&](std::size_t group) {
            cancellation.check();
            for_each_pair(group, [&](std::uint32_t first, std::uint32_t second) {
                if (Pair(points, views, patches, first, second).add_to(by_group[group]) && patches != nullptr)
                    coplanar_by_group[group].push_back({first, second});
            });
        },
        grain);
    // Points get their numbers in the order of the faces.
    std::vector<RawSegment> found;
    for (std::vector<RawSegment>& group : by_group) std::ranges::move(group, std::back_inserter(found));
    std::ranges::stable_sort(found, {}, &RawSegment::pair);
    std::vector<NumberedSegment> numbered;
    for (const RawSegment& raw : found) {
        FaceSegment segment{points.number(raw.ends.front()), 0, raw.cutter};
        segment.to = segment.from;
        for (const CutPoints::Found& end : raw.ends)
            if (const std::uint32_t number = points.number(end); number != segment.from) segment.to = number;
        numbered.emplace_back(raw.face, segment);
    }
    if (patches != nullptr) add_points_of_others(points, views, *patches, coplanar_by_group, numbered);
    // The edges of a face in the same plane come once more from their other faces.
    const auto key = [](const auto& entry) {
        const auto& [face, segment] = entry;
        return std::tuple(face, std::min(segment.from, segment.to), std::max(segment.from, segment.to), segment.cutter);
    };
    std::ranges::sort(numbered, {}, key);
    numbered.erase(std::ranges::unique(numbered, {}, key).begin(), numbered.end());
    segments_.reserve(numbered.size());
    for (const auto& [face, segment] : numbered) {
        segments_.push_back(segment);
        ++begins_[face + 1];
    }
    for (std::size_t face = 0; face < views.size(); ++face) begins_[face + 1] += begins_[face];
}

}  // namespace clsdf::cutting
