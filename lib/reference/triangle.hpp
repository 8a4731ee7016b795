#pragma once

#include <clsdf/grid.hpp>
#include <clsdf/mesh.hpp>
#include <clsdf/reference.hpp>

#include <Eigen/Core>

#include <array>
#include <cmath>

namespace clsdf::reference {

/// A point known beyond double precision: the sum of two doubles on each axis. `tail` is what rounding `head` lost.
struct ExactPosition {
    Vec3 head{};
    Vec3 tail{};

    /// The largest distance on an axis between the point and the double nearest to it.
    double rounding() const { return std::fmax(std::fabs(tail[0]), std::fmax(std::fabs(tail[1]), std::fabs(tail[2]))); }
};

/// Position of sample (i, j, k) of the grid's block: origin + (first + index) * spacing, a real number, to 106 bits.
inline ExactPosition exact_position(const Grid& grid, const Index3& index) {
    ExactPosition position;
    for (std::size_t axis = 0; axis < 3; ++axis) {
        const auto steps = static_cast<double>(grid.first[axis] + index[axis]);
        const double product = steps * grid.spacing[axis];
        const double product_tail = std::fma(steps, grid.spacing[axis], -product);
        const double origin = grid.origin[axis];
        const double sum = origin + product;
        const double product_part = sum - origin;
        const double sum_tail = (origin - (sum - product_part)) + (product - product_part);
        const double tail = sum_tail + product_tail;
        // Renormalised, so that the head is the double nearest to the sample.
        position.head[axis] = sum + tail;
        position.tail[axis] = tail - (position.head[axis] - sum);
    }
    return position;
}

/// A triangle by its corners.
using Corners = std::array<Vec3, 3>;

/// The intersection of the line parallel to x through (y, z) with a triangle, in exact arithmetic.
struct LineMeeting {
    /// 1 or -1: the line crosses the triangle, whose normal has this sign along x. Points on edges and vertices of the
    /// projection are decided by moving the line by (+e, +e^2) in (y, z), so that a closed surface is crossed
    /// consistently and triangles without a projected area never are. 0: the line does not cross.
    int crossing = 0;
    /// The line, not moved, meets the projection of the closed triangle. If the projection has no area: it meets the
    /// straight line that contains the projection.
    bool touches = false;
    /// The sign of the projected area.
    int facing = 0;
};

LineMeeting meet_line(const Corners& triangle, double y, double z);

/// The side of a triangle's plane that a point lies on, seen along x for a triangle of that facing (not 0): -1 before
/// the plane, 0 on it, 1 beyond it.
int side_along_x(const Corners& triangle, int facing, const Vec3& point);

/// Whether the point lies on the closed triangle, which may be degenerate.
bool lies_on(const Corners& triangle, const Vec3& point);

/// A triangle with the frame in which the distance to it is evaluated: its unit normal and its edges' unit directions.
/// Let s be the height over the face and r_i the distances beyond the edges. The nearest point lies on the face if
/// every r_i < 0, else on an edge with r_i >= 0. Unlike barycentric coordinates, none of these divides by the
/// triangle's area.
///
/// Vertices are kept in lexicographic order and edges run from the lower to the higher one, so that triangles which
/// share an edge or a vertex return the same bits for it, and equal distances are seen as equal.
class TriangleFrame {
public:
    TriangleFrame() = default;
    TriangleFrame(const Vec3& a, const Vec3& b, const Vec3& c);

    struct Closest {
        double distance;
        Site site;  ///< in the order of the caller's vertices
        Vec3 point;
    };

    /// Sites are decided within the rounding of double: a point nearer to a border than that belongs to the border. So
    /// ties go to the vertex before the edge, and to the edge before the face.
    Closest closest(const ExactPosition& query) const;

    /// A lower bound of the distance, minus its own rounding error. It costs one product; 0 for a degenerate triangle.
    double height_bound(const ExactPosition& query) const;

private:
    struct Edge {
        unsigned char from = 0;  ///< a vertex of this frame, as is the next
        unsigned char to = 0;
        Site site = Site::edge0;
        Eigen::Vector3d direction;
    };

    Eigen::Vector3d offset(const ExactPosition& query, std::size_t vertex) const;
    void consider_vertex(const Eigen::Vector3d* offsets, std::size_t vertex, Closest& best) const;
    void consider_edge(const Eigen::Vector3d* offsets, const Edge& edge, Closest& best) const;

    std::array<Vec3, 3> vertices_{};
    std::array<Site, 3> vertex_sites_{};
    std::array<Edge, 3> edges_{};
    Eigen::Vector3d normal_;
    std::array<Eigen::Vector3d, 3> outward_;  ///< in-plane unit normals of the edges
    bool degenerate_ = true;                  ///< without a normal: only its edges count
};

}  // namespace clsdf::reference
