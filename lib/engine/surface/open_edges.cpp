#include "surface/open_edges.hpp"

#include "core/parallel.hpp"
#include "surface/loop_turns.hpp"
#include "surface/ray_side.hpp"

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <utility>

namespace clsdf {

namespace {

/// Walks along edges and cuts off each loop that the path closes.
class LoopWalk {
public:
    explicit LoopWalk(std::vector<OpenEdge> edges) : edges_(std::move(edges)) {
        std::ranges::sort(edges_, {}, [](const OpenEdge& edge) { return std::pair(edge.from, edge.to); });
        for (const OpenEdge& edge : edges_) {
            if (vertices_.empty() || vertices_.back() != edge.from) {
                vertices_.push_back(edge.from);
                next_.push_back(static_cast<std::size_t>(&edge - edges_.data()));
            }
        }
        place_on_path_.assign(vertices_.size(), none);
    }

    OpenLoops loops() {
        for (std::size_t start = 0; start < vertices_.size(); ++start)
            while (has_edge(start)) walk(start);
        return std::move(loops_);
    }

private:
    static constexpr std::size_t none = ~std::size_t{0};

    bool has_edge(std::size_t vertex) {
        std::size_t& edge = next_[vertex];
        while (edge < edges_.size() && edges_[edge].from == vertices_[vertex] && edges_[edge].count == 0) ++edge;
        return edge < edges_.size() && edges_[edge].from == vertices_[vertex];
    }

    std::size_t place_of(std::uint32_t vertex) const {
        return static_cast<std::size_t>(std::ranges::lower_bound(vertices_, vertex) - vertices_.begin());
    }

    /// Until the path is back at its start, with nothing left of it.
    void walk(std::size_t start) {
        std::vector<std::size_t> path{start};
        place_on_path_[start] = 0;
        // As many edges end at a vertex as begin there: the walk ends at its start only.
        while (has_edge(path.back())) {
            OpenEdge& edge = edges_[next_[path.back()]];
            --edge.count;
            const std::size_t to = place_of(edge.to);
            if (place_on_path_[to] == none) {
                place_on_path_[to] = path.size();
                path.push_back(to);
                continue;
            }
            const std::size_t begin = place_on_path_[to];
            for (std::size_t i = begin; i < path.size(); ++i) {
                loops_.vertices.push_back(vertices_[path[i]]);
                if (i > begin) place_on_path_[path[i]] = none;
            }
            loops_.begins.push_back(loops_.vertices.size());
            path.resize(begin + 1);
            if (begin == 0) break;
        }
        place_on_path_[start] = none;
    }

    std::vector<OpenEdge> edges_;
    std::vector<std::uint32_t> vertices_;     // at which edges begin, ascending
    std::vector<std::size_t> next_;           // of each of them, the first of its edges that may be left
    std::vector<std::size_t> place_on_path_;  // of each of them
    OpenLoops loops_;
};

}  // namespace

OpenLoops loops_of(std::vector<OpenEdge> edges) {
    return LoopWalk(std::move(edges)).loops();
}

OpenBoundary::OpenBoundary(const OpenLoops& loops, std::span<const Vec3> positions)
    : corners(loops.vertices.size()), begins(loops.begins) {
    for (std::size_t i = 0; i < corners.size(); ++i) corners[i] = positions[loops.vertices[i]];
}

SolidAngle angle_of(const OpenBoundary& boundary, const Vec3& point, double unit) {
    Turns turns = no_turns();
    for (std::size_t loop = 0; loop + 1 < boundary.begins.size(); ++loop) {
        const std::size_t begin = boundary.begins[loop];
        turns = turned_by_loop(
            turns, boundary.begins[loop + 1] - begin,
            [&](std::size_t i) -> const Vec3& { return boundary.corners[begin + i]; }, point, unit);
    }
    return {rounded_turns(turns), turns_of(turns)};
}

namespace {

constexpr std::size_t tested_points = 512;
// The winding number is in doubt if it is farther from an integer.
constexpr double least_doubt = 0.1;
// With more corners of open edges, a sum over them at all points takes seconds.
constexpr std::size_t many_corners = 100'000;

double halton(std::size_t number, std::size_t base) {
    double digit = 1, result = 0;
    for (; number > 0; number /= base) {
        digit /= static_cast<double>(base);
        result += digit * static_cast<double>(number % base);
    }
    return result;
}

std::vector<Vec3> points_of(const Box& box) {
    constexpr std::array<std::size_t, 3> bases{2, 3, 5};
    std::vector<Vec3> points(tested_points);
    for (std::size_t i = 0; i < points.size(); ++i)
        for (std::size_t axis = 0; axis < 3; ++axis) {
            const double share = halton(i + 1, bases[axis]);
            points[i][axis] = box.lower[axis] * (1 - share) + box.upper[axis] * share;
        }
    std::ranges::sort(points, {}, [](const Vec3& point) { return point[1]; });
    return points;
}

/// The crossings of the points' rays towards -x with the triangles. The points ascend in y.
class RayCrossings {
public:
    RayCrossings(const Mesh& mesh, std::span<const Vec3> points)
        : mesh_(mesh), points_(points), counts_(points.size()) {
        const Box& box = mesh.box();
        const double height = box.upper[1] / 2 - box.lower[1] / 2;
        lower_ = box.lower[1] / 2;
        per_height_ = height > 0 ? static_cast<double>(bins) / height : 0;
        if (!std::isfinite(per_height_)) per_height_ = 0;
        std::size_t point = 0;
        for (std::size_t bin = 0; bin < bins; ++bin) {
            while (point < points.size() && bin_of(points[point][1]) < bin) ++point;
            first_of_bin_[bin] = point;
        }
    }

    void add(std::span<const Triangle> triangles) {
        for_each_range(
            triangles.size(),
            [&](std::size_t begin, std::size_t end) {
                for (std::size_t t = begin; t != end; ++t) add(triangles[t]);
            },
            4096);
    }

    std::span<const int> counts() const { return counts_; }

private:
    static constexpr std::size_t bins = 1024;

    /// Ascends with y.
    std::size_t bin_of(double y) const {
        const double bin = (y / 2 - lower_) * per_height_;
        return bin > 0 ? std::min(static_cast<std::size_t>(std::min(bin, 1e9)), bins - 1) : 0;
    }

    void add(const Triangle& triangle) {
        const Vec3 &a = mesh_.vertices()[triangle[0]], &b = mesh_.vertices()[triangle[1]],
                   &c = mesh_.vertices()[triangle[2]];
        const double low_y = std::min({a[1], b[1], c[1]}), high_y = std::max({a[1], b[1], c[1]});
        std::size_t i = first_of_bin_[bin_of(low_y)];
        for (; i < points_.size() && points_[i][1] <= high_y; ++i) {
            const Vec3& p = points_[i];
            if (p[1] < low_y || p[2] < std::min({a[2], b[2], c[2]}) || p[2] > std::max({a[2], b[2], c[2]}) ||
                p[0] < std::min({a[0], b[0], c[0]}))
                continue;
            const int side = side_of_edges(a, b, c, p);
            if (side == 0 || orientation(a, b, c, p) != side) continue;  // the crossing has a greater x
            std::atomic_ref(counts_[i]).fetch_sub(side, std::memory_order_relaxed);
        }
    }

    const Mesh& mesh_;
    std::span<const Vec3> points_;
    std::vector<int> counts_;
    double lower_ = 0, per_height_ = 0;
    std::array<std::size_t, bins> first_of_bin_{};
};

}  // namespace

void test_winding_number(const Mesh& mesh, std::span<const Triangle> triangles, const OpenLoops& loops,
                         Topology& report) {
    const std::vector<Vec3> points = points_of(mesh.box());
    RayCrossings crossings(mesh, points);
    crossings.add(triangles);
    const OpenBoundary boundary(loops, mesh.vertices());
    double longest = 0;
    for (std::size_t axis = 0; axis < 3; ++axis)
        longest = std::max(longest, mesh.box().upper[axis] / 2 - mesh.box().lower[axis] / 2);
    const double unit = std::ldexp(1.0, std::clamp(longest > 0 ? std::ilogb(longest) : 0, -1000, 1000));
    report.tested_points = report.doubtful_points = report.inside_points = 0;
    long long sum = 0;
    // Of very many open edges only so many points as it takes to see that there is too much doubt. The points of a part
    // are spread over the box.
    const std::size_t parts = boundary.corners.size() > many_corners ? 8 : 1;
    for (std::size_t part = 0; part < parts && 10 * report.doubtful_points <= points.size(); ++part) {
        std::vector<SolidAngle> angles(points.size() / parts);
        for_each_index(
            angles.size(), [&](std::size_t i) { angles[i] = angle_of(boundary, points[i * parts + part], unit); }, 8);
        for (std::size_t i = 0; i < angles.size(); ++i) {
            const int rounded = crossings.counts()[i * parts + part] + angles[i].rounded;
            const double turns = angles[i].turns;
            if (std::abs(turns - std::nearbyint(turns)) > least_doubt) ++report.doubtful_points;
            if (rounded != 0) ++report.inside_points;
            sum += rounded;
        }
        report.tested_points += angles.size();
    }
    report.inside_out = sum < 0;
}

bool has_clear_winding_number(const Topology& topology) {
    return topology.inside_points > 0 && 10 * topology.doubtful_points <= topology.tested_points;
}

}  // namespace clsdf
