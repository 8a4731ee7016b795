#include "segments/sample_box.hpp"

#include "core/refuse.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace clsdf::segments {

SampleBox::SampleBox(const Grid& grid_in, const Place& margin_in, double scale_in)
    : grid(grid_in), margin(margin_in), scale(scale_in) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
        grid.first[axis] -= margin[axis];
        grid.size[axis] += 2 * margin[axis];
        const auto count = static_cast<std::size_t>(grid.size[axis]);
        size[axis] = static_cast<std::int32_t>(count);
        per_spacing[axis] = 1 / (grid.spacing[axis] * scale);
        at[axis].resize(count);
        double greatest = 0;
        for (std::size_t i = 0; i < count; ++i) {
            const double x = std::fma(static_cast<double>(grid.first[axis] + static_cast<std::int64_t>(i)),
                                      grid.spacing[axis], grid.origin[axis]);
            greatest = std::max(greatest, std::abs(x));
            at[axis][i] = x * scale;
            if (!engine::is_exact_in_units({x, 0, 0}, scale))
                refuse(
                    "a sample of the grid has the coordinate {} on axis {}, which in units of {} "
                    "is smaller than 2^-300 or greater than 2^300; set the grid's origin so that "
                    "it is 0, or use a larger spacing",
                    x, "xyz"[axis], 1 / scale);
        }
        const double last_bit = std::nextafter(greatest, std::numeric_limits<double>::infinity()) - greatest;
        if (!(last_bit <= 0x1p-22 * grid.spacing[axis]))
            refuse(
                "the grid reaches to {} on axis {} with the spacing {}: links, crossings and "
                "exact signs need samples whose coordinates' last bit, here {}, is at most 2^-22 of "
                "the spacing; move mesh and grid towards 0, or use a larger spacing",
                greatest, "xyz"[axis], grid.spacing[axis], last_bit);
        rounding = std::max(rounding, 0.5 * last_bit / grid.spacing[axis]);
    }
}

namespace {

/// The first index for which is_past(index) holds, which is near `guess`.
template <typename IsPast>
std::int32_t first_past(double guess, std::int32_t count, const IsPast& is_past) {
    auto i = static_cast<std::int32_t>(std::clamp(guess, 0.0, static_cast<double>(count)));
    while (i > 0 && is_past(i - 1)) --i;
    while (i < count && !is_past(i)) ++i;
    return i;
}

double guess_of(const UninitializedVector<double>& at, double x, double per_spacing) {
    return std::ceil((x - at[0]) * per_spacing);
}

}  // namespace

std::int32_t SampleBox::exact_first_not_below(std::size_t axis, double x) const {
    const UninitializedVector<double>& all = at[axis];
    return first_past(guess_of(all, x, per_spacing[axis]), size[axis],
                      [&](std::int32_t i) { return all[static_cast<std::size_t>(i)] >= x; });
}

std::int32_t SampleBox::exact_first_above(std::size_t axis, double x) const {
    const UninitializedVector<double>& all = at[axis];
    return first_past(guess_of(all, x, per_spacing[axis]), size[axis],
                      [&](std::int32_t i) { return all[static_cast<std::size_t>(i)] > x; });
}

}  // namespace clsdf::segments
