#include <clsdf/band.hpp>
#include <clsdf/error.hpp>
#include <clsdf/grid.hpp>
#include <clsdf/mesh.hpp>

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace clsdf {
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

void check_margin(const Length& margin) {
    if (!(margin.value >= 0) || margin.is_infinite())
        throw Error(ErrorCode::invalid_argument,
                    fmt::format("grid: the margin is {}; it must be 0 or more, and finite", margin.value));
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
    check_margin(options.margin);

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
        const double centre = box.lower[axis] + (box.upper[axis] - box.lower[axis]) / 2;
        grid.origin[axis] = std::fma(static_cast<double>(grid.size[axis] - 1) / -2, grid.spacing[axis], centre);
    }
    if (options.cell_centred) grid = grid.cell_centred();
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
