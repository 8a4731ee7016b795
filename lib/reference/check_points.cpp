#include "core/parallel.hpp"
#include "core/refuse.hpp"
#include "true_samples.hpp"

#include <clsdf/reference.hpp>

#include <fmt/format.h>
#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <limits>

namespace clsdf::reference {

namespace {

constexpr std::size_t kept_findings = 10;
// In voxels of 1/256 of the longest side, as in output_contracts.cpp.
constexpr double closest_tolerance = 1e-6;
constexpr double direction_tolerance_voxels = 2e-6;
constexpr double direction_tolerance = 1e-5;
constexpr double on_surface_voxels = 1e-10;

using Eigen::Vector3d;

Vector3d vector_of(const Vec3& v) {
    return {v[0], v[1], v[2]};
}

/// The rounding of positions of this size.
double rounding_at(const Vec3& point, const Vec3& place) {
    return 4 * std::numeric_limits<double>::epsilon() *
           std::max(vector_of(point).cwiseAbs().maxCoeff(), vector_of(place).cwiseAbs().maxCoeff());
}

double two_last_places(double distance) {
    const auto nearest = static_cast<float>(distance);
    if (!std::isfinite(nearest)) return 0;
    return 2 * (static_cast<double>(std::nextafter(nearest, std::numeric_limits<float>::infinity())) -
                static_cast<double>(nearest));
}

/// Judges one point after the other.
class PointJudge {
public:
    /// All must outlive this.
    PointJudge(const TrueSamples& truths, std::span<const Vec3> points, const PointResults& results,
               const PointCheckOptions& options, double voxel)
        : truths_(truths), points_(points), results_(results), options_(options), voxel_(voxel) {
        if (!truths.sign_surface().vertices.empty()) joined_margin_ = 256e-12 * voxel;
    }

    void judge(std::size_t number, PointCheckReport& report) const {
        const Vec3& point = points_[number];
        if (!vector_of(point).array().isFinite().all()) return;
        const Case one{number, point, truths_.at(ExactPosition{point, {}}), report};
        ++report.points;
        judge_distance(one);
        judge_sign(one);
        if (!results_.closest.empty()) judge_closest(one);
        if (!results_.gradients.empty()) judge_gradient(one);
        if (!results_.triangles.empty()) judge_triangle(one);
    }

private:
    struct Case {
        std::size_t number;
        const Vec3& point;
        TrueSample truth;
        PointCheckReport& report;

        void find(std::size_t& counter, std::string what) const {
            ++counter;
            if (report.findings.size() < kept_findings) report.findings.push_back({number, std::move(what)});
        }
    };

    double allowed(const Case& one) const {
        // The reference is computed in double.
        if (options_.tolerance) return std::max(*options_.tolerance, rounding_at(one.point, one.truth.point));
        return std::max(1e-5 * voxel_, two_last_places(one.truth.distance));
    }

    void judge_distance(const Case& one) const {
        const double found = results_.distances[one.number];
        const double error = std::fabs(std::fabs(found) - one.truth.distance);
        one.report.max_error =
            std::max(one.report.max_error, std::isnan(error) ? std::numeric_limits<double>::infinity() : error);
        if (!(error <= allowed(one)))
            one.find(one.report.wrong_distances,
                     fmt::format("the distance is {} instead of {}", found, one.truth.signed_distance()));
    }

    void judge_sign(const Case& one) const {
        const double found = results_.distances[one.number];
        if (std::isnan(found)) return;
        if (!truths_.is_signed()) {
            if (found < 0)
                one.find(one.report.wrong_signs, fmt::format("the mesh has no inside, but {} is negative", found));
            return;
        }
        if (one.truth.on_surface || one.truth.in_doubt || one.truth.distance <= joined_margin_) return;
        // So near to the surface that a float of the distance is 0.
        if (found == 0 && static_cast<float>(one.truth.distance) == 0) return;
        if (std::signbit(found) != one.truth.inside)
            one.find(one.report.wrong_signs,
                     fmt::format("{}, but the distance is {}", one.truth.inside ? "inside" : "outside", found));
    }

    void judge_closest(const Case& one) const {
        const Vec3& place = results_.closest[one.number];
        const double rounding = rounding_at(one.point, one.truth.point);
        const double away = (vector_of(one.point) - vector_of(place)).norm();
        if (!(std::fabs(away - one.truth.distance) <= allowed(one) + rounding)) {
            one.find(one.report.wrong_closest,
                     fmt::format("the closest point is {} away instead of {}", away, one.truth.distance));
            return;
        }
        const double off = truths_.tree().nearest({place, {}})->distance;
        if (!(off <= std::max(closest_tolerance * voxel_, options_.tolerance.value_or(0)) + rounding))
            one.find(one.report.wrong_closest, fmt::format("the closest point is {} off the surface", off));
    }

    void judge_gradient(const Case& one) const {
        const double distance = one.truth.distance;
        if (distance <= on_surface_voxels * voxel_) return;  // it may be any normal of the site
        const Vec3& given = results_.gradients[one.number];
        const Vector3d gradient = vector_of(given);
        const auto wrong = [&](double off) {
            one.find(one.report.wrong_gradients,
                     fmt::format("the gradient ({}, {}, {}) is off by {}", given[0], given[1], given[2], off));
        };
        if (!(std::fabs(gradient.norm() - 1) <= direction_tolerance)) return wrong(std::fabs(gradient.norm() - 1));
        const bool is_inside = one.truth.in_doubt ? std::signbit(results_.distances[one.number]) : one.truth.inside;
        const double side = is_inside ? -1.0 : 1.0;
        // Several points may be nearest: the one in this direction counts.
        const Vector3d there = vector_of(one.point) - distance * side * gradient;
        const std::uint32_t towards = truths_.tree().nearest({{there[0], there[1], there[2]}, {}})->triangle;
        double least = std::numeric_limits<double>::infinity();
        for (const std::uint32_t triangle : {towards, one.truth.triangle}) {
            const TriangleFrame::Closest closest = truths_.tree().closest_on(triangle, {one.point, {}});
            if (!(closest.distance <= distance + allowed(one))) continue;
            const Vector3d right = side * (vector_of(one.point) - vector_of(closest.point)).normalized();
            least = std::min(least, (gradient - right).norm() - rounding_at(one.point, closest.point) / distance);
        }
        if (!(least <= direction_tolerance + direction_tolerance_voxels * voxel_ / distance)) wrong(least);
    }

    void judge_triangle(const Case& one) const {
        const std::uint32_t triangle = results_.triangles[one.number];
        if (triangle >= truths_.tree().mesh().triangles().size()) {
            one.find(one.report.wrong_triangles, fmt::format("triangle {} is not in the mesh", triangle));
            return;
        }
        const double distance = truths_.tree().distance_to(triangle, {one.point, {}});
        if (!(distance - one.truth.distance <= allowed(one)))
            one.find(one.report.wrong_triangles, fmt::format("triangle {} is {} away, triangle {} is nearer", triangle,
                                                             distance, one.truth.triangle));
    }

    const TrueSamples& truths_;
    std::span<const Vec3> points_;
    const PointResults& results_;
    const PointCheckOptions& options_;
    double voxel_;
    double joined_margin_ = 0;  ///< how far from the surface joined vertices may change the sign
};

void require_sizes(std::size_t points, const PointResults& results) {
    const auto require = [&](std::size_t size, const char* what, bool may_be_empty) {
        if (size == points || (may_be_empty && size == 0)) return;
        refuse("there are {} points and {} {}; give one for each point", points, size, what);
    };
    require(results.distances.size(), "distances", false);
    require(results.closest.size(), "closest points", true);
    require(results.gradients.size(), "gradients", true);
    require(results.triangles.size(), "triangles", true);
}

void append(PointCheckReport& report, const PointCheckReport& next) {
    report.points += next.points;
    report.wrong_distances += next.wrong_distances;
    report.wrong_signs += next.wrong_signs;
    report.wrong_closest += next.wrong_closest;
    report.wrong_gradients += next.wrong_gradients;
    report.wrong_triangles += next.wrong_triangles;
    report.max_error = std::max(report.max_error, next.max_error);
    for (const PointCheckReport::Finding& finding : next.findings)
        if (report.findings.size() < kept_findings) report.findings.push_back(finding);
}

}  // namespace

PointCheckReport check_points(const Mesh& mesh, std::span<const Vec3> points, const PointResults& results,
                              const PointCheckOptions& options) {
    require_sizes(points.size(), results);
    const double side = mesh.box().longest_side();
    const double voxel = side > 0 ? side / 256 : 1;
    const Grid grid{.origin = {}, .spacing = {voxel, voxel, voxel}, .size = {1, 1, 1}};
    const TrueSamples truths(mesh, grid, options.sign, options.floor, std::numeric_limits<double>::infinity());
    const PointJudge judge(truths, points, results, options, voxel);
    constexpr std::size_t points_per_part = 256;
    std::vector<PointCheckReport> parts((points.size() + points_per_part - 1) / points_per_part);
    for_each_index(
        parts.size(),
        [&](std::size_t part) {
            const std::size_t end = std::min(points.size(), (part + 1) * points_per_part);
            for (std::size_t number = part * points_per_part; number < end; ++number) judge.judge(number, parts[part]);
        },
        1);
    PointCheckReport report;
    for (const PointCheckReport& part : parts) append(report, part);
    return report;
}

}  // namespace clsdf::reference
