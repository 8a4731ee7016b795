#pragma once

#include "core/large_memory.hpp"
#include "mesh/segment_crossings.hpp"
#include "tree/crossed_faces.hpp"

#include <clsdf/grid.hpp>
#include <clsdf/outputs.hpp>

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>

namespace clsdf::segments {

/// A place in a box of samples, counted from its first one.
using Place = std::array<std::int32_t, 3>;

/// The samples of a grid and of a margin around it: the doubles of Grid::position(), scaled as the faces are.
struct SampleBox {
    /// margin: samples on both sides of each axis. Throws Error(invalid_argument) if they are too far from 0 for the
    /// spacing, or out of the range of expansions.h.
    SampleBox(const Grid& grid_in, const Place& margin_in, double scale_in);

    Grid grid;  ///< with the margin
    Place margin;
    Place size{};  ///< with the margin
    double scale;
    std::array<UninitializedVector<double>, 3> at;  ///< by axis: scaled
    std::array<double, 3> per_spacing{};            ///< 1 / the scaled spacing
    double rounding = 0;                            ///< samples are at most that far from the lattice's, in voxels

    Vec3 position(const Place& p) const {
        return {at[0][static_cast<std::size_t>(p[0])], at[1][static_cast<std::size_t>(p[1])],
                at[2][static_cast<std::size_t>(p[2])]};
    }
    std::size_t row(const Place& p) const {
        return static_cast<std::size_t>(p[1]) + static_cast<std::size_t>(size[1]) * static_cast<std::size_t>(p[2]);
    }
    std::size_t row_count() const { return static_cast<std::size_t>(size[1]) * static_cast<std::size_t>(size[2]); }
    /// Whether the sample is one of the grid, without its margin.
    bool is_in_grid(const Place& p) const {
        bool is_in = true;
        for (std::size_t axis = 0; axis < 3; ++axis)
            is_in = is_in && p[axis] >= margin[axis] && p[axis] < size[axis] - margin[axis];
        return is_in;
    }
    bool is_in_box(const Place& p) const {
        bool is_in = true;
        for (std::size_t axis = 0; axis < 3; ++axis) is_in = is_in && p[axis] >= 0 && p[axis] < size[axis];
        return is_in;
    }
    /// The first sample on an axis whose coordinate is not below x, or above x; `size` if there is none.
    std::int32_t first_not_below(std::size_t axis, double x) const {
        const Steps steps = steps_to(axis, x);
        return steps.is_between ? steps.next : exact_first_not_below(axis, x);
    }
    std::int32_t first_above(std::size_t axis, double x) const {
        const Steps steps = steps_to(axis, x);
        return steps.is_between ? steps.next : exact_first_above(axis, x);
    }

private:
    struct Steps {
        std::int32_t next;  ///< the first sample behind, or `size`
        bool is_between;    ///< no sample is so near that roundings matter
    };
    Steps steps_to(std::size_t axis, double x) const {
        const double steps = (x - at[axis][0]) * per_spacing[axis], count = size[axis];
        const double limited = std::clamp(steps, -1.0, count);
        const auto next = static_cast<std::int32_t>(limited + 1);  // rounded down
        const double before = next - limited, off = 2 * rounding + 0x1p-50 * count;
        return {std::min(next, size[axis]), limited != steps || (before > off && 1 - before > off)};
    }
    std::int32_t exact_first_not_below(std::size_t axis, double x) const;
    std::int32_t exact_first_above(std::size_t axis, double x) const;
};

}  // namespace clsdf::segments
