#include <clsdf/error.hpp>
#include <clsdf/grid.hpp>
#include <clsdf/mesh.hpp>

#include "core/real_numbers.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>

namespace clsdf {

Length Length::infinite() {
    return in_mesh_units(std::numeric_limits<double>::infinity());
}

Length Length::parse(std::string_view text, std::string_view name) {
    if (text == "full") return infinite();
    Unit unit = Unit::mesh;
    if (text.ends_with('%'))
        unit = Unit::extent;
    else if (text.ends_with('v'))
        unit = Unit::voxels;
    const char* const end = text.data() + text.size() - (unit == Unit::mesh ? 0 : 1);
    double value = 0;
    const auto [stop, error] = read_real(text.data(), end, value);
    if (error != std::errc() || stop != end || !std::isfinite(value) || value < 0)
        throw Error(ErrorCode::invalid_argument,
                    fmt::format("{}: \"{}\" is not a length: write 10% (of the longest side of the mesh's box), 3v "
                                "(voxels), 0.05 (the mesh's units) or full",
                                name, text));
    return {unit == Unit::extent ? value / 100 : value, unit};
}

bool Length::is_infinite() const {
    return std::isinf(value);
}

double Length::resolve(double voxel, double extent) const {
    if (is_infinite() || unit == Unit::mesh) return value;
    return value * (unit == Unit::voxels ? voxel : extent);
}

Band Band::full() {
    return symmetric(std::numeric_limits<double>::infinity());
}

double Band::inside_value() const {
    constexpr auto least = static_cast<double>(std::numeric_limits<float>::min());
    return -std::max(std::abs(inside), has_exact_signs ? least : 0.0);
}

void Band::validate() const {
    if (std::isnan(inside) || std::isnan(outside))
        throw Error(ErrorCode::invalid_argument,
                    fmt::format("band: the half widths are {} inside and {} outside, and one that is nan was not set; "
                                "give both, for example a band of three voxels, or use the full band",
                                inside, outside));
    if (!(inside >= 0) || !(outside >= 0))
        throw Error(ErrorCode::invalid_argument,
                    fmt::format("band: the half widths are {} inside and {} outside; each must be 0 or more (infinite "
                                "for a full field)",
                                inside, outside));
    const bool has_no_width = inside == 0 && outside == 0;
    if (has_no_width && !has_signs_only)
        throw Error(ErrorCode::invalid_argument,
                    "band: both half widths are 0, so no sample has a distance; give one, for example a band of "
                    "three voxels, or ask for the signs alone");
    if (has_signs_only && !has_no_width)
        throw Error(ErrorCode::invalid_argument,
                    fmt::format("band: it has signs only, and the half widths {} inside and {} outside; set both to 0, "
                                "or ask for distances, too",
                                inside, outside));
}

namespace {

// An index up to here is exact as a double, and so is the position formed from it.
constexpr std::int64_t largest_index = std::int64_t{1} << 53;

constexpr std::array axis_names{'x', 'y', 'z'};

}  // namespace

double Box::longest_side() const {
    const Vec3 sides = extent();
    return *std::max_element(sides.begin(), sides.end());
}

Grid Grid::part(const Index3& offset, const Index3& part_size) const {
    Grid result = *this;
    for (std::size_t axis = 0; axis < 3; ++axis) {
        if (offset[axis] < 0 || part_size[axis] < 1 || offset[axis] > size[axis] ||
            part_size[axis] > size[axis] - offset[axis])
            throw Error(
                ErrorCode::invalid_argument,
                fmt::format("grid: a part of {} samples from sample {} on is not inside the {} samples along {}",
                            part_size[axis], offset[axis], size[axis], axis_names[axis]));
        result.first[axis] += offset[axis];
        result.size[axis] = part_size[axis];
    }
    return result;
}

Grid Grid::block(const Index3& block_first, const Index3& block_size) const {
    Grid result = *this;
    result.first = block_first;
    result.size = block_size;
    return result;
}

Grid Grid::grown(std::int64_t samples) const {
    for (std::size_t axis = 0; axis < 3; ++axis)
        for (const std::int64_t number : {first[axis], size[axis], samples})
            if (std::abs(static_cast<double>(number)) > static_cast<double>(largest_index))
                throw Error(ErrorCode::invalid_argument,
                            fmt::format("grid: grown by {} samples, it would have indices beyond 2^53", samples));
    Grid result = *this;
    for (std::size_t axis = 0; axis < 3; ++axis) {
        result.first[axis] -= samples;
        result.size[axis] += 2 * samples;
        if (result.size[axis] < 1)
            throw Error(ErrorCode::invalid_argument,
                        fmt::format("grid: {} samples along {}, grown by {} on both sides, leave none", size[axis],
                                    axis_names[axis], samples));
    }
    return result;
}

Grid Grid::refined(std::int64_t ratio) const {
    Grid result = refined_cells(ratio);
    result.origin = origin;
    for (std::size_t axis = 0; axis < 3; ++axis) result.size[axis] = (size[axis] - 1) * ratio + 1;
    return result;
}

Grid Grid::refined_cells(std::int64_t ratio) const {
    if (ratio < 1)
        throw Error(ErrorCode::invalid_argument,
                    fmt::format("grid: it cannot be refined by a ratio of {}; give 1 or more", ratio));
    Grid result = *this;
    for (std::size_t axis = 0; axis < 3; ++axis) {
        for (const std::int64_t number : {first[axis], size[axis]})
            if (std::abs(static_cast<double>(number) * static_cast<double>(ratio)) > static_cast<double>(largest_index))
                throw Error(ErrorCode::invalid_argument,
                            fmt::format("grid: refined by a ratio of {}, it would have indices beyond 2^53", ratio));
        result.spacing[axis] /= static_cast<double>(ratio);
        // From the centre of the lattice's cell 0 to that of its first part.
        result.origin[axis] = std::fma(-0.5, spacing[axis], std::fma(0.5, result.spacing[axis], origin[axis]));
        result.first[axis] *= ratio;
        result.size[axis] *= ratio;
    }
    return result;
}

Grid Grid::cell_centred() const {
    Grid result = *this;
    for (std::size_t axis = 0; axis < 3; ++axis) result.origin[axis] = std::fma(0.5, spacing[axis], origin[axis]);
    return result;
}

Vec3 Grid::position(std::int64_t i, std::int64_t j, std::int64_t k) const {
    const Index3 index{first[0] + i, first[1] + j, first[2] + k};
    Vec3 result{};
    for (std::size_t axis = 0; axis < 3; ++axis)
        result[axis] = std::fma(static_cast<double>(index[axis]), spacing[axis], origin[axis]);
    return result;
}

Box Grid::box() const {
    return {position(0, 0, 0), position(size[0] - 1, size[1] - 1, size[2] - 1)};
}

double Grid::voxel() const {
    return *std::min_element(spacing.begin(), spacing.end());
}

std::size_t Grid::sample_count() const {
    constexpr std::size_t limit = std::numeric_limits<std::ptrdiff_t>::max() / sizeof(float);
    std::size_t count = 1;
    for (const std::int64_t samples : size) {
        const std::size_t factor = samples > 0 ? static_cast<std::size_t>(samples) : 0;
        if (factor > 0 && count > limit / factor)
            throw Error(ErrorCode::out_of_memory,
                        fmt::format("grid: {} x {} x {} samples do not fit the address space; choose a larger spacing "
                                    "or compute the grid in parts",
                                    size[0], size[1], size[2]));
        count *= factor;
    }
    return count;
}

void Grid::validate() const {
    for (std::size_t axis = 0; axis < 3; ++axis) {
        const char name = axis_names[axis];
        if (size[axis] < 1)
            throw Error(ErrorCode::invalid_argument,
                        fmt::format("grid: {} samples along {}; a grid has at least one", size[axis], name));
        // Written so that a NaN fails.
        if (!(spacing[axis] > 0) || !std::isfinite(spacing[axis]))
            throw Error(
                ErrorCode::invalid_argument,
                fmt::format("grid: the spacing along {} is {}; it must be positive and finite", name, spacing[axis]));
        if (!std::isfinite(origin[axis]))
            throw Error(ErrorCode::invalid_argument,
                        fmt::format("grid: the origin's {} is {}; it must be finite", name, origin[axis]));
        if (size[axis] > largest_index || first[axis] < -largest_index || first[axis] > largest_index - size[axis])
            throw Error(ErrorCode::invalid_argument,
                        fmt::format("grid: samples {} and the {} after it along {} are beyond 2^53, where an index is "
                                    "no longer exact; choose a larger spacing or another origin",
                                    first[axis], size[axis] - 1, name));
        for (const std::int64_t index : {first[axis], first[axis] + size[axis] - 1})
            if (!std::isfinite(std::fma(static_cast<double>(index), spacing[axis], origin[axis])))
                throw Error(ErrorCode::invalid_argument,
                            fmt::format("grid: sample {} along {} lies beyond the range of a double; choose a smaller "
                                        "spacing",
                                        index, name));
    }
}

namespace {

// A side that exceeds a whole number of voxels by less than this counts as that number, so that rounding does not cost
// a slice of samples. It is the accuracy of a field.
constexpr double voxel_slack = 1e-6;

void check_box(const Box& box) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
        const double side = box.upper[axis] - box.lower[axis];
        // Written so that a NaN fails; the side of a box of finite corners may still overflow.
        if (!(side >= 0) || !std::isfinite(side))
            throw Error(ErrorCode::invalid_argument,
                        fmt::format("grid: the box reaches from {} to {} along {}; it needs finite limits in ascending "
                                    "order, and a finite side",
                                    box.lower[axis], box.upper[axis], "xyz"[axis]));
    }
}

Vec3 resolved_spacing(const Box& box, const GridOptions& options) {
    if (options.spacing) {
        for (const double step : *options.spacing)
            if (!(step > 0) || !std::isfinite(step))
                throw Error(ErrorCode::invalid_argument,
                            fmt::format("grid: the spacing {} must be positive and finite", step));
        return *options.spacing;
    }
    if (options.resolution < 2)
        throw Error(
            ErrorCode::invalid_argument,
            fmt::format("grid: a resolution of {} samples; the longest side needs at least 2", options.resolution));

    const double extent = box.longest_side();
    const auto steps = static_cast<double>(options.resolution - 1);
    double length = extent;
    double divisor = steps;
    if (options.margin.unit == Length::Unit::voxels) {
        divisor = steps - 2 * options.margin.value;
        if (!(divisor > 0))
            throw Error(
                ErrorCode::invalid_argument,
                fmt::format("grid: a margin of {} voxels on both sides leaves nothing of {} samples for the mesh; "
                            "choose a resolution above {} or a smaller margin",
                            options.margin.value, options.resolution, std::floor(2 * options.margin.value) + 1));
    } else {
        length += 2 * options.margin.resolve(0, extent);
    }
    const double step = length / divisor;
    if (!(step > 0))
        throw Error(ErrorCode::invalid_argument,
                    fmt::format("grid: a box whose longest side is {} gives no spacing at a resolution of {} samples; "
                                "state the spacing, or a margin in the mesh's units",
                                extent, options.resolution));
    if (!std::isfinite(step))
        throw Error(ErrorCode::invalid_argument,
                    fmt::format("grid: a longest side of {} and its margin are beyond the range of a double", extent));
    return {step, step, step};
}

// Samples that cover `steps` voxels.
std::int64_t covering_samples(double steps) {
    constexpr double largest = 9007199254740992.0;  // 2^53
    if (!(steps < largest))
        throw Error(ErrorCode::invalid_argument,
                    fmt::format("grid: a side of {} voxels has too many samples; choose a larger spacing", steps));
    return static_cast<std::int64_t>(std::ceil(std::max(0.0, steps - voxel_slack))) + 1;
}

}  // namespace

Grid Grid::around(const Box& box, const GridOptions& options) {
    check_box(box);
    if (!(options.margin.value >= 0) || options.margin.is_infinite())
        throw Error(ErrorCode::invalid_argument,
                    fmt::format("grid: the margin is {}; it must be 0 or more, and finite", options.margin.value));

    Grid grid;
    grid.spacing = resolved_spacing(box, options);
    const double extent = box.longest_side();
    const double margin = options.margin.resolve(grid.voxel(), extent);
    for (std::size_t axis = 0; axis < 3; ++axis) {
        const double side = box.upper[axis] - box.lower[axis];
        const bool sets_resolution = !options.spacing && side == extent;
        grid.size[axis] =
            sets_resolution ? options.resolution : covering_samples((side + 2 * margin) / grid.spacing[axis]);
    }
    if (options.cubic) grid.size.fill(*std::max_element(grid.size.begin(), grid.size.end()));
    for (std::size_t axis = 0; axis < 3; ++axis) {
        const double side = box.upper[axis] - box.lower[axis], centre = box.lower[axis] + side / 2;
        grid.origin[axis] = std::fma(static_cast<double>(grid.size[axis] - 1) / -2, grid.spacing[axis], centre);
        // The samples end with the box, so nothing is left to be centred but rounding.
        if (margin == 0 && !options.spacing && side == extent) grid.origin[axis] = box.lower[axis];
    }
    if (options.cell_centred) grid = grid.cell_centred();
    grid.validate();
    return grid;
}

namespace {

// (upper - lower) / n, rounded once: the remainders of the difference and of the quotient are exact.
double step_between(double lower, double upper, double n) {
    const double difference = upper - lower;
    const double subtracted = upper - difference;
    const double lost = (upper - (difference + subtracted)) + (subtracted - lower);
    const double quotient = difference / n;
    const double step = quotient + (std::fma(-quotient, n, difference) + lost) / n;
    return std::isfinite(step) ? step : quotient;
}

}  // namespace

Grid Grid::between(const Vec3& lower, const Vec3& upper, const GridDivision& division) {
    const auto refuse = [](const std::string& what) { throw Error(ErrorCode::invalid_argument, "grid: " + what); };
    if (division.samples.is_given() == division.cells.is_given())
        refuse("a box is divided by the number of its samples or by that of its cells; give one of them");
    if (division.cell_centred && division.samples.is_given())
        refuse("samples at the centres of cells need the number of cells, not that of samples");
    const bool are_samples = division.samples.is_given();
    const Index3& counts = are_samples ? division.samples.each() : division.cells.each();
    Grid grid;
    grid.origin = lower;
    std::array<bool, 3> is_flat{};
    for (std::size_t axis = 0; axis < 3; ++axis) {
        const char name = axis_names[axis];
        const std::int64_t cells = counts[axis] - (are_samples ? 1 : 0);
        is_flat[axis] = lower[axis] == upper[axis] && std::isfinite(lower[axis]);
        if (is_flat[axis]) {
            if (counts[axis] != 1 || !(are_samples || division.cell_centred))
                refuse(fmt::format(
                    "the box reaches from {0} to {0} along {1}, so it has one sample there; give 1 sample "
                    "along {1} (or 1 cell with samples at the centres), or a second corner beyond the first",
                    lower[axis], name));
            grid.size[axis] = 1;
            continue;
        }
        if (are_samples && counts[axis] == 1)
            refuse(fmt::format(
                "1 sample along {}, where the box reaches from {} to {}; a slice has the same coordinate in "
                "both corners, and a box at least 2 samples, one at each end",
                name, lower[axis], upper[axis]));
        if (counts[axis] > largest_index || cells < 1)
            refuse(fmt::format("{} {} along {}; a box has {}", counts[axis], are_samples ? "samples" : "cells", name,
                               counts[axis] > largest_index ? "at most 2^53"
                               : are_samples                ? "at least 2, one at each end"
                                                            : "at least 1"));
        // Written so that a NaN fails.
        if (!(upper[axis] > lower[axis]) || !std::isfinite(upper[axis] - lower[axis]))
            refuse(
                fmt::format("the box reaches from {} to {} along {}; the second corner must lie beyond the first, both "
                            "finite",
                            lower[axis], upper[axis], name));
        grid.spacing[axis] = step_between(lower[axis], upper[axis], static_cast<double>(cells));
        grid.size[axis] = division.cell_centred ? cells : cells + 1;
    }
    // A spacing for the axes without an extent that leaves the voxel, the least spacing, as it is.
    double least = std::numeric_limits<double>::infinity();
    for (std::size_t axis = 0; axis < 3; ++axis)
        if (!is_flat[axis]) least = std::min(least, grid.spacing[axis]);
    if (std::isinf(least))
        refuse("the box is a point, so no spacing follows from it; state the origin, the spacing and the size instead");
    for (std::size_t axis = 0; axis < 3; ++axis)
        if (is_flat[axis]) grid.spacing[axis] = least;
    if (division.cell_centred) {
        grid = grid.cell_centred();
        for (std::size_t axis = 0; axis < 3; ++axis)
            if (is_flat[axis]) grid.origin[axis] = lower[axis];
    }
    grid.validate();
    return grid;
}

Grid Grid::around(const Mesh& mesh, std::int64_t resolution, const Band& band) {
    band.validate();
    GridOptions options;
    options.resolution = resolution;
    if (!std::isinf(band.outside)) options.margin = Length::in_mesh_units(band.outside);
    return around(mesh.box(), options);
}

}  // namespace clsdf
