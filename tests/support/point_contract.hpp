#pragma once

#include "winding.hpp"

#include <clsdf/clsdf.hpp>
#include <clsdf/reference.hpp>

#include <fmt/format.h>
#include <Eigen/Geometry>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <optional>
#include <string>

namespace clsdf::test {

/// The contract of docs/accuracy.md, 'Points', at points that lie on no grid: all outputs of a query. That an edge or a
/// vertex has the name of the lowest triangle, and the pseudonormal, are left to reference::check().
class PointContract {
public:
    /// The mesh must outlive this. `sign` is DistanceTransform::sign(): nonzero, parity or none.
    PointContract(const Mesh& mesh, SignRule sign, double half_width)
        : mesh_(mesh), oracle_(mesh), sign_(sign), half_width_(half_width) {
        const double side = mesh.box().longest_side();
        voxel_ = side > 0 ? side / 256 : 1;
    }

    /// Says how point number i of a query is wrong; empty if it is right.
    std::string fault(const Vec3& point, const Field& field, std::size_t i) const {
        const Truth truth = truth_at(point);
        const double limit = static_cast<double>(static_cast<float>(half_width_));
        const bool is_left = field.triangle()[i] == no_triangle;
        if (std::string wrong = wrong_sign(truth, field.distance()[i]); !wrong.empty()) return wrong;
        const double found = std::fabs(static_cast<double>(field.distance()[i]));
        if (is_left && truth.distance >= half_width_ - truth.rounding) {
            if (found == limit && are_left(field, i)) return {};
            return fmt::format("beyond the limit, with the distance {} or with another output", found);
        }
        if (is_left) return fmt::format("the distance is {}, but no triangle is named", truth.distance);
        if (truth.distance > half_width_ + truth.rounding)
            return fmt::format("the distance is {}, beyond the limit, but a triangle is named", truth.distance);
        // The final rounding to a float.
        if (!(std::fabs(found - truth.distance) <= half_ulp(truth.distance) + truth.rounding))
            return fmt::format("the distance is {:.9g} instead of {:.17g}", found, truth.distance);
        return wrong_outputs(truth, field, i);
    }

private:
    using Vector = Eigen::Vector3d;
    using Corners = std::array<Vec3, 3>;

    struct Truth {
        Vec3 point{};
        double distance = 0;
        double rounding = 0;  ///< of a distance in double precision
        bool is_inside = false;
        bool is_on_surface = false;
    };

    static Vector vector(const Vec3& v) { return {v[0], v[1], v[2]}; }
    template <typename Values>
    static Vector vector_at(const Values& values, std::size_t i) {
        return {static_cast<double>(values[3 * i]), static_cast<double>(values[3 * i + 1]),
                static_cast<double>(values[3 * i + 2])};
    }
    static double half_ulp(double distance) {
        const auto value = static_cast<float>(distance);
        return static_cast<double>(std::nextafter(value, std::numeric_limits<float>::infinity()) - value) / 2;
    }
    static double distance_to(const Vec3& point, const Corners& corners) {
        return reference::nearest_on_triangle(point, corners[0], corners[1], corners[2]).distance;
    }

    Truth truth_at(const Vec3& point) const {
        Truth truth;
        truth.point = point;
        truth.distance = oracle_.nearest(point).distance;
        // 1e-13 in the documentation, "about".
        truth.rounding = 4e-13 * std::max(256 * voxel_, truth.distance);
        if (sign_ == SignRule::none) return truth;
        if (sign_ == SignRule::solid_angle) {
            truth.is_on_surface = truth.distance == 0;
            truth.is_inside = !truth.is_on_surface && std::abs(winding_by_faces(mesh_, point)) >= 0.5;
            return truth;
        }
        const std::optional<int> count =
            sign_ == SignRule::parity ? oracle_.crossings(point) : oracle_.winding_number(point);
        truth.is_on_surface = !count;
        truth.is_inside = count && (sign_ == SignRule::parity ? *count % 2 != 0 : *count != 0);
        return truth;
    }

    static std::string wrong_sign(const Truth& truth, float found) {
        if (truth.is_on_surface && (found != 0 || std::signbit(found)))
            return fmt::format("on the surface, but the distance is {}", found);
        if (std::signbit(found) != truth.is_inside && static_cast<float>(truth.distance) != 0)
            return fmt::format("{}, but the distance is {}", truth.is_inside ? "inside" : "outside", found);
        return {};
    }

    static bool are_left(const Field& field, std::size_t i) {
        return field.site()[i] == no_site && vector_at(field.closest(), i).array().isNaN().all() &&
               vector_at(field.offset(), i).array().isNaN().all() &&
               vector_at(field.gradient(), i).array().isNaN().all() && std::isnan(field.barycentric()[2 * i]) &&
               std::isnan(field.barycentric()[2 * i + 1]);
    }

    /// The site's corners, the last one repeated.
    static Corners corners_of(const Corners& triangle, std::size_t site) {
        if (site == 6) return triangle;
        const Vec3& first = triangle[site % 3];
        const Vec3& second = site < 3 ? first : triangle[(site + 1) % 3];
        return {first, second, second};
    }

    /// From a point to the line or plane of a site.
    static double distance_to_extension(const Vec3& point, const Corners& site, std::size_t number) {
        const Vector from = vector(point) - vector(site[0]), along = vector(site[1]) - vector(site[0]);
        if (number < 3) return from.norm();
        if (number == 6) return std::fabs(along.cross(vector(site[2]) - vector(site[0])).stableNormalized().dot(from));
        const Vector direction = along.stableNormalized();
        return (from - from.dot(direction) * direction).norm();
    }

    std::string wrong_outputs(const Truth& truth, const Field& field, std::size_t i) const {
        const std::uint32_t triangle = field.triangle()[i];
        if (triangle >= mesh_.triangles().size()) return fmt::format("triangle {} is not in the mesh", triangle);
        const auto& [a, b, c] = mesh_.triangles()[triangle];
        const Corners corners{mesh_.vertices()[a], mesh_.vertices()[b], mesh_.vertices()[c]};
        const double of_triangle = distance_to(truth.point, corners);
        if (!(of_triangle <= truth.distance + truth.rounding))
            return fmt::format("triangle {} is {:.17g} away, another one {:.17g}", triangle, of_triangle,
                               truth.distance);

        const std::size_t number = field.site()[i];
        if (number > 6) return fmt::format("{} is no site", number);
        const Corners site = corners_of(corners, number);
        const double accuracy = std::max(1e-5 * voxel_, 4 * half_ulp(truth.distance));
        if (!(distance_to(truth.point, site) <= truth.distance + truth.rounding) ||
            !(distance_to_extension(truth.point, site, number) >= truth.distance - accuracy))
            return fmt::format("site {} of triangle {} is not nearest", number, triangle);

        const Vector closest = vector_at(field.closest(), i), from = vector(truth.point) - closest;
        // The closest point is the point less their offset: a far point's own rounding counts, as in
        // reference::check().
        const double coordinate = 4 * std::numeric_limits<double>::epsilon() *
                                  std::max(closest.cwiseAbs().maxCoeff(), vector(truth.point).cwiseAbs().maxCoeff());
        const double away = distance_to({closest[0], closest[1], closest[2]}, corners_of(corners, number));
        if (!(away <= 1e-6 * voxel_ + coordinate))
            return fmt::format("the closest point is {} off site {} of triangle {}", away, number, triangle);
        if (!(std::fabs(from.norm() - truth.distance) <= truth.rounding + coordinate))
            return fmt::format("the closest point is {:.17g} away instead of {:.17g}", from.norm(), truth.distance);

        const auto u = static_cast<double>(field.barycentric()[2 * i]),
                   v = static_cast<double>(field.barycentric()[2 * i + 1]);
        const Vector second = vector(corners[1]) - vector(corners[0]), third = vector(corners[2]) - vector(corners[0]);
        const double weights_off = (vector(corners[0]) + u * second + v * third - closest).norm();
        if (!(u >= 0 && v >= 0 && u <= 1 && v <= 1 && u + v <= 1 + 2e-7) ||
            !(weights_off <= 1e-6 * voxel_ + 2e-7 * (second.norm() + third.norm()) + coordinate))
            return fmt::format("({}, {}) are the weights of a point that is {} off", u, v, weights_off);

        const double offset_off = (vector_at(field.offset(), i) + from).norm();
        if (!(offset_off <= 2e-7 * truth.distance + truth.rounding + coordinate))
            return fmt::format("the offset is {} off", offset_off);

        // On the surface it is the pseudonormal, or NaN if no face at the site has an area.
        if (truth.distance <= 1e-6 * voxel_) return {};
        const Vector gradient = vector_at(field.gradient(), i);
        const double off = (gradient - (truth.is_inside ? -1 : 1) * from.normalized()).norm();
        if (std::fabs(gradient.norm() - 1) <= 1e-6 &&
            off <= 1e-5 + (2e-6 * voxel_ + truth.rounding + coordinate) / truth.distance)
            return {};
        return fmt::format("the gradient ({}, {}, {}) is off by {}", gradient[0], gradient[1], gradient[2], off);
    }

    const Mesh& mesh_;
    reference::Oracle oracle_;
    SignRule sign_;
    double half_width_;
    double voxel_;
};

}  // namespace clsdf::test
