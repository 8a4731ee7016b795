#include "points/curve_order.hpp"

#include "core/parallel.hpp"

#include <tbb/parallel_sort.h>

#include <algorithm>

namespace clsdf::points {

namespace {

constexpr double cells = 1 << 21;

struct Keyed {
    std::uint64_t code;
    std::uint32_t point;

    bool operator<(const Keyed& other) const {
        return code < other.code || (code == other.code && point < other.point);
    }
};

/// The 21 bits of `x`, each followed by two zeros.
std::uint64_t spread(std::uint64_t x) {
    x = (x | x << 32) & 0x001f00000000ffffU;
    x = (x | x << 16) & 0x001f0000ff0000ffU;
    x = (x | x << 8) & 0x100f00f00f00f00fU;
    x = (x | x << 4) & 0x10c30c30c30c30c3U;
    return (x | x << 2) & 0x1249249249249249U;
}

}  // namespace

UninitializedVector<std::uint32_t> curve_order(std::span<const Vec3> points, const Box& box) {
    const double longest = box.longest_side();
    const double scale = longest > 0 ? cells / longest : 0;
    UninitializedVector<Keyed> keyed(points.size());
    for_each_index(points.size(), [&](std::size_t i) {
        std::uint64_t code = 0;
        for (std::size_t axis = 0; axis < 3; ++axis) {
            const double cell = std::clamp((points[i][axis] - box.lower[axis]) * scale, 0.0, cells - 1);
            code |= spread(static_cast<std::uint64_t>(cell)) << axis;
        }
        keyed[i] = {code, static_cast<std::uint32_t>(i)};
    });
    tbb::parallel_sort(keyed.begin(), keyed.end());
    UninitializedVector<std::uint32_t> order(points.size());
    for_each_index(points.size(), [&](std::size_t i) { order[i] = keyed[i].point; });
    return order;
}

}  // namespace clsdf::points
