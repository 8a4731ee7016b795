#pragma once

#include "benchmarks/peers/closest_point.hpp"

#include <clsdf/mesh.hpp>

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace clsdf::bench {

/// The sign of a closed mesh's distance by angle-weighted pseudonormals (Baerentzen & Aanaes, Signed Distance
/// Computation Using the Angle Weighted Pseudonormal), in double precision: for programs that find the closest triangle
/// and leave the sign to their users.
class Pseudonormals {
public:
    explicit Pseudonormals(const Mesh& mesh);

    /// The signed distance to a triangle that is a closest one.
    double signed_distance(const Vec3& query, std::uint32_t triangle) const;

private:
    using Vector = Eigen::Vector3d;

    Vector normal_at(std::uint32_t triangle, TriangleSite site) const;
    Vector corner(std::uint32_t triangle, std::size_t k) const;

    const Mesh& mesh_;
    std::vector<Vector> faces_;
    std::vector<Vector> vertices_;
    std::vector<std::array<Vector, 3>> edges_;  ///< by triangle
};

}  // namespace clsdf::bench
