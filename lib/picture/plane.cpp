#include "picture/plane.hpp"

#include <clsdf/error.hpp>

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace clsdf::picture {
namespace {

std::size_t index_of(Axis axis) {
    return static_cast<std::size_t>(axis);
}

void check(const Grid& grid, const Slice& slice, const std::array<Axis, 2>& axes) {
    const std::int64_t count = grid.size[index_of(slice.axis)];
    if (slice.index < 0 || slice.index >= count)
        throw Error(ErrorCode::invalid_argument,
                    fmt::format("slice: the field has no sample {} along {}: there are {}, choose 0 to {}", slice.index,
                                name_of(slice.axis), count, count - 1));
    for (const Axis axis : axes)
        if (grid.size[index_of(axis)] < 2)
            throw Error(ErrorCode::invalid_argument,
                        fmt::format("slice: the field has a single sample along {}, so a slice perpendicular to {} has "
                                    "no extent; choose another axis",
                                    name_of(axis), name_of(slice.axis)));
}

// Decides which samples are beyond the band: they have its half widths.
class Limits {
public:
    explicit Limits(const Band& band)
        : inside_(-static_cast<double>(static_cast<float>(band.inside))),
          outside_(static_cast<double>(static_cast<float>(band.outside))) {}

    // If the band has no inside, +0 is an exact distance, and -0 is beyond the band.
    bool within(double value) const {
        return (value > inside_ || (value == 0 && !std::signbit(value))) && value < outside_;
    }

    /// The least magnitude of the value: the sample is beyond the band.
    double beyond(double value, double continued) const {
        return std::signbit(value) ? std::min(continued, inside_ - tiny) : std::max(continued, outside_);
    }

private:
    // If the band has only an outside, -0 inside becomes a number below zero.
    static constexpr double tiny = std::numeric_limits<double>::min();
    double inside_;
    double outside_;
};

constexpr std::array<std::array<int, 2>, 8> neighbours{
    {{1, 0}, {0, 1}, {-1, 0}, {0, -1}, {1, 1}, {-1, 1}, {-1, -1}, {1, -1}}};

// The mean of the linear extrapolations from two neighbouring samples of the band in each direction.
double continued(const Plane& plane, const std::vector<double>& values, const Limits& limits, std::int64_t column,
                 std::int64_t row) {
    const auto value = [&](std::int64_t steps, std::int64_t right, std::int64_t up) {
        const std::int64_t i = column + steps * right;
        const std::int64_t j = row + steps * up;
        const bool there = i >= 0 && i < plane.size[0] && j >= 0 && j < plane.size[1];
        return there ? values[static_cast<std::size_t>(j * plane.size[0] + i)] : std::nan("");
    };
    double sum = 0;
    int lines = 0;
    for (const auto& [right, up] : neighbours) {
        const double near = value(1, right, up);
        const double far = value(2, right, up);
        if (!limits.within(near) || !limits.within(far)) continue;
        sum += 2 * near - far;
        ++lines;
    }
    const double own = value(0, 0, 0);
    return limits.beyond(own, lines == 0 ? own : sum / lines);
}

void continue_beyond_the_band(Plane& plane, const Band& band) {
    const Limits limits(band);
    const std::vector<double> values = plane.values;
    for (std::int64_t row = 0; row < plane.size[1]; ++row)
        for (std::int64_t column = 0; column < plane.size[0]; ++column) {
            double& own = plane.values[static_cast<std::size_t>(row * plane.size[0] + column)];
            if (!limits.within(own) && std::isfinite(own)) own = continued(plane, values, limits, column, row);
        }
}

}  // namespace

const char* name_of(Axis axis) {
    static const char* const names[] = {"x", "y", "z"};
    return names[index_of(axis)];
}

Axis parse_axis(const std::string& text) {
    for (const Axis axis : {Axis::x, Axis::y, Axis::z})
        if (text == name_of(axis)) return axis;
    throw Error(ErrorCode::invalid_argument, fmt::format("there is no axis \"{}\"; choose x, y or z", text));
}

std::array<Axis, 2> axes_beside(Axis axis) {
    return {axis == Axis::x ? Axis::y : Axis::x, axis == Axis::z ? Axis::y : Axis::z};
}

double Plane::at(double column, double row) const {
    const auto i = std::clamp<std::int64_t>(static_cast<std::int64_t>(column), 0, size[0] - 2);
    const auto j = std::clamp<std::int64_t>(static_cast<std::int64_t>(row), 0, size[1] - 2);
    const double s = column - static_cast<double>(i);
    const double t = row - static_cast<double>(j);
    // The interpolation of equal values is exact: otherwise rounding would draw the line of the band's limit.
    const auto between = [](double from, double to, double part) { return from + part * (to - from); };
    return between(between(sample(i, j), sample(i + 1, j), s), between(sample(i, j + 1), sample(i + 1, j + 1), s), t);
}

Plane plane_of(const Field& field, const Slice& slice, const std::array<Axis, 2>& axes) {
    const Grid& grid = field.grid;
    check(grid, slice, axes);
    const std::size_t right = index_of(axes[0]);
    const std::size_t up = index_of(axes[1]);

    Plane plane;
    plane.axes = axes;
    plane.size = {grid.size[right], grid.size[up]};
    Index3 at{};
    at[index_of(slice.axis)] = slice.index;
    const Vec3 lower = grid.position(at[0], at[1], at[2]);
    plane.lower = {lower[right], lower[up]};
    plane.values.reserve(static_cast<std::size_t>(plane.size[0] * plane.size[1]));
    for (at[up] = 0; at[up] < plane.size[1]; ++at[up])
        for (at[right] = 0; at[right] < plane.size[0]; ++at[right])
            plane.values.push_back(static_cast<double>(field.distance[grid.offset(at[0], at[1], at[2])]));
    at[right] = plane.size[0] - 1;
    at[up] = plane.size[1] - 1;
    const Vec3 upper = grid.position(at[0], at[1], at[2]);
    plane.upper = {upper[right], upper[up]};
    continue_beyond_the_band(plane, field.band);
    return plane;
}

}  // namespace clsdf::picture
