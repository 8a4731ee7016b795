#include "picture/upright.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <vector>

namespace clsdf::picture {
namespace {

constexpr double lowest_part = 0.05;  // of the height, on which a solid stands
constexpr double firm = 0.05;         // as firmness() measures it
constexpr double difference = 0.05;   // less may come from the samples

using Point = std::array<double, 2>;

double turn(const Point& a, const Point& b, const Point& c) {
    return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
}

/// Counter-clockwise, without points on its sides (Andrew's monotone chain).
std::vector<Point> convex_hull(std::vector<Point> points) {
    std::ranges::sort(points);
    points.erase(std::ranges::unique(points).begin(), points.end());
    if (points.size() < 3) return points;
    std::vector<Point> hull;
    const auto add = [&](const Point& point, std::size_t least) {
        while (hull.size() > least && turn(hull[hull.size() - 2], hull.back(), point) <= 0) hull.pop_back();
        hull.push_back(point);
    };
    for (const Point& point : points) add(point, 1);
    const std::size_t lower = hull.size();
    for (std::size_t i = points.size() - 1; i-- > 0;) add(points[i], lower);
    hull.pop_back();
    return hull;
}

double area(const std::vector<Point>& hull) {
    double sum = 0;
    for (std::size_t i = 2; i < hull.size(); ++i) sum += turn(hull[0], hull[i - 1], hull[i]);
    return sum / 2;
}

/// The distance to the nearest side; negative outside.
double depth_in(const std::vector<Point>& hull, const Point& point) {
    double least = std::numeric_limits<double>::infinity();
    for (std::size_t i = 0; i < hull.size(); ++i) {
        const Point& a = hull[i];
        const Point& b = hull[(i + 1) % hull.size()];
        least = std::min(least, turn(a, b, point) / std::hypot(b[0] - a[0], b[1] - a[1]));
    }
    return least;
}

Vec3 centre_of_mass(std::span<const Vec3> row_ends, double spacing) {
    Vec3 sum{};
    double mass = 0;
    for (std::size_t i = 0; i + 1 < row_ends.size(); i += 2) {
        const double length = row_ends[i + 1][0] - row_ends[i][0] + spacing;
        mass += length;
        for (std::size_t axis = 0; axis < 3; ++axis)
            sum[axis] += 0.5 * length * (row_ends[i][axis] + row_ends[i + 1][axis]);
    }
    for (double& part : sum) part /= mass;
    return sum;
}

/// How far within the hull of its lowest part the centre of mass lies, as a part of the square root of the area that
/// the solid covers, seen from above; negative if the solid would fall over.
double firmness(std::span<const Vec3> points, const Vec3& centre, std::size_t up, double spacing) {
    const std::size_t right = (up + 1) % 3;
    const std::size_t front = (up + 2) % 3;
    double lowest = std::numeric_limits<double>::infinity();
    double highest = -lowest;
    for (const Vec3& point : points) {
        lowest = std::min(lowest, point[up]);
        highest = std::max(highest, point[up]);
    }
    // A flat base counts with two layers of samples: the lowest one is what the grid happens to hit.
    const double limit = lowest + std::max(lowest_part * (highest - lowest), 1.5 * spacing);
    std::vector<Point> all;
    std::vector<Point> footing;
    for (const Vec3& point : points) {
        all.push_back({point[right], point[front]});
        if (point[up] <= limit) footing.push_back(all.back());
    }
    const std::vector<Point> hull = convex_hull(footing);
    const double covered = area(convex_hull(all));
    if (hull.size() < 3 || !(covered > 0)) return -1;
    return depth_in(hull, {centre[right], centre[front]}) / std::sqrt(covered);
}

}  // namespace

Axis upright_axis(std::span<const Vec3> row_ends, const Vec3& spacing) {
    const Vec3 centre = centre_of_mass(row_ends, spacing[0]);
    const double along_y = firmness(row_ends, centre, 1, spacing[1]);
    const double along_z = firmness(row_ends, centre, 2, spacing[2]);
    if (along_z > firm) return along_y > along_z + difference ? Axis::y : Axis::z;
    return Axis::y;
}

}  // namespace clsdf::picture
