#include "cutting/sections.hpp"

#include <algorithm>
#include <utility>

namespace clsdf::cutting {

namespace {

/// The lower and the higher cell along an axis in which ends of a segment lie.
std::pair<double, double> cells_of_ends(const CutPoint& p, const CutPoint& q, std::size_t axis) {
    return std::minmax({cell_of(p, static_cast<int>(axis)), cell_of(q, static_cast<int>(axis))});
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

void Sections::add(const std::array<CutPoint, 3>& corners) {
    const auto [least, most] = cells_of_corners(corners, across_);
    const auto low = static_cast<double>(first_[across_]), high = low + static_cast<double>(planes_ - 1);
    const double to = std::min(high, most);
    for (double plane = std::max(low, least + 1); plane <= to; ++plane) add(corners, plane);
}

void Sections::add(const std::array<std::int64_t, 3>& cell_from_first, const CutPiece& piece) {
    FaceSums& sums = sums_.make(cell(cell_from_first[across_], cell_from_first[side_], cell_from_first[along_]));
    add_moved_piece(&sums, &piece, static_cast<int>(across_));
}

FaceValues Sections::at(std::int64_t plane, std::int64_t side, std::int64_t along) const {
    static constexpr FaceSums none{};
    const FaceSums* const sums = sums_.find(cell(plane, side, along));
    const std::size_t high = line(plane, side);
    const auto k = static_cast<std::size_t>(along);
    return values_of_face(lines_.length(high, k), lines_.moment(high, k), sums != nullptr ? sums : &none);
}

void Sections::add(const std::array<CutPoint, 3>& corners, double plane) {
    CutPoint down{}, up{};
    if (!section_of(corners.data(), static_cast<int>(across_), plane, &down, &up)) return;
    const auto number = static_cast<std::int64_t>(plane) - first_[across_];
    add_lines(number, down, up);
    const auto range = [&](const CutPoint& p, const CutPoint& q, std::size_t axis) {
        const auto [least, most] = cells_of_ends(p, q, axis);
        return cells_between(least, most, first_[axis], counts_[axis]);
    };
    const CellRange sides = range(down, up, side_);
    for (std::int64_t i = sides.low; i <= sides.high; ++i) {
        CutPoint p = down, q = up;
        const auto low_side = static_cast<double>(first_[side_] + i);
        if (!cut_segment(&p, &q, static_cast<int>(side_), low_side)) continue;
        const CellRange cells = range(p, q, along_);
        for (std::int64_t k = cells.low; k <= cells.high; ++k) {
            CutPoint from = p, to = q;
            const auto low = static_cast<double>(first_[along_] + k);
            if (cut_segment(&from, &to, static_cast<int>(along_), low))
                add_segment(&sums_.make(cell(number, i, k)), from, to, static_cast<int>(across_), low_side, low);
        }
    }
}

void Sections::add_lines(std::int64_t plane, const CutPoint& down, const CutPoint& up) {
    const auto [least, most] = cells_of_ends(down, up, side_);
    const auto low = static_cast<double>(first_[side_]), high = low + static_cast<double>(counts_[side_]);
    const double to = std::min(high, most);
    for (double at = std::max(low, least) + 1; at <= to; ++at) {
        bool enters = false;
        if (!crosses_line(down, up, static_cast<int>(side_), at, &enters)) continue;
        const std::int64_t side = static_cast<std::int64_t>(at) - first_[side_] - 1;
        lines_.add(line(plane, side), point_at(down, up, static_cast<int>(side_), at), static_cast<int>(along_),
                   enters ? 1 : -1);
    }
}

}  // namespace clsdf::cutting
