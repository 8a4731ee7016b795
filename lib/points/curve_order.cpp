#include "points/curve_order.hpp"

#include "core/bucket_sort.hpp"
#include "core/parallel.hpp"
#include "frusta/frames.hpp"
#include "hilbert_curve.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <array>
#include <limits>
#include <vector>

namespace clsdf::points {

namespace {

constexpr unsigned cell_bits = CLSDF_CURVE_BITS;
constexpr std::size_t together = std::size_t{1} << 14;  // points that one thread measures

/// The box of the points, cut off at another one.
Box box_within(std::span<const Vec3> points, const Box& most) {
    const std::size_t ranges = chunk_count(points.size(), together);
    std::vector<Eigen::AlignedBox3d> boxes(ranges);
    for_each_chunk(points.size(), together, [&](std::size_t range, std::size_t begin, std::size_t end) {
        Eigen::AlignedBox3d box;
        for (std::size_t i = begin; i < end; ++i) box.extend(engine::to_vector(points[i]));
        boxes[range] = box;
    });
    for (const Eigen::AlignedBox3d& box : boxes) boxes[0].extend(box);
    Box all;
    for (std::size_t axis = 0; axis < 3; ++axis) {
        const auto at = static_cast<Eigen::Index>(axis);
        all.lower[axis] = std::clamp(boxes[0].min()[at], most.lower[axis], most.upper[axis]);
        all.upper[axis] = std::clamp(boxes[0].max()[at], most.lower[axis], most.upper[axis]);
    }
    return all;
}

}  // namespace

UninitializedVector<std::uint32_t> curve_order(std::span<const Vec3> points, const Box& most) {
    UninitializedVector<std::uint32_t> order(points.size());
    if (points.empty()) return order;
    const Box box = box_within(points, most);
    constexpr double cells = 1U << cell_bits;
    const double longest = box.longest_side();
    constexpr double least = cells / std::numeric_limits<double>::max();
    const double scale = longest > least ? cells / longest : 0;
    UninitializedVector<Coded> coded(points.size()), other(points.size());
    for_each_range(points.size(), [&](std::size_t begin, std::size_t end) {
        constexpr std::size_t at_once = 64;
        std::array<std::array<std::uint32_t, at_once>, 3> cells_of{};
        std::array<std::uint32_t, at_once> keys{};
        for (std::size_t first = begin; first < end; first += at_once) {
            const std::size_t count = std::min(at_once, end - first);
            for (std::size_t i = 0; i < count; ++i)
                for (std::size_t axis = 0; axis < 3; ++axis)
                    cells_of[axis][i] = static_cast<std::uint32_t>(static_cast<std::int32_t>(
                        std::clamp((points[first + i][axis] - box.lower[axis]) * scale, 0.0, cells - 1)));
            for (std::size_t i = 0; i < at_once; ++i)
                keys[i] = place_on_curve(cells_of[0][i], cells_of[1][i], cells_of[2][i]);
            for (std::size_t i = 0; i < count; ++i) coded[first + i] = {keys[i], static_cast<std::uint32_t>(first + i)};
        }
    });
    sort_by_code(coded, other, cell_bits, order);
    return order;
}

}  // namespace clsdf::points
