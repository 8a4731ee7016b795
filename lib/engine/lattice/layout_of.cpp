#include "lattice/layout_of.hpp"

#include "core/refuse.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace clsdf::engine {

namespace {

// Stands for an infinite half width: beyond any distance that a float can hold the square of with room to spare.
constexpr double unbounded_half_width = 1e15;
// How far samples may then lie from sample (0, 0, 0): the mesh may be farthest * sqrt(3) away on the other side.
constexpr double farthest_sample = 8e14;
// Differences of two indices are integers of 32 bits, also from where the coarse bricks that overlap a grid begin.
constexpr std::int64_t index_limit = (std::int64_t{1} << 30) - std::int64_t{4} * CLSDF_COARSE;

std::int64_t floor_divide(std::int64_t a, std::int64_t b) {
    return a / b - (a % b != 0 && (a < 0) != (b < 0) ? 1 : 0);
}

/// The greatest power of two not above the voxel.
double unit_of(const Grid& grid) {
    return std::ldexp(1.0, std::ilogb(grid.voxel()));
}

/// Throws if a length is not in the range of a float, or if spacings differ by more than 1e9.
void check_range(const Grid& grid, const Band& band) {
    constexpr double largest_ratio = 1e9;
    const double longest = *std::max_element(grid.spacing.begin(), grid.spacing.end());
    if (longest > largest_ratio * grid.voxel())
        refuse("the spacings {} and {} differ by more than a factor of 1e9", grid.voxel(), longest);
    constexpr auto smallest = static_cast<double>(std::numeric_limits<float>::min());
    constexpr auto largest = static_cast<double>(std::numeric_limits<float>::max());
    if (unit_of(grid) < smallest || longest > largest)
        refuse("a spacing of {} is beyond the floats that distances are given in; scale the mesh",
               longest > largest ? longest : grid.voxel());
    for (const double half_width : {band.inside, band.outside})
        if (std::isfinite(half_width) && half_width > largest)
            refuse("a half width of {} is beyond the floats that distances are given in; scale the mesh", half_width);
}

/// A float not below the value.
float rounded_up(double value) {
    const auto rounded = static_cast<float>(value);
    return static_cast<double>(rounded) < value ? std::nextafter(rounded, std::numeric_limits<float>::infinity())
                                                : rounded;
}

/// How far samples may lie from sample (0, 0, 0).
double reach_of(const Layout& layout, const Grid& grid) {
    double squared = 0;
    for (std::size_t axis = 0; axis < 3; ++axis) {
        const double first = layout.first[axis], last = first + layout.size[axis] - 1;
        const double length = std::max(std::abs(first), std::abs(last)) * grid.spacing[axis];
        squared += length * length;
    }
    return std::sqrt(squared);
}

float squared_limit(double half_width) {
    return static_cast<float>(half_width * half_width);
}

}  // namespace

void set_part(const Grid& grid, Layout& layout) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
        const std::int64_t first = grid.first[axis];
        const std::int64_t end = first + grid.size[axis];
        if (first < -index_limit || end > index_limit)
            refuse(
                "the grid's samples {} to {} on axis {} lie beyond "
                "2^30 - 128 samples from its origin; move the origin nearer",
                first, end - 1, "xyz"[axis]);
        layout.first[axis] = static_cast<std::int32_t>(first);
        layout.size[axis] = static_cast<std::int32_t>(grid.size[axis]);
        const auto range = [&](std::int64_t block, std::int32_t& begin, std::int32_t& count) {
            begin = static_cast<std::int32_t>(floor_divide(first, block));
            count = static_cast<std::int32_t>(floor_divide(end - 1, block)) - begin + 1;
        };
        range(CLSDF_BRICK, layout.brick_first[axis], layout.bricks[axis]);
        range(CLSDF_COARSE, layout.coarse_first[axis], layout.coarse_bricks[axis]);
    }
    layout.sign_words = (layout.bricks[0] + 3) / 4;
}

Layout bricks_of(const Grid& grid) {
    Layout layout{};
    set_part(grid, layout);
    return layout;
}

Layout layout_of(const Grid& grid, const Band& band, SignRule sign) {
    grid.validate();
    band.validate();
    check_range(grid, band);
    Layout layout = bricks_of(grid);

    const double unit = unit_of(grid);
    const double inside = (sign == SignRule::none ? 0 : band.inside) / unit;
    const double outside = band.outside / unit;
    const double widest = std::max(inside, outside);
    if (std::isfinite(widest) && widest > unbounded_half_width)
        refuse("the band's half width of {} is beyond 1e15 voxels; use an infinite one", band.widest());
    if (const double reach = reach_of(layout, grid) / unit; std::isinf(widest) && reach > farthest_sample)
        refuse(
            "the grid reaches {:.3g} voxels from its lattice's sample (0, 0, 0); without a band it "
            "may reach 8e14; move the origin nearer, or give the field a finite half width",
            reach);
    layout.half_width = rounded_up(std::min(widest, unbounded_half_width));
    layout.inside_squared = squared_limit(inside);
    layout.outside_squared = squared_limit(outside);

    const double diagonal = std::sqrt(grid.spacing[0] * grid.spacing[0] + grid.spacing[1] * grid.spacing[1] +
                                      grid.spacing[2] * grid.spacing[2]) /
                            unit;
    layout.slack_rate = static_cast<float>(slack_rate);
    layout.brick_slack = rounded_up(base_slack + slack_rate * CLSDF_COARSE * diagonal);
    layout.coarse_slack = rounded_up(base_slack + slack_rate * 4 * CLSDF_COARSE * diagonal);
    layout.brick_radius = rounded_up(0.5 * (CLSDF_BRICK - 1) * diagonal);
    layout.coarse_radius = rounded_up(0.5 * (CLSDF_COARSE - 1) * diagonal);

    for (std::size_t axis = 0; axis < 3; ++axis) layout.spacing[axis] = static_cast<float>(grid.spacing[axis] / unit);
    layout.unit = static_cast<float>(unit);
    layout.inside_fill = static_cast<float>(band.inside_value());
    layout.outside_fill = static_cast<float>(std::abs(band.outside));
    layout.least_inside = band.has_exact_signs ? std::numeric_limits<float>::min() : 0.0F;
    return layout;
}

LatticeView lattice_of(const Grid& grid) {
    const double unit = unit_of(grid);
    return {grid.origin, unit, {grid.spacing[0] / unit, grid.spacing[1] / unit, grid.spacing[2] / unit}};
}

bool has_long_bricks(const Grid& grid) {
    // The error of float offsets is 1e-6 voxel at equal spacing, and grows with the largest ratio.
    constexpr double largest_ratio = 1.5;
    return *std::max_element(grid.spacing.begin(), grid.spacing.end()) > largest_ratio * grid.voxel();
}

std::size_t brick_count(const Layout& layout) {
    return static_cast<std::size_t>(layout.bricks[0]) * static_cast<std::size_t>(layout.bricks[1]) *
           static_cast<std::size_t>(layout.bricks[2]);
}

std::size_t coarse_brick_count(const Layout& layout) {
    return static_cast<std::size_t>(layout.coarse_bricks[0]) * static_cast<std::size_t>(layout.coarse_bricks[1]) *
           static_cast<std::size_t>(layout.coarse_bricks[2]);
}

std::size_t sign_bytes_of_slice(const Grid& grid) {
    // Each row of whole bricks takes a word for 32 samples, a count and a start, and four crossings of three words.
    const auto rows = static_cast<std::size_t>(grid.size[1] + std::int64_t{2} * CLSDF_BRICK);
    const auto words = static_cast<std::size_t>(grid.size[0] / 32 + 2);
    return rows * (words + 2 + 12) * sizeof(std::uint32_t);
}

std::size_t sign_row_count(const Layout& layout) {
    return static_cast<std::size_t>(layout.bricks[1]) * CLSDF_BRICK * static_cast<std::size_t>(layout.bricks[2]) *
           CLSDF_BRICK;
}

std::size_t sign_bytes(const Layout& layout) {
    return sign_row_count(layout) * static_cast<std::size_t>(layout.sign_words) * sizeof(std::uint32_t);
}

}  // namespace clsdf::engine
