#include "transform/restriction.hpp"

#include <clsdf/error.hpp>

#include <fmt/format.h>

#include <algorithm>

namespace clsdf::transform {

namespace {

std::string text_of(const Box& box) {
    const auto& [lower, upper] = box;
    return fmt::format("({}, {}, {}) to ({}, {}, {})", lower[0], lower[1], lower[2], upper[0], upper[1], upper[2]);
}

bool is_within(const Box& box, const Box& other, double slack) {
    for (std::size_t axis = 0; axis < 3; ++axis)
        if (!(box.lower[axis] >= other.lower[axis] - slack && box.upper[axis] <= other.upper[axis] + slack))
            return false;
    return true;
}

}  // namespace

void Restriction::refuse(const std::string& what) const {
    throw Error(ErrorCode::invalid_argument,
                fmt::format("{}, and the transform is restricted to the box from {}, half widths up to {} and spacings "
                            "up to {}; restrict the whole transform to more",
                            what, text_of(box), half_width, spacing));
}

void Restriction::check(const Grid& grid, const Band& band, SignRule sign) const {
    const Box samples{grid.position(0, 0, 0), grid.position(grid.size[0] - 1, grid.size[1] - 1, grid.size[2] - 1)};
    const double longest = *std::max_element(grid.spacing.begin(), grid.spacing.end());
    // Samples are as far off as their positions are rounded.
    if (!is_within(samples, box, 1e-6 * longest))
        refuse(fmt::format("the grid's samples reach from {}", text_of(samples)));
    if (!(longest <= spacing)) refuse(fmt::format("the grid's spacing is {}", longest));
    const double widest = sign == SignRule::none ? band.outside : band.widest();
    if (!(widest <= half_width)) refuse(fmt::format("the band's half width is {}", widest));
}

void Restriction::check(std::span<const Vec3> points, double within) const {
    if (!(within <= half_width)) refuse(fmt::format("points are looked up within {}", within));
    for (std::size_t i = 0; i < points.size(); ++i)
        if (!is_within({points[i], points[i]}, box, 0))
            refuse(fmt::format("point {} lies at ({}, {}, {})", i, points[i][0], points[i][1], points[i][2]));
}

void Restriction::check(std::span<const Box> boxes, double half_width_asked) const {
    if (!(half_width_asked <= half_width)) refuse(fmt::format("the half width around boxes is {}", half_width_asked));
    for (std::size_t i = 0; i < boxes.size(); ++i)
        if (!is_within(boxes[i], box, 0)) refuse(fmt::format("box {} reaches from {}", i, text_of(boxes[i])));
}

}  // namespace clsdf::transform
