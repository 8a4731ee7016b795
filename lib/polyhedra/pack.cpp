#include "polyhedra/pack.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace clsdf::polyhedra {

namespace {

/// Stores x as the sum of two floats. The high one is cut out of x by Veltkamp's product, because g++ 12 takes the
/// float rounding out of x - static_cast<double>(static_cast<float>(x)) where it vectorizes two of them, and leaves 0.
void split(double x, float& high, float& low) {
    constexpr double shift = (1 << 29) + 1;  // of the 53 bits of a double, a float has 24
    const double product = shift * x;
    const double rounded = product - (product - x);
    high = static_cast<float>(rounded);
    low = static_cast<float>(x - rounded);
}

/// The nearest sample along an axis. Beyond the clamp the offset in the constants does the rest.
clsdf_int32 nearest_sample(double samples) {
    constexpr double limit = 1 << 30;
    return static_cast<clsdf_int32>(std::nearbyint(std::clamp(samples, -limit, limit)));
}

/// Steps along (i, j, k) of the lattice, of a quantity whose metric gradient is given.
Vector steps(const Vector& gradient, const LatticeView& lattice) {
    return gradient.cwiseProduct(to_vector(lattice.spacing_in_units)).cwiseAbs();
}

bool is_compact(const TriangleFrame& frame, const Polyhedron& polyhedron) {
    const auto is_flat = [](float slope) { return slope <= 1; };
    return std::min(frame.normal_along[0], frame.normal_along[1]) > 0.15 &&
           std::all_of(polyhedron.slope_above, polyhedron.slope_above + 3, is_flat) &&
           std::all_of(polyhedron.slope_below, polyhedron.slope_below + 3, is_flat);
}

void pack_origin(const TriangleFrame& frame, const LatticeView& lattice, Polyhedron& polyhedron) {
    const Vector spacing = to_vector(lattice.spacing_in_units);
    const Vector samples = frame.foot.cwiseQuotient(spacing);
    polyhedron.origin_x = nearest_sample(samples.x());
    polyhedron.origin_y = nearest_sample(samples.y());
    polyhedron.origin_z = nearest_sample(samples.z());
    const Vector origin(polyhedron.origin_x, polyhedron.origin_y, polyhedron.origin_z);
    const Vector offset = frame.foot - origin.cwiseProduct(spacing);
    split(-frame.along.dot(offset), polyhedron.constant_high[0], polyhedron.constant_low[0]);
    split(-frame.across.dot(offset), polyhedron.constant_high[1], polyhedron.constant_low[1]);
    split(-frame.normal.dot(offset), polyhedron.constant_high[2], polyhedron.constant_low[2]);
}

void pack_gradients(const TriangleFrame& frame, const LatticeView& lattice, Polyhedron& polyhedron) {
    const auto pack_axis = [&](int axis, float* high, float* low) {
        const double spacing = lattice.spacing_in_units[static_cast<std::size_t>(axis)];
        split(frame.along[axis] * spacing, high[0], low[0]);
        split(frame.across[axis] * spacing, high[1], low[1]);
        split(frame.normal[axis] * spacing, high[2], low[2]);
    };
    pack_axis(0, polyhedron.gradient_x_high, polyhedron.gradient_x_low);
    pack_axis(1, polyhedron.gradient_y_high, polyhedron.gradient_y_low);
    pack_axis(2, polyhedron.gradient_z_high, polyhedron.gradient_z_low);
}

void pack_reaches(const TriangleFrame& frame, const LatticeView& lattice, Polyhedron& polyhedron) {
    const auto slanted = [&](std::size_t half) {
        const double along = half == CLSDF_HALF_RIGHT ? frame.normal_along[half] : -frame.normal_along[half];
        return Vector(along * frame.along + frame.normal_across[half] * frame.across);
    };
    const Vector directions[] = {frame.along, frame.across, frame.normal, slanted(CLSDF_HALF_RIGHT),
                                 slanted(CLSDF_HALF_LEFT)};
    for (std::size_t i = 0; i < 5; ++i) {
        const Vector step = steps(directions[i], lattice);
        polyhedron.reach_cube[i] = widened(step.sum());
        polyhedron.reach_4x2x2[i] = widened(1.5 * step.x() + 0.5 * step.y() + 0.5 * step.z());
    }
}

}  // namespace

Polyhedron pack(const TriangleFrame& frame, const FaceEdges& edges, std::uint32_t triangle,
                const LatticeView& lattice) {
    Polyhedron polyhedron{};
    pack_origin(frame, lattice, polyhedron);
    pack_gradients(frame, lattice, polyhedron);
    pack_reaches(frame, lattice, polyhedron);
    split(frame.altitude(), polyhedron.altitude_high, polyhedron.altitude_low);
    for (std::size_t half = 0; half < 2; ++half) {
        split(frame.base[half], polyhedron.base_high[half], polyhedron.base_low[half]);
        split(frame.normal_along[half], polyhedron.normal_along_high[half], polyhedron.normal_along_low[half]);
        split(frame.normal_across[half], polyhedron.normal_across_high[half], polyhedron.normal_across_low[half]);
    }
    for (std::uint32_t k = 0; k < 3; ++k) {
        polyhedron.slope_above[frame.polyhedron_edge(k)] = edges.above[k];
        polyhedron.slope_below[frame.polyhedron_edge(k)] = edges.below[k];
    }
    polyhedron.triangle = triangle;
    polyhedron.flags = is_compact(frame, polyhedron) ? CLSDF_POLYHEDRON_COMPACT : 0;
    return polyhedron;
}

}  // namespace clsdf::polyhedra
