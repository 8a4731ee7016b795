#include "surface/winding_test.hpp"

#include "core/parallel.hpp"
#include "mesh/box_index.hpp"
#include "mesh/disjoint_sets.hpp"
#include "mesh/face_distances.hpp"
#include "surface/edge_counts.hpp"
#include "surface/local_frame.hpp"
#include "surface/parts.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <utility>

namespace clsdf {

namespace {

// Points of a surface of one part, and of the largest of many; the n-th one has so many over n.
constexpr std::size_t places_beside_faces = 256, points_in_box = 512, points_in_holes = 64;
// Parts with open edges that are tested one by one: those of the largest areas.
constexpr std::size_t most_single_parts = 256;
constexpr std::size_t least_places = 8, least_in_box = 16;
// Points on the rim and places beside the faces of a part that may be a detail.
constexpr std::size_t points_on_rims = 64, places_on_details = 32;
// The share of details in the area: of all together, and of each that is in doubt nearly everywhere, as a sheet is.
constexpr double most_area_of_details = 1.0 / 8, most_area_of_sheet = 1.0 / 512;
// The mean distance of a detail's rim from the others, in the detail's longest side and in that of its faces.
constexpr double most_to_side = 0.25, most_to_faces = 1.5;
// With more corners of open edges, fewer points are tested.
constexpr std::size_t very_many_corners = 32768;
constexpr std::uint32_t none = std::numeric_limits<std::uint32_t>::max();

/// Faces that are tested together.
struct TestedPart {
    std::vector<std::uint32_t> faces;  ///< ascending
    double area = 0;
    bool has_open_edge = false;
    bool is_single = true;  ///< no other part is with it
};

Box box_of(const Mesh& mesh, std::span<const Triangle> triangles, std::span<const std::uint32_t> faces) {
    Box box = empty_box;
    for (const std::uint32_t face : faces)
        for (const std::uint32_t vertex : triangles[face]) add(box, {mesh.vertices()[vertex], mesh.vertices()[vertex]});
    return box;
}

double area_of(const LocalFrame& frame, const Triangle& triangle) {
    return length_of(frame.normal(triangle));
}

/// A number of points or parts; a quarter of it if there are very many open edges.
std::size_t fewer(std::size_t count, const OpenLoops& loops) {
    return loops.vertices.size() > very_many_corners ? count / 4 : count;
}

/// The parts with open edges, the largest area first; the last one has all others.
std::vector<TestedPart> tested_parts(const Mesh& mesh, std::span<const Triangle> triangles, const OpenLoops& loops) {
    if (is_one_part(triangles, mesh.vertices().size())) {
        std::vector<TestedPart> one(1);
        one[0].has_open_edge = true;
        one[0].faces.reserve(triangles.size());
        for (std::uint32_t face = 0; face < triangles.size(); ++face)
            if (!has_repeated_vertex(triangles[face])) one[0].faces.push_back(face);
        return one;
    }
    DisjointSets sets(mesh.vertices().size());
    for (const Triangle& triangle : triangles)
        if (!has_repeated_vertex(triangle)) {
            sets.join(triangle[0], triangle[1]);
            sets.join(triangle[0], triangle[2]);
        }
    struct Sizes {
        std::uint32_t root;
        double area = 0;
    };
    std::vector<std::uint32_t> numbers(mesh.vertices().size(), none);
    std::vector<Sizes> open;
    for (const std::uint32_t vertex : loops.vertices) {
        const std::uint32_t root = sets.root(vertex);
        if (numbers[root] != none) continue;
        numbers[root] = static_cast<std::uint32_t>(open.size());
        open.push_back({root});
    }
    const LocalFrame frame(mesh);
    for (const Triangle& triangle : triangles)
        if (!has_repeated_vertex(triangle))
            if (const std::uint32_t number = numbers[sets.root(triangle[0])]; number != none)
                open[number].area += area_of(frame, triangle);
    std::ranges::sort(
        open, [](const Sizes& a, const Sizes& b) { return a.area != b.area ? a.area > b.area : a.root < b.root; });
    const std::size_t singles = std::min(open.size(), fewer(most_single_parts, loops));
    for (std::size_t i = 0; i < open.size(); ++i)
        numbers[open[i].root] = static_cast<std::uint32_t>(std::min(i, singles));
    std::vector<TestedPart> parts(singles + 1);
    for (std::size_t i = 0; i < singles; ++i) parts[i].has_open_edge = true;
    parts.back().has_open_edge = singles < open.size();
    parts.back().is_single = false;
    for (std::uint32_t face = 0; face < triangles.size(); ++face)
        if (!has_repeated_vertex(triangles[face]))
            parts[std::min<std::size_t>(numbers[sets.root(triangles[face][0])], singles)].faces.push_back(face);
    if (parts.back().faces.empty()) parts.pop_back();
    return parts;
}

bool is_clear_in_box(const WindingView& view, const Box& box) {
    WindingTally tally;
    tally.add(view.at(points_in(box, points_in_box)));
    return 10 * tally.doubtful <= tally.tested && tally.inside > 0;
}

/// Whether all faces lie in one plane, up to rounding.
bool is_flat(const Mesh& mesh, std::span<const Triangle> triangles, std::span<const std::uint32_t> faces) {
    constexpr double tolerance = 1e-9;
    const Mesh own = surface_of(mesh, triangles, faces);
    const LocalFrame frame(own);
    std::uint32_t largest = 0;
    double area = 0;
    for (std::uint32_t face = 0; face < faces.size(); ++face)
        if (const double one = area_of(frame, own.triangles()[face]); one > area) {
            area = one;
            largest = face;
        }
    const Triangle& triangle = own.triangles()[largest];
    const Vec3 a = frame.local(triangle[0]), normal = frame.normal(triangle);
    for (std::uint32_t vertex = 0; vertex < own.vertices().size(); ++vertex) {
        const Vec3 at = frame.local(vertex);
        double height = 0;
        for (std::size_t axis = 0; axis < 3; ++axis) height += normal[axis] * (at[axis] - a[axis]);
        if (!(std::abs(height) <= tolerance * area)) return false;
    }
    return true;
}

/// The points of a part, among those of all.
struct PointRange {
    std::size_t begin, end;
};

/// Judges the parts of a surface one by one.
class PartsTest {
public:
    PartsTest(const Mesh& mesh, std::span<const Triangle> triangles, const OpenLoops& loops)
        : mesh_(mesh), triangles_(triangles), loops_(loops), parts_(tested_parts(mesh, triangles, loops)) {
        for (std::size_t i = 0; i < parts_.size(); ++i) {
            const std::size_t begin = points_.size();
            add(points_beside(mesh, triangles, parts_[i].faces,
                              std::max(fewer(places_beside_faces, loops) / (i + 1), least_places)));
            if (parts_[i].is_single)
                add(points_in(box_of(mesh, triangles, parts_[i].faces),
                              std::max(fewer(points_in_box, loops) / (i + 1), least_in_box)));
            ranges_.push_back({begin, points_.size()});
        }
    }

    WindingTest run(bool may_be_covered) {
        const WindingView view(mesh_, triangles_, loops_);
        seen_ = view.at(points_);
        WindingTest test;
        test.all.add(seen_);
        find_unclear([](const WindingTally& tally) { return tally.is_clear(); });
        if (!unclear_.empty() && is_clear_in_box(view, mesh_.box())) {
            // A mesh that is clear as a whole may have more doubt beside some parts, and flat sheets.
            std::erase_if(unclear_, [&](std::size_t i) { return tally_of(i).is_nearly_clear() && has_inside(i); });
            test.has_clear_parts = !unclear_.empty() && unclear_.size() < parts_.size();
            std::vector<std::size_t> details;
            if (may_be_covered && test.has_clear_parts) {
                take_covered();
                const std::vector<std::size_t> before = unclear_;
                take_details();
                std::ranges::set_difference(before, unclear_, std::back_inserter(details));
            }
            if (unclear_.size() < parts_.size() && are_flat_and_harmless()) unclear_.clear();
            if (unclear_.empty()) count_details(details, test);
        }
        for (const std::size_t i : unclear_)
            if (test.unclear_parts++ == 0 || parts_[i].faces[0] < test.first_unclear_face)
                test.first_unclear_face = parts_[i].faces[0];
        if (test.unclear_parts == 0 && test.all.inside == 0) test.unclear_parts = 1;
        test.points = std::move(points_);
        return test;
    }

private:
    void add(const std::vector<Vec3>& points) { points_.insert(points_.end(), points.begin(), points.end()); }

    std::span<const SeenWinding> seen_by(std::size_t i) const {
        return std::span(seen_).subspan(ranges_[i].begin, ranges_[i].end - ranges_[i].begin);
    }
    WindingTally tally_of(std::size_t i) const {
        WindingTally tally;
        tally.add(seen_by(i));
        return tally;
    }
    bool has_inside(std::size_t i) const { return !parts_[i].has_open_edge || tally_of(i).inside > 0; }

    template <typename IsClear>
    void find_unclear(const IsClear& is_clear) {
        for (std::size_t i = 0; i < parts_.size(); ++i)
            if (!is_clear(tally_of(i)) || !has_inside(i)) unclear_.push_back(i);
    }

    /// The surface without some parts.
    std::vector<Triangle> without(std::span<const std::size_t> parts) const {
        std::vector<Triangle> rest(triangles_.begin(), triangles_.end());
        for (const std::size_t i : parts)
            for (const std::uint32_t face : parts_[i].faces) rest[face] = {0, 0, 0};
        return rest;
    }

    /// Parts whose holes lie within the others are closed by these: an eye in a head. They are clear if next to
    /// nothing that is inside without them is outside with them.
    void take_covered() {
        for (bool is_changed = true; is_changed && !unclear_.empty() && unclear_.size() < parts_.size();) {
            const std::vector<Triangle> rest = without(unclear_);
            const OpenLoops rest_loops = loops_of(count_edges(rest, mesh_.vertices().size()));
            std::vector<Vec3> points;
            std::vector<PointRange> holes, own;
            for (const std::size_t i : unclear_) {
                holes.push_back({points.size(), points.size()});
                if (parts_[i].is_single) add_holes(parts_[i], points);
                holes.back().end = points.size();
                own.push_back({points.size(), points.size() + ranges_[i].end - ranges_[i].begin});
                points.insert(points.end(), points_.begin() + static_cast<std::ptrdiff_t>(ranges_[i].begin),
                              points_.begin() + static_cast<std::ptrdiff_t>(ranges_[i].end));
            }
            const std::vector<SeenWinding> seen = WindingView(mesh_, rest, rest_loops).at(points);
            std::vector<std::size_t> left;
            for (std::size_t k = 0; k < unclear_.size(); ++k) {
                const auto of_rest = [&](const PointRange& range) {
                    return std::span(seen).subspan(range.begin, range.end - range.begin);
                };
                const auto with = seen_by(unclear_[k]), without = of_rest(own[k]);
                const auto in_holes = of_rest(holes[k]);
                const auto covered = static_cast<std::size_t>(std::ranges::count_if(in_holes, &SeenWinding::is_inside));
                bool is_covered = covered > 0 && 4 * covered >= 3 * in_holes.size();
                std::size_t lost = 0;
                for (std::size_t n = 0; n < with.size(); ++n)
                    lost += without[n].is_inside() && !with[n].is_inside() ? 1U : 0U;
                is_covered = is_covered && 50 * lost <= with.size();
                if (!is_covered) left.push_back(unclear_[k]);
            }
            is_changed = left.size() < unclear_.size();
            unclear_ = std::move(left);
        }
    }

    /// Small parts that are attached to the others are details of these: a lamp on a robot. A person sees them as one
    /// body, and the clear parts say that there is one. A part is attached if its rim lies within the others or close
    /// to them, and not much farther from them than its faces.
    void take_details() {
        std::vector<double> areas(parts_.size());
        double area = 0, area_in_doubt = 0;
        const LocalFrame frame(mesh_);
        for (std::size_t i = 0; i < parts_.size(); ++i) {
            for (const std::uint32_t face : parts_[i].faces) areas[i] += area_of(frame, triangles_[face]);
            area += areas[i];
        }
        for (const std::size_t i : unclear_) area_in_doubt += areas[i];
        if (!(area_in_doubt <= most_area_of_details * area)) return;
        const auto may_be_detail = [&](std::size_t i) {
            const WindingTally tally = tally_of(i);
            const bool is_sheet = tally.inside == 0 || 3 * tally.doubtful_inside > 2 * tally.inside;
            return parts_[i].is_single && (!is_sheet || areas[i] <= most_area_of_sheet * area);
        };
        for (bool is_changed = true; is_changed && !unclear_.empty();) {
            std::vector<Triangle> rest = without(unclear_);
            const OpenLoops rest_loops = loops_of(count_edges(rest, mesh_.vertices().size()));
            const WindingView view(mesh_, rest, rest_loops);
            std::vector<Triangle> faces;
            std::ranges::remove_copy_if(rest, std::back_inserter(faces), has_repeated_vertex);
            const FaceDistances distances(mesh_, faces);
            // The points of all parts at once: the view looks at all faces.
            std::vector<Vec3> points;
            std::vector<PointRange> rims, beside;
            for (const std::size_t i : unclear_) {
                const bool is_wanted = may_be_detail(i);
                const auto append = [&](std::vector<PointRange>& ranges, const std::vector<Vec3>& own) {
                    ranges.push_back({points.size(), points.size() + own.size()});
                    points.insert(points.end(), own.begin(), own.end());
                };
                append(rims, is_wanted ? points_on_rim(parts_[i]) : std::vector<Vec3>());
                append(beside, is_wanted ? points_beside(mesh_, triangles_, parts_[i].faces, places_on_details)
                                         : std::vector<Vec3>());
            }
            const std::vector<SeenWinding> seen = view.at(points);
            std::vector<std::size_t> left;
            for (std::size_t k = 0; k < unclear_.size(); ++k) {
                const double side = longest_side(parts_[unclear_[k]]);
                const auto mean = [&](const PointRange& range) {
                    double sum = 0;
                    for (std::size_t n = range.begin; n < range.end; ++n)
                        sum += seen[n].is_inside() ? 0 : distances.at(points[n], side);
                    return sum / static_cast<double>(range.end - range.begin);  // not a number if there are none
                };
                const double of_rim = mean(rims[k]);
                if (!(of_rim <= most_to_side && of_rim <= most_to_faces * mean(beside[k]))) left.push_back(unclear_[k]);
            }
            is_changed = left.size() < unclear_.size();
            unclear_ = std::move(left);
        }
    }

    double longest_side(const TestedPart& part) const {
        const Box box = box_of(mesh_, triangles_, part.faces);
        double side = 0;
        for (std::size_t axis = 0; axis < 3; ++axis) side = std::max(side, box.upper[axis] - box.lower[axis]);
        return side;
    }

    /// Points on a part's open edges, at fixed places that are spread by length.
    std::vector<Vec3> points_on_rim(const TestedPart& part) const {
        const std::vector<std::uint32_t> vertices = vertices_of(part);
        std::vector<std::pair<Vec3, Vec3>> edges;
        std::vector<double> ends;  // the length up to the end of each edge
        for (std::size_t loop = 0; loop + 1 < loops_.begins.size(); ++loop) {
            const std::size_t begin = loops_.begins[loop], end = loops_.begins[loop + 1];
            if (!std::ranges::binary_search(vertices, loops_.vertices[begin])) continue;
            for (std::size_t i = begin; i < end; ++i) {
                const Vec3 &from = mesh_.vertices()[loops_.vertices[i]],
                           &to = mesh_.vertices()[loops_.vertices[i + 1 < end ? i + 1 : begin]];
                edges.emplace_back(from, to);
                ends.push_back((ends.empty() ? 0 : ends.back()) +
                               length_of({to[0] - from[0], to[1] - from[1], to[2] - from[2]}));
            }
        }
        std::vector<Vec3> points;
        for (std::size_t i = 0; i < points_on_rims; ++i) {
            const double place = (static_cast<double>(i) + 0.5) / points_on_rims * ends.back();
            const auto edge = static_cast<std::size_t>(std::ranges::lower_bound(ends, place) - ends.begin());
            const double begin = edge > 0 ? ends[edge - 1] : 0, length = ends[edge] - begin;
            const double share = length > 0 ? (place - begin) / length : 0;
            Vec3& point = points.emplace_back();
            for (std::size_t axis = 0; axis < 3; ++axis)
                point[axis] = (1 - share) * edges[edge].first[axis] + share * edges[edge].second[axis];
        }
        return points;
    }

    /// Ascending, each as often as it has faces.
    std::vector<std::uint32_t> vertices_of(const TestedPart& part) const {
        std::vector<std::uint32_t> vertices;
        for (const std::uint32_t face : part.faces)
            vertices.insert(vertices.end(), triangles_[face].begin(), triangles_[face].end());
        std::ranges::sort(vertices);
        return vertices;
    }

    /// Adds points in a part's holes: on a fan around the middle of each loop of open edges.
    void add_holes(const TestedPart& part, std::vector<Vec3>& points) const {
        const std::vector<std::uint32_t> vertices = vertices_of(part);
        std::vector<Vec3> in_holes;
        for (std::size_t loop = 0; loop + 1 < loops_.begins.size(); ++loop) {
            const std::span<const std::uint32_t> corners =
                std::span(loops_.vertices).subspan(loops_.begins[loop], loops_.begins[loop + 1] - loops_.begins[loop]);
            if (!std::ranges::binary_search(vertices, corners.front())) continue;
            Vec3 middle{};
            for (const std::uint32_t corner : corners)
                for (std::size_t axis = 0; axis < 3; ++axis)
                    middle[axis] += mesh_.vertices()[corner][axis] / static_cast<double>(corners.size());
            for (const std::uint32_t corner : corners)
                for (const double share : {0.3, 0.7}) {
                    Vec3& point = in_holes.emplace_back();
                    for (std::size_t axis = 0; axis < 3; ++axis)
                        point[axis] = share * middle[axis] + (1 - share) * mesh_.vertices()[corner][axis];
                }
        }
        const std::size_t step = chunk_count(in_holes.size(), points_in_holes);
        for (std::size_t i = 0; i < in_holes.size(); i += step) points.push_back(in_holes[i]);
    }

    void count_details(std::span<const std::size_t> details, WindingTest& test) const {
        test.detail_parts = details.size();
        for (const std::size_t i : details) {
            const std::uint32_t first = parts_[i].faces[0];
            test.first_detail_face = test.detail_faces == 0 ? first : std::min(test.first_detail_face, first);
            test.detail_faces += parts_[i].faces.size();
        }
    }

    bool are_flat_and_harmless() const {
        std::vector<Vec3> at;
        std::vector<SeenWinding> with;
        for (const std::size_t i : unclear_) {
            if (!parts_[i].is_single || !is_flat(mesh_, triangles_, parts_[i].faces)) return false;
            at.insert(at.end(), points_.begin() + static_cast<std::ptrdiff_t>(ranges_[i].begin),
                      points_.begin() + static_cast<std::ptrdiff_t>(ranges_[i].end));
            with.insert(with.end(), seen_by(i).begin(), seen_by(i).end());
        }
        const std::vector<Triangle> rest = without(unclear_);
        const OpenLoops rest_loops = loops_of(count_edges(rest, mesh_.vertices().size()));
        return std::ranges::equal(with, WindingView(mesh_, rest, rest_loops).at(at), {}, &SeenWinding::is_inside,
                                  &SeenWinding::is_inside);
    }

    const Mesh& mesh_;
    std::span<const Triangle> triangles_;
    const OpenLoops& loops_;
    std::vector<TestedPart> parts_;
    std::vector<PointRange> ranges_;  // of each part
    std::vector<Vec3> points_;
    std::vector<SeenWinding> seen_;
    std::vector<std::size_t> unclear_;  // parts, ascending
};

}  // namespace

WindingTest test_winding_number(const Mesh& mesh, std::span<const Triangle> triangles, const OpenLoops& loops,
                                bool may_be_covered) {
    return PartsTest(mesh, triangles, loops).run(may_be_covered);
}

}  // namespace clsdf
