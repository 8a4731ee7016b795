#pragma once

#include <clsdf/mesh.hpp>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>

namespace clsdf {

inline double length_of(const Vec3& v) {
    return std::sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
}

/// Positions relative to the centre of a mesh, in half its longest side: volumes and areas are not lost in rounding far
/// from the origin, and the largest and the smallest numbers have them, too.
class LocalFrame {
public:
    explicit LocalFrame(const Mesh& mesh) : vertices_(mesh.vertices()) {
        // Halves avoid overflow of the difference of the largest numbers.
        const Box& box = mesh.box();
        double half_side = 0;
        for (std::size_t axis = 0; axis < 3; ++axis) {
            centre_[axis] = 0.5 * box.lower[axis] + 0.5 * box.upper[axis];
            half_side = std::max(half_side, 0.5 * box.upper[axis] - 0.5 * box.lower[axis]);
        }
        scale_ = half_side > 0 ? std::min(1 / half_side, 1e300) : 0;  // finite for the smallest numbers, too
    }

    /// Lengths are multiplied by it.
    double scale() const { return scale_; }

    Vec3 local(std::uint32_t index) const {
        const Vec3& vertex = vertices_[index];
        return {(vertex[0] - centre_[0]) * scale_, (vertex[1] - centre_[1]) * scale_,
                (vertex[2] - centre_[2]) * scale_};
    }

    /// The normal of a face, as long as twice its area.
    Vec3 normal(const Triangle& triangle) const {
        const Vec3 a = local(triangle[0]), b = local(triangle[1]), c = local(triangle[2]);
        Vec3 product{};
        for (std::size_t i = 0; i < 3; ++i) {
            const std::size_t j = (i + 1) % 3, k = (i + 2) % 3;
            product[i] = (b[j] - a[j]) * (c[k] - a[k]) - (b[k] - a[k]) * (c[j] - a[j]);
        }
        return product;
    }

    /// Adds six times the volume of the tetrahedron of the centre and a face, and the sum of the terms' magnitudes.
    void add_volume(const Triangle& triangle, double& sum, double& magnitude) const {
        const Vec3 a = local(triangle[0]);
        const Vec3 b = local(triangle[1]);
        const Vec3 c = local(triangle[2]);
        for (std::size_t i = 0; i < 3; ++i) {
            const std::size_t j = (i + 1) % 3;
            const std::size_t k = (i + 2) % 3;
            sum += a[i] * (b[j] * c[k] - b[k] * c[j]);
            magnitude += std::abs(a[i]) * (std::abs(b[j] * c[k]) + std::abs(b[k] * c[j]));
        }
    }

private:
    const std::vector<Vec3>& vertices_;
    Vec3 centre_{};
    double scale_ = 0;
};

}  // namespace clsdf
