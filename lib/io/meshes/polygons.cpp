#include "io/meshes/polygons.hpp"

#include "mesh/predicates.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <utility>

namespace clsdf {

namespace {

using Position = std::array<double, 2>;
using Corners = std::vector<std::uint32_t>;

/// Cuts ears off a polygon whose corners run counterclockwise.
class EarCutter {
public:
    explicit EarCutter(std::vector<Position> positions)
        : at_(std::move(positions)), previous_(at_.size()), next_(at_.size()), is_no_ear_(at_.size(), false) {
        for (std::size_t i = 0; i < at_.size(); ++i) {
            next_[i] = (i + 1) % at_.size();
            previous_[next_[i]] = i;
        }
    }

    /// The numbers of the corners of each triangle; null if the polygon has no such triangles. An ear test takes time
    /// in proportion to the corners, and their number is limited in proportion to the corners, too.
    std::optional<std::vector<std::array<std::size_t, 3>>> triangles() {
        constexpr std::size_t tests_per_corner = 16;
        std::vector<std::array<std::size_t, 3>> found;
        std::size_t left = at_.size(), tests = tests_per_corner * left, rejected = 0;
        Cut wanted = Cut::spikes;
        for (std::size_t corner = 1; left > 2; corner = next_[corner]) {
            const bool is_cut = wanted == Cut::spikes ? is_spike(corner)
                                : wanted == Cut::ears ? !is_no_ear_[corner] && is_ear(corner, tests)
                                                      : turn(corner) == 0;
            if (is_cut) {
                found.push_back({previous_[corner], corner, next_[corner]});
                cut(corner);
                --left;
                rejected = 0;
                if (wanted != Cut::flat) continue;
                // It may have lain on the third side of an ear.
                is_no_ear_.assign(at_.size(), false);
                wanted = Cut::ears;
            } else if (++rejected == left) {
                if (wanted == Cut::flat || tests == 0) return std::nullopt;
                rejected = 0;
                wanted = wanted == Cut::spikes ? Cut::ears : Cut::flat;
            } else if (wanted == Cut::ears) {
                is_no_ear_[corner] = true;
            }
        }
        return found;
    }

private:
    /// Spikes come first: the triangle at a spike's foot may lie outside of the polygon. A flat corner is cut only if
    /// no corner is an ear.
    enum class Cut { spikes, ears, flat };

    int turn(std::size_t corner) const { return orientation(at_[previous_[corner]], at_[corner], at_[next_[corner]]); }

    /// Whether the edges lie on one another, or one has no length.
    bool is_spike(std::size_t corner) const {
        const Position &a = at_[previous_[corner]], &b = at_[corner], &c = at_[next_[corner]];
        return turn(corner) == 0 && (a[0] - b[0]) * (c[0] - b[0]) + (a[1] - b[1]) * (c[1] - b[1]) >= 0;
    }

    void cut(std::size_t corner) {
        next_[previous_[corner]] = next_[corner];
        previous_[next_[corner]] = previous_[corner];
        is_no_ear_[previous_[corner]] = is_no_ear_[next_[corner]] = false;
    }

    /// Whether the triangle of the corner and its neighbours lies in the polygon.
    bool is_ear(std::size_t corner, std::size_t& tests) const {
        if (tests == 0 || turn(corner) <= 0) return false;
        --tests;
        const std::size_t last = previous_[corner];
        const Position &a = at_[last], &b = at_[corner], &c = at_[next_[corner]];
        const auto [left, right] = std::minmax({a[0], b[0], c[0]});
        const auto [bottom, top] = std::minmax({a[1], b[1], c[1]});
        for (std::size_t i = next_[next_[corner]]; i != last; i = next_[i]) {
            const Position &p = at_[i], &q = at_[next_[i]];
            if (std::max(p[0], q[0]) < left || std::min(p[0], q[0]) > right || std::max(p[1], q[1]) < bottom ||
                std::min(p[1], q[1]) > top)
                continue;
            // The third side is no diagonal if a corner lies on it or behind it, or if an edge crosses it.
            const int side = orientation(c, a, p);
            if (side >= 0 && p != a && p != c && orientation(a, b, p) > 0 && orientation(b, c, p) > 0) return false;
            if (side * orientation(c, a, q) < 0 && orientation(p, q, a) * orientation(p, q, c) < 0) return false;
        }
        return true;
    }

    std::vector<Position> at_;
    std::vector<std::size_t> previous_, next_;
    std::vector<bool> is_no_ear_;  ///< was tested since one of its neighbours changed
};

/// Sets the normals of a fan's triangles, as long as twice their areas in units of the square of the polygon's extent.
void set_normals_of_fan(std::span<const Vec3> vertices, const Corners& corners, std::vector<Vec3>& normals) {
    const Vec3& origin = vertices[corners[0]];
    double extent = 0;
    for (const std::uint32_t corner : corners)
        for (std::size_t axis = 0; axis < 3; ++axis)
            extent = std::max(extent, std::abs(vertices[corner][axis] - origin[axis]));
    normals.clear();
    Vec3 before{};
    for (std::size_t k = 1; k < corners.size(); ++k) {
        Vec3 spoke;
        for (std::size_t axis = 0; axis < 3; ++axis) spoke[axis] = (vertices[corners[k]][axis] - origin[axis]) / extent;
        if (k > 1)
            normals.push_back({before[1] * spoke[2] - before[2] * spoke[1], before[2] * spoke[0] - before[0] * spoke[2],
                               before[0] * spoke[1] - before[1] * spoke[0]});
        before = spoke;
    }
}

/// The axis along which the polygon is looked at, and whether its corners run clockwise then. Null if the fan shall
/// stay: it is right, or the polygon has no normal. `normals` is memory for many calls.
std::optional<std::pair<std::size_t, bool>> view_of_ears(std::span<const Vec3> vertices, const Corners& corners,
                                                         std::vector<Vec3>& normals) {
    set_normals_of_fan(vertices, corners, normals);
    Vec3 sum{};
    for (const Vec3& normal : normals)
        for (std::size_t axis = 0; axis < 3; ++axis) sum[axis] += normal[axis];
    const bool is_right = std::ranges::all_of(
        normals, [&](const Vec3& normal) { return normal[0] * sum[0] + normal[1] * sum[1] + normal[2] * sum[2] >= 0; });
    // A coordinate that is not finite is refused later.
    if (is_right || !is_finite(sum)) return std::nullopt;
    std::size_t axis = 0;
    for (std::size_t other = 1; other < 3; ++other)
        if (std::abs(sum[other]) > std::abs(sum[axis])) axis = other;
    return std::pair(axis, sum[axis] < 0);
}

}  // namespace

void Polygons::add(MeshArrays& mesh, std::span<const std::uint32_t> corners) {
    if (corners.size() > 3) fans_.push_back({mesh.triangles.size(), corners.size() - 2});
    mesh.add_polygon(corners);
}

void Polygons::triangulate(MeshArrays& mesh) const {
    Corners corners;
    std::vector<Vec3> normals;
    for (const Fan& fan : fans_) {
        const auto triangles = std::span(mesh.triangles).subspan(fan.first_triangle, fan.triangles);
        corners.assign({triangles[0][0], triangles[0][1]});
        for (const Triangle& triangle : triangles) corners.push_back(triangle[2]);
        const auto view = view_of_ears(mesh.vertices, corners, normals);
        if (!view) continue;
        const auto [axis, is_clockwise] = *view;
        std::vector<Position> positions;
        for (const std::uint32_t corner : corners) {
            const Vec3& vertex = mesh.vertices[corner];
            Position position{vertex[(axis + 1) % 3], vertex[(axis + 2) % 3]};
            if (is_clockwise) std::swap(position[0], position[1]);
            positions.push_back(position);
        }
        const auto ears = EarCutter(std::move(positions)).triangles();
        if (!ears) continue;
        std::ranges::transform(*ears, triangles.begin(), [&](const std::array<std::size_t, 3>& ear) -> Triangle {
            return {corners[ear[0]], corners[ear[1]], corners[ear[2]]};
        });
    }
}

}  // namespace clsdf
