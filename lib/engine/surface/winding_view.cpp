#include "surface/winding_view.hpp"

#include "core/parallel.hpp"
#include "mesh/box_index.hpp"
#include "surface/film_tree.hpp"
#include "surface/local_frame.hpp"
#include "surface/ray_crossings.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <utility>

namespace clsdf {

namespace {

// With more corners of open edges, a tree of them costs less than all of them.
constexpr std::size_t many_corners = 2048;

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
                const FilmTree::View view = film_->look_by_tenths(points[i]);
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

}  // namespace clsdf
