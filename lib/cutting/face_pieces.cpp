#include "cutting/face_pieces.hpp"

#include "cutting/triangulation.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

namespace clsdf::cutting {

namespace {

/// The box of a segment on two axes, not smaller than it is.
struct SeenBox {
    std::array<double, 2> lower, upper;

    SeenBox(const Vec3& a, const Vec3& b, std::size_t axis) {
        for (std::size_t i = 0; i < 2; ++i) {
            const double p = a[(axis + 1 + i) % 3], q = b[(axis + 1 + i) % 3];
            constexpr double infinity = std::numeric_limits<double>::infinity();
            lower[i] = std::nextafter(std::min(p, q), -infinity);
            upper[i] = std::nextafter(std::max(p, q), infinity);
        }
    }
    bool meets(const SeenBox& other) const {
        return lower[0] <= other.upper[0] && other.lower[0] <= upper[0] && lower[1] <= other.upper[1] &&
               other.lower[1] <= upper[1];
    }
};

/// Whether a point on the line of two others is between them.
bool is_between(const CutPoints& points, std::uint32_t p, std::uint32_t a, std::uint32_t b, CutPoints::Cache& cache) {
    for (std::size_t axis = 0; axis < 3; ++axis)
        if (const int order = points.compare(a, b, axis, cache); order != 0)
            return points.compare(p, a, axis, cache) == -order && points.compare(p, b, axis, cache) == order;
    return false;
}

}  // namespace

FaceCuts::FaceCuts(const CutPoints& points, std::uint32_t face, const View& view, std::span<const FaceSegment> segments)
    : face_(face), view_(view) {
    const Triangle& corners = points.triangles()[face];
    for (std::size_t i = 0; i < 3; ++i) {
        const std::uint32_t a = corners[i], b = corners[(i + 1) % 3];
        segments_.push_back({a, b, Cutter::edge(a, b, view.axis)});
    }
    segments_.insert(segments_.end(), segments.begin(), segments.end());
    ends_.resize(segments_.size());
    std::vector<SeenBox> boxes;
    boxes.reserve(segments_.size());
    for (const FaceSegment& segment : segments_)
        boxes.emplace_back(points.rounded(segment.from), points.rounded(segment.to), view.axis);
    std::vector<std::uint32_t> order(segments_.size());
    for (std::uint32_t i = 0; i < order.size(); ++i) order[i] = i;
    std::ranges::sort(order, {}, [&](std::uint32_t i) { return std::pair(boxes[i].lower[0], i); });
    CutPoints::Cache cache;
    for (std::size_t i = 0; i < order.size(); ++i)
        for (std::size_t j = i + 1; j < order.size() && boxes[order[j]].lower[0] <= boxes[order[i]].upper[0]; ++j)
            if (boxes[order[i]].meets(boxes[order[j]]))
                look_at(points, std::min(order[i], order[j]), std::max(order[i], order[j]), cache);
}

void FaceCuts::look_at(const CutPoints& points, std::uint32_t first, std::uint32_t second, CutPoints::Cache& cache) {
    const FaceSegment &s = segments_[first], &t = segments_[second];
    const auto side = [&](const FaceSegment& segment, std::uint32_t point) {
        if (point == segment.from || point == segment.to || segment.from == segment.to) return 0;
        const Source& source = points.source(point);
        if (source.is_on(segment.cutter) || source.is_on_edge(segment.from, segment.to)) return 0;
        return points.orientation(segment.from, segment.to, point, view_.axis, cache);
    };
    const std::array<int, 2> of_t{side(s, t.from), side(s, t.to)}, of_s{side(t, s.from), side(t, s.to)};
    const auto add_end = [&](std::uint32_t segment, std::uint32_t point, int side_of_point) {
        const FaceSegment& across = segments_[segment];
        if (side_of_point == 0 && across.from != across.to && point != across.from && point != across.to &&
            is_between(points, point, across.from, across.to, cache))
            ends_[segment].push_back(point);
    };
    add_end(first, t.from, of_t[0]);
    if (t.to != t.from) add_end(first, t.to, of_t[1]);
    add_end(second, s.from, of_s[0]);
    if (s.to != s.from) add_end(second, s.to, of_s[1]);
    if (of_t[0] * of_t[1] < 0 && of_s[0] * of_s[1] < 0) {
        crossings_.push_back(points.find(Source::of_planes({Cutter::face(face_), s.cutter, t.cutter})));
        crossed_.push_back({first, second});
    }
}

std::vector<Triangle> FaceCuts::pieces(const CutPoints& points, std::span<const std::uint32_t> crossings) const {
    std::vector<std::vector<std::uint32_t>> inner = ends_;
    for (std::size_t i = 0; i < crossings.size(); ++i) {
        inner[crossed_[i].first].push_back(crossings[i]);
        inner[crossed_[i].second].push_back(crossings[i]);
    }
    FaceTriangulation triangulation(points, points.triangles()[face_], view_);
    std::vector<std::uint32_t> all(crossings.begin(), crossings.end());
    for (const FaceSegment& segment : segments_) {
        all.push_back(segment.from);
        all.push_back(segment.to);
    }
    std::ranges::sort(all);
    all.erase(std::ranges::unique(all).begin(), all.end());
    for (const std::uint32_t point : all) triangulation.add_point(point);
    CutPoints::Cache cache;
    for (std::size_t i = 0; i < segments_.size(); ++i) {
        const FaceSegment& segment = segments_[i];
        if (segment.from == segment.to) continue;
        std::vector<std::uint32_t>& on = inner[i];
        std::size_t axis = 0;
        int order = 0;
        while (axis < 3 && (order = points.compare(segment.from, segment.to, axis, cache)) == 0) ++axis;
        std::ranges::sort(on);
        on.erase(std::ranges::unique(on).begin(), on.end());
        std::ranges::sort(on,
                          [&](std::uint32_t a, std::uint32_t b) { return points.compare(a, b, axis, cache) == order; });
        on.push_back(segment.to);
        std::uint32_t last = segment.from;
        for (const std::uint32_t point : on) {
            triangulation.add_segment(last, point);
            last = point;
        }
    }
    return triangulation.triangles();
}

}  // namespace clsdf::cutting
