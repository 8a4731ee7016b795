#include "segments/walk.hpp"

#include "mesh/predicates.hpp"

#include <cmath>
#include <limits>

namespace clsdf::segments {

namespace {

Vec3 plain(const crossing::double3& v) {
    return {v.x, v.y, v.z};
}

/// -1, 0 or 1, exactly.
int compare(const crossing::Segment& segment, const Crossed& a, const Crossed& b) {
    // Each place is within 0.51 ulp.
    constexpr double rounding = 2 * std::numeric_limits<double>::epsilon();
    const double difference = a.place - b.place, least = rounding * std::max(a.place, b.place);
    if (std::abs(difference) > least) return difference < 0 ? -1 : 1;
    if (a.corners == b.corners) return 0;
    const crossing::ExactVector& along = segment.along;
    return segment.is_ray
               ? compare_places(a.corners, b.corners, plain(segment.from), {along.x.high, along.y.high, along.z.high},
                                Vec3{})
               : compare_places(a.corners, b.corners, plain(segment.from), plain(segment.to), plain(segment.from));
}

}  // namespace

void sort_by_place(const crossing::Segment& segment, std::span<Crossed> crossed) {
    std::ranges::sort(crossed, [&](const Crossed& a, const Crossed& b) {
        const int order = compare(segment, a, b);
        return order != 0 ? order < 0 : a.triangle < b.triangle;
    });
}

std::size_t count_at_first_place(const crossing::Segment& segment, std::span<const Crossed> crossed) {
    std::size_t count = 1;
    while (count < crossed.size() && compare(segment, crossed[0], crossed[count]) == 0) ++count;
    return count;
}

}  // namespace clsdf::segments
