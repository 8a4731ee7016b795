#pragma once

#include <clsdf/mesh.hpp>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>
#include <vector>

/// Distances to the triangles of a mesh by the textbook: the plane if the point lies over the face, else the edges.
namespace clsdf::test {

class PlainTriangle {
public:
    explicit PlainTriangle(std::array<Eigen::Vector3d, 3> corners) : corners_(std::move(corners)) {
        double longest = 0;
        for (std::size_t i = 0; i < 3; ++i) {
            edges_[i] = corners_[(i + 1) % 3] - corners_[i];
            squared_[i] = edges_[i].squaredNorm();
            longest = std::max(longest, squared_[i]);
        }
        const Eigen::Vector3d normal = edges_[0].cross(edges_[1]);
        has_face_ = normal.norm() > 1e-10 * longest;
        if (has_face_) normal_ = normal.normalized();
    }

    double distance(const Eigen::Vector3d& point) const {
        double least = std::numeric_limits<double>::infinity();
        bool over_face = has_face_;
        for (std::size_t i = 0; i < 3; ++i) {
            const Eigen::Vector3d from = point - corners_[i];
            if (has_face_ && normal_.dot(edges_[i].cross(from)) > 0) continue;
            over_face = false;
            const double t = squared_[i] > 0 ? std::clamp(from.dot(edges_[i]) / squared_[i], 0.0, 1.0) : 0.0;
            least = std::min(least, (from - t * edges_[i]).norm());
        }
        return over_face ? std::abs(normal_.dot(point - corners_[0])) : least;
    }

    const std::array<Eigen::Vector3d, 3>& corners() const { return corners_; }

private:
    std::array<Eigen::Vector3d, 3> corners_;
    std::array<Eigen::Vector3d, 3> edges_;
    std::array<double, 3> squared_{};
    Eigen::Vector3d normal_ = Eigen::Vector3d::Zero();
    bool has_face_ = false;
};

}  // namespace clsdf::test
