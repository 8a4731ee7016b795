#include "surface/winding_test.hpp"

#include "core/parallel.hpp"
#include "mesh/box_index.hpp"
#include "mesh/disjoint_sets.hpp"
#include "surface/edge_counts.hpp"
#include "surface/film_tree.hpp"
#include "surface/local_frame.hpp"
#include "surface/parts.hpp"
#include "surface/ray_side.hpp"

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <functional>
#include <limits>
#include <numeric>
#include <utility>

namespace clsdf {

namespace {

// Points of a surface of one part, and of the largest of many; the n-th one has so many over n.
constexpr std::size_t places_beside_faces = 256, points_in_box = 512, points_in_holes = 64;
// Parts with open edges that are tested one by one: those of the largest areas.
constexpr std::size_t most_single_parts = 256;
constexpr std::size_t least_places = 8, least_in_box = 16;
// With more corners of open edges, a tree of them costs less than all of them; with very many, fewer points are tested.
constexpr std::size_t many_corners = 2048, very_many_corners = 32768;
constexpr std::uint32_t none = std::numeric_limits<std::uint32_t>::max();

double halton(std::size_t number, std::size_t base) {
    double digit = 1, result = 0;
    for (; number > 0; number /= base) {
        digit /= static_cast<double>(base);
        result += digit * static_cast<double>(number % base);
    }
    return result;
}

double half_of_longest(const Box& box) {
    double half = 0;
    for (std::size_t axis = 0; axis < 3; ++axis) half = std::max(half, box.upper[axis] / 2 - box.lower[axis] / 2);
    return half;
}

/// The crossings of the points' rays towards -x with triangles. Cells across (y, z) hold the points.
class RayCrossings {
public:
    explicit RayCrossings(std::span<const Vec3> points) : points_(points), counts_(points.size()) {
        side_ =
            std::clamp<std::size_t>(static_cast<std::size_t>(std::sqrt(static_cast<double>(points.size()))), 1, 128);
        for (std::size_t k = 0; k < 2; ++k) {
            double lower = std::numeric_limits<double>::infinity(), upper = -lower;
            for (const Vec3& point : points) {
                lower = std::min(lower, point[k + 1] / 2);
                upper = std::max(upper, point[k + 1] / 2);
            }
            lower_[k] = lower;
            const double per_length = upper > lower ? static_cast<double>(side_) / (upper - lower) : 0;
            per_length_[k] = std::isfinite(per_length) ? per_length : 0;
        }
        first_.assign(side_ * side_ + 1, 0);
        for (const Vec3& point : points) ++first_[cell_of(point) + 1];
        std::partial_sum(first_.begin(), first_.end(), first_.begin());
        order_.resize(points.size());
        std::vector<std::uint32_t> next(first_.begin(), first_.end() - 1);
        for (std::uint32_t i = 0; i < points.size(); ++i) order_[next[cell_of(points[i])]++] = i;
    }

    void add(const Mesh& mesh, std::span<const Triangle> triangles) {
        for_each_range(
            triangles.size(),
            [&](std::size_t begin, std::size_t end) {
                for (std::size_t t = begin; t != end; ++t) add(mesh, triangles[t]);
            },
            4096);
    }

    std::span<const int> counts() const { return counts_; }

private:
    /// Ascends with the coordinate.
    std::size_t bin_of(double x, std::size_t k) const {
        const double bin = (x / 2 - lower_[k]) * per_length_[k];
        return bin > 0 ? std::min(static_cast<std::size_t>(std::min(bin, 1e9)), side_ - 1) : 0;
    }
    std::size_t cell_of(const Vec3& point) const { return bin_of(point[1], 0) * side_ + bin_of(point[2], 1); }

    void add(const Mesh& mesh, const Triangle& triangle) {
        if (has_repeated_vertex(triangle)) return;
        const Vec3 &a = mesh.vertices()[triangle[0]], &b = mesh.vertices()[triangle[1]],
                   &c = mesh.vertices()[triangle[2]];
        const double low_x = std::min({a[0], b[0], c[0]}), low_y = std::min({a[1], b[1], c[1]}),
                     high_y = std::max({a[1], b[1], c[1]}), low_z = std::min({a[2], b[2], c[2]}),
                     high_z = std::max({a[2], b[2], c[2]});
        const std::size_t last_y = bin_of(high_y, 0), first_z = bin_of(low_z, 1), last_z = bin_of(high_z, 1);
        for (std::size_t y = bin_of(low_y, 0); y <= last_y; ++y)
            for (std::size_t n = first_[y * side_ + first_z]; n < first_[y * side_ + last_z + 1]; ++n) {
                const std::uint32_t i = order_[n];
                const Vec3& p = points_[i];
                if (p[1] < low_y || p[1] > high_y || p[2] < low_z || p[2] > high_z || p[0] < low_x) continue;
                const int side = side_of_edges(a, b, c, p);
                if (side == 0 || orientation(a, b, c, p) != side) continue;  // the crossing has a greater x
                std::atomic_ref(counts_[i]).fetch_sub(side, std::memory_order_relaxed);
            }
    }

    std::span<const Vec3> points_;
    std::vector<int> counts_;
    std::size_t side_;
    std::array<double, 2> lower_{}, per_length_{};
    std::vector<std::uint32_t> first_;  // the place in order_ where each cell begins
    std::vector<std::uint32_t> order_;  // points, cell after cell
};

double length_of(const Vec3& v) {
    return std::sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
}

bool is_float(double x) {
    return static_cast<double>(static_cast<float>(x)) == x;
}

}  // namespace

WindingView::WindingView(const Mesh& mesh, std::span<const Triangle> triangles, const OpenLoops& loops)
    : mesh_(mesh), triangles_(triangles), boundary_(std::make_shared<const OpenBoundary>(loops, mesh.vertices())) {
    const double longest = half_of_longest(mesh.box());
    unit_ = std::ldexp(1.0, std::clamp(longest > 0 ? std::ilogb(longest) : 0, -1000, 1000));
    if (boundary_->corners.size() > many_corners) film_ = std::make_shared<const FilmTree>(boundary_, unit_);
}

std::vector<SeenWinding> WindingView::at(std::span<const Vec3> points) const {
    if (points.empty()) return {};
    RayCrossings crossings(points);
    crossings.add(mesh_, triangles_);
    std::vector<SeenWinding> seen(points.size());
    for_each_index(
        points.size(),
        [&](std::size_t i) {
            SeenWinding& one = seen[i];
            if (film_) {
                const FilmTree::View view = film_->look_by_moments(points[i]);
                one = {view.rounded, view.to_half};
            } else if (!boundary_->empty()) {
                const SolidAngle angle = angle_of(*boundary_, points[i], unit_);
                one = {angle.rounded, 0.5 - std::abs(angle.turns - std::nearbyint(angle.turns))};
            }
            one.rounded += crossings.counts()[i];
        },
        8);
    return seen;
}

Mesh surface_of(const Mesh& mesh, std::span<const Triangle> triangles, std::span<const std::uint32_t> faces) {
    // Few faces of a large mesh are looked up in a sorted list, many in an array.
    const bool are_few = 16 * faces.size() < mesh.vertices().size();
    std::vector<std::uint32_t> used, numbers;
    if (are_few) {
        used.reserve(3 * faces.size());
        for (const std::uint32_t face : faces) used.insert(used.end(), triangles[face].begin(), triangles[face].end());
        std::ranges::sort(used);
        const auto repeated = std::ranges::unique(used);
        used.erase(repeated.begin(), repeated.end());
    } else {
        numbers.assign(mesh.vertices().size(), 0);
        for (const std::uint32_t face : faces)
            for (const std::uint32_t vertex : triangles[face]) numbers[vertex] = 1;
        for (std::uint32_t vertex = 0; vertex < numbers.size(); ++vertex)
            if (numbers[vertex] != 0) {
                numbers[vertex] = static_cast<std::uint32_t>(used.size());
                used.push_back(vertex);
            }
    }
    std::vector<Vec3> positions;
    positions.reserve(used.size());
    for (const std::uint32_t vertex : used) positions.push_back(mesh.vertices()[vertex]);
    std::vector<Triangle> own;
    own.reserve(faces.size());
    for (const std::uint32_t face : faces) {
        Triangle& triangle = own.emplace_back();
        for (std::size_t k = 0; k < 3; ++k) {
            const std::uint32_t vertex = triangles[face][k];
            triangle[k] = are_few ? static_cast<std::uint32_t>(std::ranges::lower_bound(used, vertex) - used.begin())
                                  : numbers[vertex];
        }
    }
    return {std::move(positions), std::move(own), mesh.name()};
}

std::vector<Vec3> points_in(const Box& box, std::size_t count) {
    constexpr std::array<std::size_t, 3> bases{2, 3, 5};
    std::vector<Vec3> points(count);
    for (std::size_t i = 0; i < points.size(); ++i)
        for (std::size_t axis = 0; axis < 3; ++axis) {
            const double share = halton(i + 1, bases[axis]);
            points[i][axis] = box.lower[axis] * (1 - share) + box.upper[axis] * share;
        }
    return points;
}

std::vector<Vec3> points_beside(const Mesh& mesh, std::span<const Triangle> triangles,
                                std::span<const std::uint32_t> faces, std::size_t places) {
    const LocalFrame frame(mesh);
    std::vector<double> areas(faces.size());
    for_each_range(
        faces.size(),
        [&](std::size_t begin, std::size_t end) {
            for (std::size_t i = begin; i != end; ++i) areas[i] = length_of(frame.normal(triangles[faces[i]]));
        },
        4096);
    const double total = std::accumulate(areas.begin(), areas.end(), 0.0);
    if (!(total > 0) || !std::isfinite(total)) return {};
    std::vector<std::uint32_t> chosen;
    chosen.reserve(places);
    double sum = 0;
    for (std::size_t i = 0; i < faces.size() && chosen.size() < places; ++i) {
        sum += areas[i];
        while (chosen.size() < places &&
               sum * static_cast<double>(places) > (static_cast<double>(chosen.size()) + 0.5) * total)
            chosen.push_back(faces[i]);
    }
    Box box = empty_box;
    bool are_floats = true;
    for (const std::uint32_t face : chosen)
        for (const std::uint32_t vertex : triangles[face]) {
            const Vec3& at = mesh.vertices()[vertex];
            add(box, {at, at});
            are_floats = are_floats && std::ranges::all_of(at, is_float);
        }
    double largest = 0;
    for (std::size_t axis = 0; axis < 3; ++axis)
        largest = std::max({largest, std::abs(box.lower[axis]), std::abs(box.upper[axis])});
    const double rounding = are_floats ? 0x1p-24 : 0x1p-52;
    const double away = std::max(0x1p-19 * half_of_longest(box), 8 * rounding * largest);
    std::vector<Vec3> points;
    points.reserve(2 * chosen.size());
    for (std::size_t k = 0; k < chosen.size(); ++k) {
        const Triangle& triangle = triangles[chosen[k]];
        double u = halton(k + 1, 2), v = halton(k + 1, 3);
        if (u + v > 1) {
            u = 1 - u;
            v = 1 - v;
        }
        const Vec3 normal = frame.normal(triangle);
        const double scale = away / length_of(normal);
        if (!std::isfinite(scale)) continue;
        Vec3 above{}, below{};
        for (std::size_t axis = 0; axis < 3; ++axis) {
            const double at = (1 - u - v) * mesh.vertices()[triangle[0]][axis] +
                              u * mesh.vertices()[triangle[1]][axis] + v * mesh.vertices()[triangle[2]][axis];
            above[axis] = at + scale * normal[axis];
            below[axis] = at - scale * normal[axis];
        }
        points.push_back(above);
        points.push_back(below);
    }
    return points;
}

void WindingTally::add(std::span<const SeenWinding> seen) {
    tested += seen.size();
    for (const SeenWinding& one : seen) {
        doubtful += one.is_in_doubt() ? 1U : 0U;
        inside += one.is_inside() ? 1U : 0U;
        doubtful_inside += one.is_inside() && one.is_in_doubt() ? 1U : 0U;
        sum += one.rounded;
    }
}

namespace {

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
            if (may_be_covered) take_covered();
            if (unclear_.size() < parts_.size() && are_flat_and_harmless()) unclear_.clear();
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

    /// Adds points in a part's holes: on a fan around the middle of each loop of open edges.
    void add_holes(const TestedPart& part, std::vector<Vec3>& points) const {
        std::vector<std::uint32_t> vertices;
        for (const std::uint32_t face : part.faces)
            vertices.insert(vertices.end(), triangles_[face].begin(), triangles_[face].end());
        std::ranges::sort(vertices);
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
