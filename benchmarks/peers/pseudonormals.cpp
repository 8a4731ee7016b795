#include "benchmarks/peers/pseudonormals.hpp"

#include <tbb/parallel_for.h>
#include <tbb/parallel_sort.h>
#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>

namespace clsdf::bench {

namespace {

using Vector = Eigen::Vector3d;

/// A triangle's edge, by its vertices.
struct Edge {
    std::uint32_t low, high, triangle, k;

    bool same_as(const Edge& other) const { return low == other.low && high == other.high; }
    friend bool operator<(const Edge& a, const Edge& b) {
        return a.low != b.low ? a.low < b.low : a.high != b.high ? a.high < b.high : a.triangle < b.triangle;
    }
};

double angle_between(const Vector& a, const Vector& b) {
    return std::atan2(a.cross(b).norm(), a.dot(b));
}

}  // namespace

Vector Pseudonormals::corner(std::uint32_t triangle, std::size_t k) const {
    return Vector(mesh_.vertices()[mesh_.triangles()[triangle][k]].data());
}

Pseudonormals::Pseudonormals(const Mesh& mesh)
    : mesh_(mesh),
      faces_(mesh.triangles().size()),
      vertices_(mesh.vertices().size(), Vector::Zero()),
      edges_(mesh.triangles().size()) {
    const auto count = static_cast<std::uint32_t>(mesh.triangles().size());
    std::vector<Edge> edges(std::size_t{3} * count);
    std::vector<std::array<double, 3>> angles(count);
    tbb::parallel_for(std::uint32_t{0}, count, [&](std::uint32_t t) {
        const std::array<Vector, 3> p{corner(t, 0), corner(t, 1), corner(t, 2)};
        faces_[t] = (p[1] - p[0]).cross(p[2] - p[0]).normalized();
        for (std::uint32_t k = 0; k < 3; ++k) {
            angles[t][k] = angle_between(p[(k + 1) % 3] - p[k], p[(k + 2) % 3] - p[k]);
            const std::uint32_t v = mesh.triangles()[t][k], w = mesh.triangles()[t][(k + 1) % 3];
            edges[std::size_t{3} * t + k] = {std::min(v, w), std::max(v, w), t, k};
        }
    });
    for (std::uint32_t t = 0; t < count; ++t)
        for (std::size_t k = 0; k < 3; ++k) vertices_[mesh.triangles()[t][k]] += angles[t][k] * faces_[t];
    tbb::parallel_sort(edges);
    for (std::size_t begin = 0, end = 0; begin < edges.size(); begin = end) {
        Vector sum = Vector::Zero();
        for (end = begin; end < edges.size() && edges[end].same_as(edges[begin]); ++end)
            sum += faces_[edges[end].triangle];
        for (std::size_t n = begin; n < end; ++n) edges_[edges[n].triangle][edges[n].k] = sum;
    }
}

Vector Pseudonormals::normal_at(std::uint32_t triangle, TriangleSite site) const {
    switch (site) {
        case TriangleSite::vertex0:
        case TriangleSite::vertex1:
        case TriangleSite::vertex2:
            return vertices_[mesh_.triangles()[triangle][static_cast<std::size_t>(site)]];
        case TriangleSite::edge0:
        case TriangleSite::edge1:
        case TriangleSite::edge2:
            return edges_[triangle][static_cast<std::size_t>(site) - static_cast<std::size_t>(TriangleSite::edge0)];
        case TriangleSite::face:
            break;
    }
    return faces_[triangle];
}

double Pseudonormals::signed_distance(const Vec3& query, std::uint32_t triangle) const {
    const Vector position(query.data());
    const ClosestPoint<double> closest =
        closest_point<double>(position, corner(triangle, 0), corner(triangle, 1), corner(triangle, 2));
    const Vector offset = position - closest.point;
    const double distance = offset.norm();
    return offset.dot(normal_at(triangle, closest.site)) < 0 ? -distance : distance;
}

}  // namespace clsdf::bench
