#include "targets/target_layout.hpp"

#include "core/outputs.hpp"
#include "core/refuse.hpp"

#include <clsdf/error.hpp>

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <string>

namespace clsdf::targets {

namespace {

Error misuse(const std::string& what) {
    return {ErrorCode::invalid_argument, what};
}

std::array<std::ptrdiff_t, 3> packed_strides(std::ptrdiff_t sample_bytes, const Grid& grid) {
    return {sample_bytes, sample_bytes * grid.size[0], sample_bytes * grid.size[0] * grid.size[1]};
}

}  // namespace

void refuse_values_on_others(const std::string& array, std::ptrdiff_t width, const Index3& size,
                             const std::array<std::ptrdiff_t, 3>& strides, std::size_t components,
                             std::ptrdiff_t component_stride) {
    struct Axis {
        double step, count;
        const char* name;
    };
    std::array<Axis, 4> axes{
        Axis{static_cast<double>(component_stride), static_cast<double>(components), "from component to component"},
        Axis{static_cast<double>(strides[0]), static_cast<double>(size[0]), "along x"},
        Axis{static_cast<double>(strides[1]), static_cast<double>(size[1]), "along y"},
        Axis{static_cast<double>(strides[2]), static_cast<double>(size[2]), "along z"}};
    for (Axis& axis : axes) axis.step = std::abs(axis.step);
    std::sort(axes.begin(), axes.end(), [](const Axis& a, const Axis& b) { return a.step < b.step; });
    auto span = static_cast<double>(width);
    for (const Axis& axis : axes) {
        if (axis.count < 2) continue;
        if (axis.step < span)
            throw misuse(
                fmt::format("{} has a stride of {:.0f} bytes {}, and {:.0f} bytes are written at each step: values "
                            "would overlap; a stride of {:.0f} bytes or more is needed, or strides of 0 for packed "
                            "values",
                            array, axis.step, axis.name, span, span));
        span += axis.step * (axis.count - 1);
    }
}

void resolve_type(const OutputInfo& row, OutputArray& target) {
    if (target.type == ElementType::automatic) target.type = row.type;
    // No triangle is -1 in signed numbers.
    const bool is_signed = row.type == ElementType::uint32 && target.type == ElementType::int32;
    if (target.type == row.type || is_signed || (may_be_double(row) && target.type == ElementType::float64)) return;
    refuse_unsupported("the output {} cannot be written as {}; give it an array of type {}", row.name,
                       name_of(target.type),
                       may_be_double(row)                ? "float or double"
                       : row.type == ElementType::uint32 ? "uint32 or int32"
                       : row.output == Output::closest   ? "double, or ask for the output offset, from the "
                                                           "sample to the closest point, in floats"
                                                         : name_of(row.type));
}

bool resolve_strides(const OutputInfo& row, const Grid& grid, OutputArray& target) {
    const std::ptrdiff_t width = width_of(target.type);
    const bool has_strides = std::any_of(target.strides.begin(), target.strides.end(), [](auto s) { return s != 0; });
    const auto packed = packed_strides(static_cast<std::ptrdiff_t>(sample_bytes(row, is_in_double(target))), grid);
    if (target.component_stride == 0) target.component_stride = width;
    // Components that lie elsewhere leave no room between the samples.
    if (!has_strides) target.strides = target.component_stride == width ? packed : packed_strides(width, grid);
    return target.strides == packed && (row.components == 1 || target.component_stride == width);
}

std::pair<double, double> extent_of(const OutputInfo& row, const Grid& grid, const OutputArray& target) {
    return clsdf::extent_of(target, {{target.strides[0], static_cast<double>(grid.size[0])},
                                     {target.strides[1], static_cast<double>(grid.size[1])},
                                     {target.strides[2], static_cast<double>(grid.size[2])},
                                     {target.component_stride, static_cast<double>(row.components)}});
}

ByteRange range_of(const OutputInfo& row, const Grid& grid, const OutputArray& target, std::size_t bytes) {
    if (grid.sample_count() == 0) return {};
    const std::ptrdiff_t width = width_of(target.type);
    const auto [lowest, highest] = extent_of(row, grid, target);
    if (bytes != ArrayLayout::unknown_size && (lowest < 0 || highest > static_cast<double>(bytes)))
        throw misuse(
            fmt::format("the target of the output {} reaches from byte {:.0f} to {:.0f} with its offset and "
                        "strides, and its memory holds {} bytes; give more memory, or other strides (with negative "
                        "ones the offset names the first sample)",
                        row.name, lowest, highest, bytes));
    const auto check_multiple = [&](const char* what, std::ptrdiff_t length) {
        if (length % width == 0) return;
        throw misuse(
            fmt::format("the target of the output {} has {} of {} bytes, which is no multiple of the {} bytes "
                        "of its elements; copy through an array that is aligned",
                        row.name, what, length, width));
    };
    check_multiple("an offset", static_cast<std::ptrdiff_t>(target.offset));
    check_multiple("a component stride", target.component_stride);
    for (const std::ptrdiff_t stride : target.strides) check_multiple("a stride", stride);
    refuse_values_on_others(fmt::format("the target of the output {}", row.name), width, grid.size, target.strides,
                            row.components, target.component_stride);
    if (lowest < 0) return {};  // of unknown memory
    return {static_cast<std::size_t>(lowest), static_cast<std::size_t>(highest)};
}

}  // namespace clsdf::targets
