#include "picture/plane.hpp"

#include "core/refuse.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <unordered_map>
#include <utility>

namespace clsdf::picture {

namespace {

std::size_t index_of(Axis axis) {
    return static_cast<std::size_t>(axis);
}

void check(const Grid& grid, const Slice& slice, const std::array<Axis, 2>& axes) {
    const std::int64_t count = grid.size[index_of(slice.axis)];
    if (slice.index < 0 || slice.index >= count)
        refuse("slice: the field has no sample {} along {}: there are {}, choose 0 to {}", slice.index,
               name_of(slice.axis), count, count - 1);
    for (const Axis axis : axes)
        if (grid.size[index_of(axis)] < 2)
            refuse(
                "field: it has a single sample along {}, so a slice perpendicular to {} has "
                "no extent; choose another axis",
                name_of(axis), name_of(slice.axis));
}

}  // namespace

void check_field(const Field& field) {
    field.grid.validate();
    field.band.validate();
    if (field.positive_inside)
        refuse(
            "field: it is positive inside, and pictures are drawn of fields that are negative inside; negate "
            "it first");
    const Grid& grid = field.grid;
    if (field.distance().size() != grid.sample_count())
        refuse("field: distance has {} values, but the grid {} samples", field.distance().size(), grid.sample_count());
    const Index3& size = grid.size;
    const Vec3 first = grid.position(0, 0, 0), second = grid.position(1, 1, 1);
    const Vec3 last = grid.position(size[0] - 1, size[1] - 1, size[2] - 1);
    const Vec3 last_but_one = grid.position(size[0] - 2, size[1] - 2, size[2] - 2);
    for (std::size_t axis = 0; axis < 3; ++axis) {
        const double spacing = grid.spacing[axis];
        if (spacing < static_cast<double>(std::numeric_limits<float>::min()) ||
            spacing > static_cast<double>(std::numeric_limits<float>::max()))
            refuse(
                "field: a spacing of {} is beyond the floats that distances are given in; scale "
                "the field",
                spacing);
        if (size[axis] > 1 && (first[axis] == second[axis] || last[axis] == last_but_one[axis]))
            refuse(
                "field: samples {} apart near {} = {} have the same position in double precision; "
                "move the field to the origin",
                spacing, "xyz"[axis], last[axis]);
    }
}

namespace {

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
    refuse("there is no axis \"{}\"; choose x, y or z", text);
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
            plane.values.push_back(static_cast<double>(field.distance()[grid.offset(at[0], at[1], at[2])]));
    at[right] = plane.size[0] - 1;
    at[up] = plane.size[1] - 1;
    const Vec3 upper = grid.position(at[0], at[1], at[2]);
    plane.upper = {upper[right], upper[up]};
    continue_beyond_the_band(plane, field.band);
    return plane;
}

namespace {

// The number of a lattice edge: twice its lower left sample, plus one if it leads upwards.
using Edge = std::int64_t;
using Links = std::array<Edge, 2>;  // the edges that the line goes on to, one in each square beside this edge
constexpr Edge none = -1;

class Tracer {
public:
    Tracer(const Plane& plane, double level) : plane_(plane), level_(level) {
        for (std::int64_t row = 0; row + 1 < plane.size[1]; ++row)
            for (std::int64_t column = 0; column + 1 < plane.size[0]; ++column) cross_square(column, row);
    }

    std::vector<Polyline> lines() {
        std::vector<Polyline> result;
        // First the open lines, from an end; the remaining lines are closed. The order is that of the squares, not of
        // the map.
        for (const Edge edge : order_)
            if (!drawn(edge) && links_.at(edge)[1] == none) result.push_back(follow(edge));
        for (const Edge edge : order_)
            if (!drawn(edge)) {
                Polyline closed = follow(edge);
                closed.push_back(closed.front());
                result.push_back(std::move(closed));
            }
        return result;
    }

private:
    void cross_square(std::int64_t column, std::int64_t row) {
        const std::array corners{plane_.sample(column, row), plane_.sample(column + 1, row),
                                 plane_.sample(column + 1, row + 1), plane_.sample(column, row + 1)};
        unsigned above = 0;
        for (std::size_t corner = 0; corner < 4; ++corner) {
            if (!std::isfinite(corners[corner])) return;
            above |= static_cast<unsigned>(corners[corner] >= level_) << corner;
        }
        const Edge sample = row * plane_.size[0] + column;
        const Edge bottom = 2 * sample;
        const Edge right = 2 * (sample + 1) + 1;
        const Edge top = 2 * (sample + plane_.size[0]);
        const Edge left = 2 * sample + 1;
        switch (above < 8 ? above : 15 - above) {
            case 1:
                return join(left, bottom);
            case 2:
                return join(bottom, right);
            case 3:
                return join(left, right);
            case 4:
                return join(right, top);
            case 6:
                return join(bottom, top);
            case 7:
                return join(left, top);
            case 5: {
                // If the saddle of the bilinear interpolant is above the level, it joins the two corners above.
                const double saddle = (corners[0] * corners[2] - corners[1] * corners[3]) /
                                      (corners[0] + corners[2] - corners[1] - corners[3]);
                const bool first_joined = (saddle >= level_) == (above == 5);
                join(left, first_joined ? top : bottom);
                join(first_joined ? bottom : top, right);
                return;
            }
            default:
                return;
        }
    }

    void join(Edge one, Edge other) {
        link(one, other);
        link(other, one);
    }

    void link(Edge from, Edge to) {
        const auto [entry, fresh] = links_.try_emplace(from, Links{to, none});
        if (fresh)
            order_.push_back(from);
        else
            entry->second[1] = to;
    }

    bool drawn(Edge edge) const { return links_.at(edge)[0] == none; }

    // Takes the line out of the links, edge by edge.
    Polyline follow(Edge edge) {
        Polyline line;
        Edge before = none;
        while (edge != none) {
            line.push_back(point_on(edge));
            Links& links = links_.at(edge);
            const Edge next = links[0] == before ? links[1] : links[0];
            links = {none, none};
            before = edge;
            edge = next != none && !drawn(next) ? next : none;
        }
        return line;
    }

    PlanePoint point_on(Edge edge) const {
        const std::int64_t column = edge / 2 % plane_.size[0];
        const std::int64_t row = edge / 2 / plane_.size[0];
        const bool upwards = edge % 2 == 1;
        const double from = plane_.sample(column, row);
        const double to = upwards ? plane_.sample(column, row + 1) : plane_.sample(column + 1, row);
        const double part = (level_ - from) / (to - from);
        return {static_cast<double>(column) + (upwards ? 0 : part), static_cast<double>(row) + (upwards ? part : 0)};
    }

    const Plane& plane_;
    double level_;
    std::unordered_map<Edge, Links> links_;
    std::vector<Edge> order_;
};

}  // namespace

std::vector<Polyline> iso_lines(const Plane& plane, double level) {
    return Tracer(plane, level).lines();
}

}  // namespace clsdf::picture
