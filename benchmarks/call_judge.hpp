#pragma once

#include "benchmarks/calls.hpp"

#include <clsdf/reference.hpp>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <optional>
#include <random>
#include <span>

namespace clsdf::bench {

/// A field with the offsets to the closest points, and the gradients.
struct FieldWithOutputs {
    Field field;
    FieldArray<float> offset, gradient;

    OutputTargets targets() {
        return {{Output::distance, field.distance()}, {Output::offset, offset}, {Output::gradient, gradient}};
    }
};

/// Compares random samples of fields with the reference.
class CallJudge {
public:
    CallJudge(const Mesh& mesh, std::uint64_t seed) : oracle_(mesh), random_(seed) {}

    void look_at(const Field& field, std::size_t samples, CallCost& cost) {
        std::uniform_int_distribution<std::size_t> any(0, field.distance().size() - 1);
        for (std::size_t n = 0; n < samples; ++n) look_at_sample(field, any(random_), cost);
    }

    /// A sample with an output that breaks its contract is wrong, too.
    void look_at(const FieldWithOutputs& outputs, std::size_t samples, CallCost& cost) {
        std::uniform_int_distribution<std::size_t> any(0, outputs.field.distance().size() - 1);
        for (std::size_t n = 0; n < samples; ++n) {
            const std::size_t offset = any(random_), wrong = cost.wrong;
            look_at_sample(outputs.field, offset, cost);
            if (cost.wrong == wrong && !has_right_outputs(outputs, offset)) ++cost.wrong;
        }
    }

    /// Random points of those of a query without a limit. A voxel is that of a grid of 256 samples a side.
    void look_at(std::span<const Vec3> points, std::span<const float> distance, double voxel, std::size_t samples,
                 CallCost& cost) {
        std::uniform_int_distribution<std::size_t> any(0, points.size() - 1);
        for (std::size_t n = 0; n < samples; ++n) {
            const std::size_t i = any(random_);
            look_at_value(points[i], static_cast<double>(distance[i]), Band::full(), voxel, cost);
        }
    }

    /// A point of each of some boxes: wrong if it belies the box's place.
    void look_at(std::span<const Box> boxes, std::span<const BoxPlace> places, double half_width, std::size_t samples,
                 CallCost& cost) {
        std::uniform_int_distribution<std::size_t> any(0, boxes.size() - 1);
        std::uniform_real_distribution<double> part(0, 1);
        for (std::size_t n = 0; n < samples; ++n) {
            const std::size_t i = any(random_);
            const auto& [lower, upper] = boxes[i];
            Vec3 point{};
            for (std::size_t axis = 0; axis < 3; ++axis)
                point[axis] = std::lerp(lower[axis], upper[axis], part(random_));
            ++cost.judged;
            if (places[i] == BoxPlace::within) continue;
            const std::optional<int> winding = oracle_.winding_number(point);
            const BoxPlace expected = winding.has_value() && *winding != 0 ? BoxPlace::inside : BoxPlace::outside;
            if (places[i] != expected || oracle_.nearest(point).distance <= half_width) ++cost.wrong;
        }
    }

private:
    static Vec3 position_of(const Grid& grid, std::size_t offset) {
        const auto nx = static_cast<std::size_t>(grid.size[0]), ny = static_cast<std::size_t>(grid.size[1]);
        const Index3 at{static_cast<std::int64_t>(offset % nx), static_cast<std::int64_t>(offset / nx % ny),
                        static_cast<std::int64_t>(offset / (nx * ny))};
        Vec3 point{};
        for (std::size_t axis = 0; axis < 3; ++axis)
            point[axis] = grid.origin[axis] + static_cast<double>(grid.first[axis] + at[axis]) * grid.spacing[axis];
        return point;
    }

    /// The closest point is on the surface, at the distance of the sample, and the gradient leads away from it; beyond
    /// the band there is none.
    bool has_right_outputs(const FieldWithOutputs& outputs, std::size_t offset) const {
        const Field& field = outputs.field;
        const Vec3 sample = position_of(field.grid, offset);
        const auto signed_distance = static_cast<double>(field.distance()[offset]);
        const double distance = std::abs(signed_distance), voxel = field.grid.voxel();
        double squared = 0, along = 0, squared_gradient = 0;
        Vec3 point{};
        for (std::size_t axis = 0; axis < 3; ++axis) {
            const auto to_point = static_cast<double>(outputs.offset[3 * offset + axis]);
            const auto gradient = static_cast<double>(outputs.gradient[3 * offset + axis]);
            point[axis] = sample[axis] + to_point;
            squared += to_point * to_point;
            squared_gradient += gradient * gradient;
            along -= gradient * to_point;
        }
        if (distance >= (signed_distance < 0 ? field.band.inside : field.band.outside))
            return std::isnan(squared) && std::isnan(squared_gradient);
        const double rounding = distance * static_cast<double>(std::numeric_limits<float>::epsilon());
        const double tolerance = 1e-6 * voxel + 2 * rounding;
        return std::abs(std::sqrt(squared) - distance) <= 1e-5 * voxel + 2 * rounding &&
               oracle_.nearest(point).distance <= tolerance && std::abs(squared_gradient - 1) <= 1e-5 &&
               std::abs(along - signed_distance) <= 1e-5 * voxel + 1e-5 * distance;
    }

    void look_at_sample(const Field& field, std::size_t offset, CallCost& cost) {
        look_at_value(position_of(field.grid, offset), static_cast<double>(field.distance()[offset]), field.band,
                      field.grid.voxel(), cost);
    }

    void look_at_value(const Vec3& point, double value, const Band& band, double voxel, CallCost& cost) {
        const double distance = oracle_.nearest(point).distance;
        const std::optional<int> winding = oracle_.winding_number(point);
        const bool inside = winding.has_value() && *winding != 0;
        const double expected = inside ? -std::min(distance, band.inside) : std::min(distance, band.outside);
        const double error = std::abs(value - expected);
        const double ulp = std::abs(expected) * static_cast<double>(std::numeric_limits<float>::epsilon());
        ++cost.judged;
        if (!(error <= std::max(2 * ulp, 1e-5 * voxel))) ++cost.wrong;
        if (distance < (inside ? band.inside : band.outside))
            cost.max_error_voxels = std::max(cost.max_error_voxels, error / voxel);
    }

    reference::Oracle oracle_;
    std::mt19937_64 random_;
};

}  // namespace clsdf::bench
