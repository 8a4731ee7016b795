#include <clsdf/error.hpp>
#include <clsdf/grid.hpp>

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>

namespace clsdf {
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

}  // namespace clsdf
