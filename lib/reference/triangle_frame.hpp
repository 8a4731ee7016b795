#pragma once

#include "exact_geometry.hpp"

#include <clsdf/reference.hpp>

#include <Eigen/Core>

#include <array>

namespace clsdf::reference {

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
