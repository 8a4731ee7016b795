#include "cutting/sections.hpp"

namespace clsdf::cutting {

namespace {

/// Shortens a segment to a cell; its ends keep their order.
bool cut(Vec3& p, Vec3& q, std::size_t axis, double cell) {
    const Vec3 from = p, to = q;
    if ((from[axis] < cell && to[axis] < cell) || (from[axis] >= cell + 1 && to[axis] >= cell + 1)) return false;
    const auto is_in = [&](const Vec3& point) { return point[axis] >= cell && point[axis] < cell + 1; };
    if (!is_in(from)) p = point_at(from, to, axis, from[axis] < cell ? cell : cell + 1);
    if (!is_in(to)) q = point_at(from, to, axis, to[axis] < cell ? cell : cell + 1);
    return true;
}

}  // namespace

void Sections::reset(const std::array<std::int64_t, 3>& first, const std::array<std::int64_t, 3>& counts,
                     std::int64_t planes) {
    first_ = first;
    counts_ = counts;
    planes_ = planes;
    sums_.reset(static_cast<std::size_t>(planes * counts[side_] * counts[along_]));
    lines_.reset(static_cast<std::size_t>(planes * counts[side_]), first[along_],
                 static_cast<std::size_t>(counts[along_]));
}

void Sections::add(const std::array<Vec3, 3>& corners) {
    const auto [least, most] = std::minmax({corners[0][across_], corners[1][across_], corners[2][across_]});
    const auto low = static_cast<double>(first_[across_]), high = low + static_cast<double>(planes_ - 1);
    const double from = std::max(low, std::ceil(least)), to = std::min(high, std::floor(most));
    for (double plane = from; plane <= to; ++plane) add(corners, plane);
}

void Sections::add(const std::array<std::int64_t, 3>& cell_from_first, double area, double first, double second) {
    FaceSums& sums = sums_.make(cell(cell_from_first[across_], cell_from_first[side_], cell_from_first[along_]));
    sums.area.add(area);
    sums.first.add(first);
    sums.second.add(second);
}

std::array<double, 3> Sections::at(std::int64_t plane, std::int64_t side, std::int64_t along) const {
    const FaceSums* const sums = sums_.find(cell(plane, side, along));
    const std::size_t high = line(plane, side);
    const auto k = static_cast<std::size_t>(along);
    const double length = lines_.length(high, k);
    std::array<double, 3> found{length, length / 2, lines_.moment(high, k)};  // the side's coordinate is 1 there
    if (sums != nullptr) {
        found[0] += sums->area.value();
        found[1] += sums->first.value();
        found[2] += sums->second.value();
    }
    return found;
}

void Sections::add(const std::array<Vec3, 3>& corners, double plane) {
    std::array<bool, 3> are_above{};
    for (std::size_t i = 0; i < 3; ++i) are_above[i] = corners[i][across_] >= plane;
    if (are_above[0] == are_above[1] && are_above[1] == are_above[2]) return;
    // Seen from above, the solid is on the left of the way from one to the other.
    Vec3 down{}, up{};
    for (std::size_t i = 0; i < 3; ++i)
        if (const std::size_t next = (i + 1) % 3; are_above[i] != are_above[next])
            (are_above[i] ? down : up) = point_at(corners[i], corners[next], across_, plane);
    if (orientation_ < 0) std::swap(down, up);
    const auto number = static_cast<std::int64_t>(plane) - first_[across_];
    add_lines(number, down, up);
    const auto range = [&](const Vec3& p, const Vec3& q, std::size_t axis) {
        return CellRange(std::min(p[axis], q[axis]), std::max(p[axis], q[axis]), first_[axis], counts_[axis]);
    };
    const CellRange sides = range(down, up, side_);
    for (std::int64_t i = sides.low; i <= sides.high; ++i) {
        Vec3 p = down, q = up;
        const auto low_side = static_cast<double>(first_[side_] + i);
        if (!cut(p, q, side_, low_side)) continue;
        const CellRange cells = range(p, q, along_);
        for (std::int64_t k = cells.low; k <= cells.high; ++k) {
            Vec3 from = p, to = q;
            const auto low = static_cast<double>(first_[along_] + k);
            if (!cut(from, to, along_, low)) continue;
            const double b0 = from[side_] - low_side, b1 = to[side_] - low_side;
            const double c0 = from[along_] - low, c1 = to[along_] - low;
            const double step = to[along_] - from[along_];
            FaceSums& sums = sums_.make(cell(number, i, k));
            sums.area.add((b0 + b1) / 2 * step);
            sums.first.add((b0 * b0 + b0 * b1 + b1 * b1) / 6 * step);
            sums.second.add((2 * (b0 * c0 + b1 * c1) + b0 * c1 + b1 * c0) / 6 * step);
        }
    }
}

void Sections::add_lines(std::int64_t plane, const Vec3& down, const Vec3& up) {
    const auto [least, most] = std::minmax(down[side_], up[side_]);
    const auto low = static_cast<double>(first_[side_]), high = low + static_cast<double>(counts_[side_]);
    const double from = std::max(low + 1, std::ceil(least)), to = std::min(high, std::floor(most));
    for (double at = from; at <= to; ++at) {
        const bool is_up = up[side_] >= at;
        if ((down[side_] >= at) == is_up) continue;
        const std::int64_t side = static_cast<std::int64_t>(at) - first_[side_] - 1;
        lines_.add(line(plane, side), point_at(down, up, side_, at)[along_], is_up ? 1 : -1);
    }
}

}  // namespace clsdf::cutting
