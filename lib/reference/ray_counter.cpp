#include "ray_counter.hpp"

#include "exact_geometry.hpp"

#include <algorithm>

namespace clsdf::reference {

namespace {

Corners corners_of(const Mesh& mesh, std::uint32_t index) {
    const Triangle& triangle = mesh.triangles()[index];
    return {mesh.vertices()[triangle[0]], mesh.vertices()[triangle[1]], mesh.vertices()[triangle[2]]};
}

/// The points of the row that lie on a triangle parallel to the row.
void mark_points_on(const Corners& triangle, std::span<const double> x, double y, double z,
                    std::vector<char>& on_surface) {
    const auto [lower, upper] = std::minmax({triangle[0][0], triangle[1][0], triangle[2][0]});
    const auto first = std::lower_bound(x.begin(), x.end(), lower) - x.begin();
    const auto last = std::upper_bound(x.begin(), x.end(), upper) - x.begin();
    for (auto i = static_cast<std::size_t>(first); i < static_cast<std::size_t>(last); ++i) {
        if (!on_surface[i] && lies_on(triangle, {x[i], y, z})) {
            on_surface[i] = 1;
        }
    }
}

}  // namespace

std::vector<std::optional<RayCount>> RayCounter::count_along_row(std::span<const double> x, double y, double z) const {
    std::vector<std::optional<RayCount>> counts(x.size());
    if (x.empty()) {
        return counts;
    }
    std::vector<std::uint32_t> candidates;
    tree_.meet_ray(x.front(), y, z, candidates);

    // ends_at[i]: crossings whose last point before the plane is i - 1; summed from the end of the row.
    std::vector<RayCount> ends_at(x.size() + 1);
    std::vector<char> on_surface(x.size(), 0);
    for (const std::uint32_t index : candidates) {
        const Corners triangle = corners_of(tree_.mesh(), index);
        const LineMeeting meeting = meet_line(triangle, y, z);
        if (!meeting.touches) {
            continue;
        }
        if (meeting.facing == 0) {
            mark_points_on(triangle, x, y, z, on_surface);
            continue;
        }
        const auto side = [&](double at) { return side_along_x(triangle, meeting.facing, {at, y, z}); };
        const auto plane = std::partition_point(x.begin(), x.end(), [&](double at) { return side(at) < 0; });
        for (auto at = plane; at != x.end() && side(*at) == 0; ++at) {
            on_surface[static_cast<std::size_t>(at - x.begin())] = 1;
        }
        if (meeting.crossing != 0) {
            RayCount& end = ends_at[static_cast<std::size_t>(plane - x.begin())];
            end.winding += meeting.crossing;
            end.crossings += 1;
        }
    }
    RayCount count;
    for (std::size_t i = x.size(); i-- > 0;) {
        count.winding += ends_at[i + 1].winding;
        count.crossings += ends_at[i + 1].crossings;
        if (!on_surface[i]) {
            counts[i] = count;
        }
    }
    return counts;
}

}  // namespace clsdf::reference
