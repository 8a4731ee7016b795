#include "io/meshes/placement.hpp"

#include "core/refuse.hpp"
#include "tools/text.hpp"

#include <clsdf/error.hpp>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <string_view>
#include <utility>
#include <vector>

namespace clsdf {

namespace {

using Rotation = std::array<Vec3, 3>;  // by rows

constexpr Rotation identity{{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};

/// The cosine and the sine, exact for multiples of 90 degrees.
std::pair<double, double> cosine_and_sine(double degrees) {
    const double rest = std::remainder(degrees, 360);
    if (rest == 0) return {1, 0};
    if (rest == 90) return {0, 1};
    if (rest == -90) return {0, -1};
    if (std::abs(rest) == 180) return {-1, 0};
    const double angle = rest / 180 * std::numbers::pi;
    return {std::cos(angle), std::sin(angle)};
}

/// The rotation, and then one about an axis.
Rotation then_about(std::size_t axis, double degrees, const Rotation& before) {
    const auto [cosine, sine] = cosine_and_sine(degrees);
    const std::size_t b = (axis + 1) % 3, c = (axis + 2) % 3;
    Rotation result = before;
    for (std::size_t column = 0; column < 3; ++column) {
        result[b][column] = cosine * before[b][column] - sine * before[c][column];
        result[c][column] = sine * before[b][column] + cosine * before[c][column];
    }
    return result;
}

struct Up {
    std::string_view name;
    std::size_t axis;  ///< to rotate about
    double degrees;
};
constexpr std::array<Up, 6> ups{
    {{"x", 1, -90}, {"y", 0, 90}, {"z", 0, 0}, {"-x", 1, 90}, {"-y", 0, -90}, {"-z", 0, 180}}};

Rotation rotation_of(const ReadOptions& options) {
    const auto up = std::ranges::find(ups, options.up, &Up::name);
    if (up == ups.end()) refuse("up: {} is no axis; give x, y, z, -x, -y or -z", clsdf::quoted(options.up));
    Rotation rotation = then_about(up->axis, up->degrees, identity);
    for (std::size_t axis = 0; axis < 3; ++axis) rotation = then_about(axis, options.rotate[axis], rotation);
    return rotation;
}

}  // namespace

void check_placement(const ReadOptions& options) {
    if (!(options.scale > 0) || !std::isfinite(options.scale))
        refuse("scale: {} is no factor for lengths; give a finite number above 0", options.scale);
    for (const double angle : options.rotate)
        if (!std::isfinite(angle)) refuse("rotate: {} is no angle; give three finite numbers, in degrees", angle);
    for (const double step : options.translate)
        if (!std::isfinite(step)) refuse("translate: {} is no length; give three finite numbers", step);
    static_cast<void>(rotation_of(options));
}

Mesh placed(Mesh mesh, const ReadOptions& options) {
    const Rotation rotation = rotation_of(options);
    const bool is_rotated = rotation != identity;
    if (options.scale == 1 && options.translate == Vec3{} && !is_rotated) return mesh;
    std::vector<Vec3> positions = mesh.vertices();
    for (Vec3& position : positions) {
        for (double& coordinate : position) coordinate *= options.scale;
        const Vec3 from = position;
        for (std::size_t axis = 0; axis < 3; ++axis) {
            const Vec3& row = rotation[axis];
            if (is_rotated) position[axis] = row[0] * from[0] + row[1] * from[1] + row[2] * from[2];
            position[axis] += options.translate[axis];
        }
    }
    try {
        mesh.set_positions(std::move(positions));
    } catch (const Error& error) {
        refuse("{}, after the scale {} and the translation ({}); choose smaller ones", error.what(), options.scale,
               fmt::join(options.translate, ", "));
    }
    return mesh;
}

}  // namespace clsdf
