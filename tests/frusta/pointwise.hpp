#pragma once

#include "frusta/leaned_frusta.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

/// The records of kernels/common/polyhedron.h at one point of the lattice, in double and in float.
namespace clsdf::test {

/// A polyhedron and its triangle, evaluated in double precision from the sums of the record's floats. Points are given
/// in samples of the lattice and need not be integers.
class PointwisePolyhedron {
public:
    PointwisePolyhedron(const Polyhedron& record, double cap, double slack)
        : record_(record), cap_(cap), slack_(slack) {
        for (std::size_t i = 0; i < 3; ++i) {
            gradients_[0][i] = record.exact_gradient_x[i];
            gradients_[1][i] = record.exact_gradient_y[i];
            gradients_[2][i] = record.exact_gradient_z[i];
            constant_[i] = record.exact_constant_at_origin[i];
        }
        for (std::size_t half = 0; half < 2; ++half) {
            base_[half] = record.exact_base[half];
            along_[half] = record.exact_normal_along[half];
            across_[half] = record.exact_normal_across[half];
        }
        altitude_ = record.exact_altitude;
    }

    /// (X, Y, Z) of the point.
    Vec3 frame(const Vec3& point) const {
        const Vec3 offset{point[0] - record_.origin_x, point[1] - record_.origin_y, point[2] - record_.origin_z};
        Vec3 frame{};
        for (std::size_t i = 0; i < 3; ++i)
            frame[i] = offset[0] * gradients_[0][i] + offset[1] * gradients_[1][i] + offset[2] * gradients_[2][i] +
                       constant_[i];
        return frame;
    }

    bool contains(const Vec3& point) const {
        const auto [x, y, z] = frame(point);
        return std::abs(z) <= cap_ + slack_ && x <= base_[CLSDF_HALF_RIGHT] + cap_ + slack_ &&
               -x <= base_[CLSDF_HALF_LEFT] + cap_ + slack_ && -y <= limit(CLSDF_EDGE_BASE, z) &&
               beyond_slanted(CLSDF_HALF_RIGHT, x, y) <= limit(CLSDF_EDGE_RIGHT, z) &&
               beyond_slanted(CLSDF_HALF_LEFT, -x, y) <= limit(CLSDF_EDGE_LEFT, z);
    }

    /// To the triangle: the nearer half decides.
    double distance(const Vec3& point) const {
        const auto [x, y, z] = frame(point);
        const std::size_t half = x >= 0 ? CLSDF_HALF_RIGHT : CLSDF_HALF_LEFT;
        const double beyond = std::abs(x) - base_[half];
        if (y < 0) return norm(std::max(beyond, 0.0), y, z);
        const double outward = along_[half] * beyond + across_[half] * y;
        const double position = along_[half] * y - across_[half] * beyond;
        const double past = position - length(half);
        return norm(std::max(past, std::min(position, 0.0)), std::max(outward, 0.0), z);
    }

    /// Ends of the base and the apex, in samples.
    std::array<Vec3, 3> corners() const {
        return {sample_at({base_[CLSDF_HALF_RIGHT], 0, 0}), sample_at({-base_[CLSDF_HALF_LEFT], 0, 0}),
                sample_at({0, altitude_, 0})};
    }

    double altitude() const { return altitude_; }
    double length(std::size_t half) const { return std::hypot(base_[half], altitude_); }

private:
    static double norm(double x, double y, double z) { return std::sqrt(x * x + y * y + z * z); }

    double beyond_slanted(std::size_t half, double away, double y) const {
        return along_[half] * (away - base_[half]) + across_[half] * y;
    }

    double limit(std::size_t edge, double z) const {
        const double above = static_cast<double>(record_.slope_above[edge]) * (z + slack_);
        const double below = static_cast<double>(record_.slope_below[edge]) * (slack_ - z);
        return std::min(std::max(above, below), cap_) + slack_;
    }

    Vec3 sample_at(const Vec3& frame) const {
        Vec3 sample{static_cast<double>(record_.origin_x), static_cast<double>(record_.origin_y),
                    static_cast<double>(record_.origin_z)};
        for (std::size_t axis = 0; axis < 3; ++axis) {
            double squared = 0;
            double product = 0;
            for (std::size_t i = 0; i < 3; ++i) {
                squared += gradients_[axis][i] * gradients_[axis][i];
                product += gradients_[axis][i] * (frame[i] - constant_[i]);
            }
            sample[axis] += product / squared;
        }
        return sample;
    }

    Polyhedron record_;
    double cap_;
    double slack_;
    std::array<std::array<double, 3>, 3> gradients_{};
    std::array<double, 3> constant_{};
    std::array<double, 2> base_{};
    std::array<double, 2> along_{};
    std::array<double, 2> across_{};
    double altitude_ = 0;
};

/// Membership as a device decides it: offsets at the centre of the sample's brick (8 x 8 x 8 samples) in double, or of
/// a small triangle in float from its integer origin; the rest in float. The sample is an integer point.
inline bool contains_in_float(const Polyhedron& p, const Vec3& sample, float cap, float slack) {
    std::array<double, 3> centre{};  // from the integer origin
    std::array<float, 3> step{};
    const std::array<clsdf_int32, 3> origin{p.origin_x, p.origin_y, p.origin_z};
    for (std::size_t axis = 0; axis < 3; ++axis) {
        const double brick_centre = 8 * std::floor(sample[axis] / 8) + 3.5;
        centre[axis] = brick_centre - origin[axis];
        step[axis] = static_cast<float>(sample[axis] - brick_centre);
    }
    const bool near = (p.flags & CLSDF_POLYHEDRON_NEAR) != 0;
    std::array<double, 3> at_centre{};
    std::array<float, 3> moved{};
    for (std::size_t i = 0; i < 3; ++i) {
        if (near) {
            const auto x = static_cast<float>(centre[0]), y = static_cast<float>(centre[1]),
                       z = static_cast<float>(centre[2]);
            const float rounded =
                x * p.gradient_x[i] + (y * p.gradient_y[i] + (z * p.gradient_z[i] + p.constant_at_origin[i]));
            at_centre[i] = static_cast<double>(rounded);
        } else {
            at_centre[i] = p.exact_gradient_x[i] * centre[0] + p.exact_gradient_y[i] * centre[1] +
                           p.exact_gradient_z[i] * centre[2] + p.exact_constant_at_origin[i];
        }
        moved[i] = step[0] * p.gradient_x[i] + (step[1] * p.gradient_y[i] + step[2] * p.gradient_z[i]);
    }
    const float z = static_cast<float>(at_centre[2]) + moved[2];
    const auto limit = [&](std::size_t edge) {
        const float slope = std::max(p.slope_above[edge] * (z + slack), p.slope_below[edge] * (slack - z));
        const bool compact = (p.flags & CLSDF_POLYHEDRON_COMPACT) != 0;
        return (compact ? slope : std::min(slope, cap)) + slack;
    };
    bool inside =
        std::abs(z) <= cap + slack && -(static_cast<float>(at_centre[1]) + moved[1]) <= limit(CLSDF_EDGE_BASE);
    for (const std::size_t half : std::array<std::size_t, 2>{CLSDF_HALF_RIGHT, CLSDF_HALF_LEFT}) {
        const double side = half == CLSDF_HALF_RIGHT ? 1 : -1;
        double beyond = side * at_centre[0] - p.exact_base[half];
        double outward = p.exact_normal_along[half] * beyond + p.exact_normal_across[half] * at_centre[1];
        if (near) {
            const float rounded = static_cast<float>(side * at_centre[0]) - p.base[half];
            beyond = static_cast<double>(rounded);
            outward = static_cast<double>(p.normal_along[half] * rounded +
                                          p.normal_across[half] * static_cast<float>(at_centre[1]));
        }
        const float away = static_cast<float>(side) * moved[0];
        const std::size_t edge = half == CLSDF_HALF_RIGHT ? CLSDF_EDGE_RIGHT : CLSDF_EDGE_LEFT;
        inside &= static_cast<float>(outward) + (p.normal_along[half] * away + p.normal_across[half] * moved[1]) <=
                  limit(edge);
        if (!(p.flags & CLSDF_POLYHEDRON_COMPACT)) inside &= static_cast<float>(beyond) + away <= cap + slack;
    }
    return inside;
}

}  // namespace clsdf::test
