#pragma once

#include "plain_distance.hpp"
#include "pointwise.hpp"

#include <fmt/format.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cstdint>
#include <string>

/// Whether every point near a mesh lies in the polyhedron of a triangle that is nearest to it.
namespace clsdf::test {

/// The counts of points within the half width.
struct Coverage {
    std::size_t points = 0;
    std::size_t uncovered = 0;  ///< in no polyhedron
    std::size_t wrong = 0;      ///< in polyhedra, but of farther triangles only
    Vec3 first{};               ///< of the uncovered or wrong points, in samples
    double first_distance = 0;
    double first_found = 0;

    std::size_t failures() const { return uncovered + wrong; }

    void add(const Vec3& point, double distance, double found) {
        constexpr double tolerance = 1e-6;  // voxels
        ++points;
        if (!(found > distance + tolerance)) return;
        if (failures() == 0) {
            first = point;
            first_distance = distance;
            first_found = found;
        }
        ++(std::isinf(found) ? uncovered : wrong);
    }

    std::string text() const {
        return fmt::format("{} points, {} uncovered, {} wrong, first ({}, {}, {}): {} instead of {}", points, uncovered,
                           wrong, first[0], first[1], first[2], first_found, first_distance);
    }
};

/// A mesh and its polyhedra on a lattice. Points are in samples, distances in voxels.
class CoverageTest {
public:
    CoverageTest(const Mesh& mesh, const engine::LatticeView& lattice, double half_width, double slack,
                 const engine::FrustaOptions& options = {})
        : lattice_(lattice), half_width_(half_width), slack_(slack), frusta_(leaned_frusta(mesh, lattice, options)) {
        for (const Triangle& triangle : mesh.triangles()) {
            std::array<Eigen::Vector3d, 3> corners;
            for (std::size_t i = 0; i < 3; ++i)
                for (int axis = 0; axis < 3; ++axis) {
                    const auto a = static_cast<std::size_t>(axis);
                    corners[i][axis] = (mesh.vertices()[triangle[i]][a] - lattice.origin[a]) / lattice.unit;
                }
            triangles_.emplace_back(corners);
        }
        for (const Polyhedron& record : frusta_.polyhedra) pointwise_.emplace_back(record, half_width, slack);
    }

    const LeanedFrusta& frusta() const { return frusta_; }
    const std::vector<PlainTriangle>& triangles() const { return triangles_; }

    Vec3 to_samples(const Eigen::Vector3d& voxels) const {
        return {voxels[0] / lattice_.spacing_in_units[0], voxels[1] / lattice_.spacing_in_units[1],
                voxels[2] / lattice_.spacing_in_units[2]};
    }
    Eigen::Vector3d to_voxels(const Vec3& samples) const {
        return {samples[0] * lattice_.spacing_in_units[0], samples[1] * lattice_.spacing_in_units[1],
                samples[2] * lattice_.spacing_in_units[2]};
    }

    /// To the mesh.
    double distance(const Vec3& point) const {
        double least = std::numeric_limits<double>::infinity();
        for (const PlainTriangle& triangle : triangles_) least = std::min(least, triangle.distance(to_voxels(point)));
        return least;
    }

    /// The least distance to the triangles of the polyhedra that contain the point.
    double found(const Vec3& point) const {
        double least = std::numeric_limits<double>::infinity();
        for (const PointwisePolyhedron& polyhedron : pointwise_)
            if (polyhedron.contains(point)) least = std::min(least, polyhedron.distance(point));
        return least;
    }

    /// Looks at one point.
    void look(const Vec3& point, Coverage& coverage) const {
        const double true_distance = distance(point);
        if (true_distance <= half_width_) coverage.add(point, true_distance, found(point));
    }

    /// Looks at every sample of a cube of the lattice.
    Coverage look_at_lattice(std::int64_t lower, std::int64_t upper, bool in_float) const {
        const auto side = static_cast<std::size_t>(upper - lower + 1);
        std::vector<Coverage> layers(side);
        tbb::parallel_for(std::size_t{0}, side, [&](std::size_t k) {
            layers[k] = look_at_layer(lower, side, lower + static_cast<std::int64_t>(k), in_float);
        });
        Coverage all;
        for (const Coverage& layer : layers) {
            if (all.failures() == 0) {
                all.first = layer.first;
                all.first_distance = layer.first_distance;
                all.first_found = layer.first_found;
            }
            all.points += layer.points;
            all.uncovered += layer.uncovered;
            all.wrong += layer.wrong;
        }
        return all;
    }

private:
    /// Calls visit(i, j) for the samples of a layer that lie in the box of three corners enlarged by the half width.
    template <typename Visit>
    void visit_layer(const std::array<Vec3, 3>& corners, std::int64_t lower, std::size_t side, std::int64_t k,
                     const Visit& visit) const {
        std::array<std::int64_t, 3> first{};
        std::array<std::int64_t, 3> last{};
        for (std::size_t axis = 0; axis < 3; ++axis) {
            const auto [least, greatest] = std::minmax({corners[0][axis], corners[1][axis], corners[2][axis]});
            const double reach = (half_width_ + 1) / lattice_.spacing_in_units[axis];
            first[axis] = std::max(lower, static_cast<std::int64_t>(std::floor(least - reach)));
            last[axis] = std::min(lower + static_cast<std::int64_t>(side) - 1,
                                  static_cast<std::int64_t>(std::ceil(greatest + reach)));
        }
        if (k < first[2] || k > last[2]) return;
        for (std::int64_t j = first[1]; j <= last[1]; ++j)
            for (std::int64_t i = first[0]; i <= last[0]; ++i)
                visit(static_cast<std::size_t>(j - lower) * side + static_cast<std::size_t>(i - lower),
                      Vec3{static_cast<double>(i), static_cast<double>(j), static_cast<double>(k)});
    }

    Coverage look_at_layer(std::int64_t lower, std::size_t side, std::int64_t k, bool in_float) const {
        constexpr double infinity = std::numeric_limits<double>::infinity();
        std::vector<double> distances(side * side, infinity);
        std::vector<double> found(side * side, infinity);
        for (const PlainTriangle& triangle : triangles_) {
            const auto& [a, b, c] = triangle.corners();
            visit_layer({to_samples(a), to_samples(b), to_samples(c)}, lower, side, k,
                        [&](std::size_t at, const Vec3& sample) {
                            distances[at] = std::min(distances[at], triangle.distance(to_voxels(sample)));
                        });
        }
        for (std::size_t i = 0; i < pointwise_.size(); ++i) {
            const PointwisePolyhedron& polyhedron = pointwise_[i];
            visit_layer(polyhedron.corners(), lower, side, k, [&](std::size_t at, const Vec3& sample) {
                const bool inside = in_float
                                        ? contains_in_float(frusta_.polyhedra[i], sample,
                                                            static_cast<float>(half_width_), static_cast<float>(slack_))
                                        : polyhedron.contains(sample);
                if (inside) found[at] = std::min(found[at], polyhedron.distance(sample));
            });
        }
        Coverage coverage;
        for (std::size_t at = 0; at < distances.size(); ++at) {
            const Vec3 sample{static_cast<double>(lower + static_cast<std::int64_t>(at % side)),
                              static_cast<double>(lower + static_cast<std::int64_t>(at / side)),
                              static_cast<double>(k)};
            if (distances[at] <= half_width_) coverage.add(sample, distances[at], found[at]);
        }
        return coverage;
    }

    engine::LatticeView lattice_;
    double half_width_;
    double slack_;
    LeanedFrusta frusta_;
    std::vector<PlainTriangle> triangles_;
    std::vector<PointwisePolyhedron> pointwise_;
};

/// The least slack the polyhedra are made for.
inline double least_slack(double half_width) {
    return 1e-3 + 2e-5 * half_width;
}

}  // namespace clsdf::test
