#include "sign/film.hpp"

#include "core/parallel.hpp"
#include "sign/turns_of_lanes.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

namespace clsdf::engine {

namespace {

/// The first row at or above a snapped coordinate.
std::int64_t row_from(std::int64_t snapped, int bits) {
    return -(-snapped >> bits);
}

/// Rows (y, z) of a part.
struct PartRows {
    std::int64_t first_x, end_x;  ///< samples, counted as the boundary's
    std::int64_t first_y, end_y, first_z, end_z;

    std::size_t size_y() const { return static_cast<std::size_t>(end_y - first_y); }
    std::size_t size_z() const { return static_cast<std::size_t>(end_z - first_z); }
    std::uint32_t number(std::int64_t y, std::int64_t z) const {
        return static_cast<std::uint32_t>((z - first_z) * (end_y - first_y) + (y - first_y));
    }
};

PartRows rows_of(const Layout& layout, std::int32_t first_x) {
    std::array<std::int64_t, 3> first{}, end{};
    for (std::size_t axis = 0; axis < 3; ++axis) {
        first[axis] = std::int64_t{layout.brick_first[axis]} * CLSDF_BRICK;
        end[axis] = first[axis] + std::int64_t{layout.bricks[axis]} * CLSDF_BRICK;
    }
    return {first[0] - first_x, end[0] - first_x, first[1], end[1], first[2], end[2]};
}

/// The crossings of the walls by rows [begin, end) in y, of all z.
class Strip {
public:
    Strip(const LatticeBoundary& boundary, const PartRows& rows, std::int64_t begin, std::int64_t end,
          FilmCrossings& crossings, std::vector<SweepRecord>& records)
        : boundary_(boundary), rows_(rows), begin_(begin), end_(end), crossings_(crossings), records_(records) {}

    void find() {
        for (std::size_t loop = 0; loop + 1 < boundary_.begins.size(); ++loop) {
            const std::size_t begin = boundary_.begins[loop], end = boundary_.begins[loop + 1];
            for (std::size_t i = begin; i < end; ++i)
                cross(boundary_.corners[i].snapped, boundary_.corners[i + 1 < end ? i + 1 : begin].snapped);
        }
    }

private:
    /// Of the wall below an edge, whose faces lie left of it, seen from above. A row counts as displaced in y and z.
    void cross(const SweepVertex& a, const SweepVertex& b) {
        const auto [low, high] = std::minmax(a.y, b.y);
        const std::int64_t begin = std::max(begin_, row_from(low, boundary_.bits_y)),
                           end = std::min(end_, row_from(high, boundary_.bits_y));
        const std::int64_t begin_z = std::max(rows_.first_z, row_from(*boundary_.floor, boundary_.bits_z)),
                           end_z = std::min(rows_.end_z, (std::max(a.z, b.z) >> boundary_.bits_z) + 1),
                           beside_z = std::min(a.z, b.z);  // lower rows are below the edge
        const int direction = b.y > a.y ? 1 : -1;
        for (std::int64_t y = begin; y < end; ++y) {
            const std::int64_t at_y = y * (std::int64_t{1} << boundary_.bits_y);
            const double of_a = static_cast<double>(b.y - at_y), of_b = static_cast<double>(at_y - a.y);
            const double x = (of_a * a.x + of_b * b.x) / (of_a + of_b);
            const double limited = std::clamp(x, static_cast<double>(rows_.first_x), static_cast<double>(rows_.end_x));
            const auto sample =
                static_cast<std::uint32_t>(static_cast<std::int64_t>(std::ceil(limited)) - rows_.first_x);
            for (std::int64_t z = begin_z; z < end_z; ++z) {
                const std::int64_t at_z = z * (std::int64_t{1} << boundary_.bits_z);
                if (at_z >= beside_z && side_of(a, b, at_y, at_z) == direction) break;
                const std::uint32_t number = rows_.number(y, z);
                records_.push_back({number, 2 * sample + (direction < 0 ? 1U : 0U), crossings_.row_counts[number]++});
            }
        }
    }

    const LatticeBoundary& boundary_;
    const PartRows& rows_;
    std::int64_t begin_, end_;
    FilmCrossings& crossings_;
    std::vector<SweepRecord>& records_;
};

}  // namespace

FilmCrossings wall_crossings(const LatticeBoundary& boundary, const Layout& layout,
                             const std::function<void()>& between) {
    FilmCrossings crossings;
    const PartRows rows = rows_of(layout, boundary.first_x);
    crossings.row_counts.resize(rows.size_y() * rows.size_z());
    constexpr std::size_t strip = 32, at_once = 64;
    const std::size_t strips = chunk_count(rows.size_y(), strip);
    for (std::size_t begin = 0; begin < strips; begin += at_once) {
        if (between) between();
        std::vector<std::vector<SweepRecord>> records(std::min(at_once, strips - begin));
        for_each_index(
            records.size(),
            [&](std::size_t i) {
                const std::int64_t first = rows.first_y + static_cast<std::int64_t>((begin + i) * strip);
                Strip(boundary, rows, first, std::min(first + static_cast<std::int64_t>(strip), rows.end_y), crossings,
                      records[i])
                    .find();
            },
            1);
        for (const auto& some : records) crossings.records.insert(crossings.records.end(), some.begin(), some.end());
    }
    if (crossings.records.empty()) crossings.row_counts.clear();
    return crossings;
}

}  // namespace clsdf::engine
