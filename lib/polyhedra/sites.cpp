#include "polyhedra/sites.hpp"

#include "core/parallel.hpp"
#include "layout.h"
#include "polyhedra/frames.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <span>
#include <utility>
#include <vector>

namespace clsdf::polyhedra {

namespace {

/// A sum of unit vectors that is shorter than its rounding has no direction.
constexpr double cancelled = 1e-6;

constexpr std::uint32_t next(std::uint32_t corner) {
    return corner == 2 ? 0 : corner + 1;
}

/// The faces at each vertex, ascending; one that has it twice stands there twice.
class FacesOfVertices {
public:
    explicit FacesOfVertices(const Mesh& mesh)
        : begin_(mesh.vertices().size() + 2), faces_(3 * mesh.triangles().size()) {
        for (const Triangle& triangle : mesh.triangles())
            for (const std::uint32_t vertex : triangle) ++begin_[vertex + 2];
        for (std::size_t v = 2; v < begin_.size(); ++v) begin_[v] += begin_[v - 1];
        for (std::uint32_t face = 0; face < mesh.triangles().size(); ++face)
            for (const std::uint32_t vertex : mesh.triangles()[face]) faces_[begin_[vertex + 1]++] = face;
    }

    std::span<const std::uint32_t> at(std::size_t vertex) const {
        return std::span(faces_).subspan(begin_[vertex], begin_[vertex + 1] - begin_[vertex]);
    }

private:
    std::vector<std::uint32_t> begin_;
    UninitializedVector<std::uint32_t> faces_;
};

/// A face's unit normal, or nothing but zeros, and its angles. In double, for normals that nearly cancel each other.
struct FaceShape {
    Vector normal;
    std::array<double, 3> angles;
};

FaceShape shape_of(const Mesh& mesh, const Triangle& triangle) {
    std::array<Vector, 3> edges;
    double longest = 0;
    for (std::uint32_t k = 0; k < 3; ++k) {
        edges[k] = to_vector(mesh.vertices()[triangle[next(k)]]) - to_vector(mesh.vertices()[triangle[k]]);
        longest = std::max(longest, edges[k].cwiseAbs().maxCoeff());
    }
    FaceShape shape{Vector::Zero(), {0, 0, 0}};
    if (!(longest > 0)) return shape;
    for (Vector& edge : edges) edge /= longest;  // their squares stay in a double's range
    // From the shortest two edges, whose product rounds least.
    std::array<double, 3> squared{};
    for (std::size_t k = 0; k < 3; ++k) squared[k] = edges[k].squaredNorm();
    const auto base = static_cast<std::uint32_t>(std::max_element(squared.begin(), squared.end()) - squared.begin());
    const Vector cross = edges[next(base)].cross(edges[next(next(base))]);
    const double area = cross.norm();
    if (!(area > 0)) return shape;
    shape.normal = cross / area;
    for (std::uint32_t k = 0; k < 3; ++k) shape.angles[k] = std::atan2(area, -edges[k].dot(edges[next(next(k))]));
    return shape;
}

/// A sum of normals, as a unit vector.
struct NormalSum {
    Vector sum = Vector::Zero();
    Vector first = Vector::Zero();
    double weights = 0;

    void add(const Vector& normal, double weight) {
        if (normal.isZero(0)) return;
        if (weights == 0) first = normal;
        sum += weight * normal;
        weights += weight;
    }
    void store(float* to) const {
        const double length = sum.norm();
        const Vector unit = length > cancelled * weights ? Vector(sum / length)
                            : weights > 0                ? first
                                                         : Vector::Constant(std::numeric_limits<double>::quiet_NaN());
        for (Eigen::Index k = 0; k < 3; ++k) to[k] = static_cast<float>(unit[k]);
    }
};

/// An edge of a face, at the lower one of its vertices.
struct EdgeAtVertex {
    std::uint32_t other;  ///< the higher vertex
    std::uint32_t face;
    std::uint32_t number;
    bool is_reversed;  ///< it runs to the lower vertex
};

/// Names the sites of a stretch of the vertices: each vertex, and the edges to higher vertices.
class SiteNames {
public:
    /// `shapes` is empty if no normals are asked for.
    SiteNames(const Mesh& mesh, const FacesOfVertices& faces, std::span<const FaceShape> shapes, Sites& sites)
        : triangles_(mesh.triangles()), faces_(faces), shapes_(shapes), sites_(sites) {}

    void name(std::uint32_t vertex) {
        const std::span<const std::uint32_t> faces = faces_.at(vertex);
        if (faces.empty()) return;
        edges_.clear();
        const std::uint32_t lowest = faces.front();
        const auto its_corner = static_cast<std::uint32_t>(
            std::find(triangles_[lowest].begin(), triangles_[lowest].end(), vertex) - triangles_[lowest].begin());
        NormalSum sum;
        std::uint32_t last = CLSDF_NO_TRIANGLE;
        for (const std::uint32_t face : faces) {
            if (std::exchange(last, face) == face) continue;
            const Triangle& triangle = triangles_[face];
            for (std::uint32_t k = 0; k < 3; ++k) {
                const std::uint32_t from = triangle[k], to = triangle[next(k)];
                if (from == vertex) {
                    set(face, k, lowest, its_corner);
                    if (!shapes_.empty()) sum.add(shapes_[face].normal, shapes_[face].angles[k]);
                }
                if (std::min(from, to) == vertex) edges_.push_back({std::max(from, to), face, k, from != vertex});
            }
        }
        if (!shapes_.empty()) {
            std::array<float, 3> normal;
            sum.store(normal.data());
            for (const std::uint32_t face : faces)
                for (std::uint32_t k = 0; k < 3; ++k)
                    if (triangles_[face][k] == vertex) std::copy(normal.begin(), normal.end(), place(face, k));
        }
        name_edges();
    }

private:
    float* place(std::uint32_t face, std::uint32_t site) {
        return sites_.normals.data() + std::size_t{18} * face + std::size_t{3} * site;
    }

    void set(std::uint32_t face, std::uint32_t site, std::uint32_t lowest, std::uint32_t named) {
        sites_.triangles[face].triangle[site] = lowest;
        sites_.triangles[face].site[site] = static_cast<std::uint8_t>(named);
    }

    void name_edges() {
        // By insertion: they are few, and stay in the order of their faces.
        for (std::size_t n = 1; n < edges_.size(); ++n) {
            const EdgeAtVertex edge = edges_[n];
            std::size_t at = n;
            for (; at > 0 && edges_[at - 1].other > edge.other; --at) edges_[at] = edges_[at - 1];
            edges_[at] = edge;
        }
        for (auto begin = edges_.begin(); begin != edges_.end();) {
            const auto end =
                std::find_if(begin, edges_.end(), [&](const EdgeAtVertex& edge) { return edge.other != begin->other; });
            NormalSum sum;
            for (auto edge = begin; edge != end; ++edge) {
                const std::uint32_t turned = edge->is_reversed != begin->is_reversed ? CLSDF_SITE_REVERSED : 0U;
                set(edge->face, 3 + edge->number, begin->face, (3 + begin->number) | turned);
                if (!shapes_.empty()) sum.add(shapes_[edge->face].normal, 1);
            }
            if (!shapes_.empty()) {
                std::array<float, 3> normal;
                sum.store(normal.data());
                for (auto edge = begin; edge != end; ++edge)
                    std::copy(normal.begin(), normal.end(), place(edge->face, 3 + edge->number));
            }
            begin = end;
        }
    }

    std::span<const Triangle> triangles_;
    const FacesOfVertices& faces_;
    std::span<const FaceShape> shapes_;
    Sites& sites_;
    std::vector<EdgeAtVertex> edges_;  ///< of the vertex
};

}  // namespace

bool encloses_negative_volume(const Mesh& mesh) {
    const Vector centre = (to_vector(mesh.box().lower) + to_vector(mesh.box().upper)) / 2;
    const double longest = (to_vector(mesh.box().upper) - to_vector(mesh.box().lower)).maxCoeff();
    double sum = 0;
    for (const Triangle& triangle : mesh.triangles()) {
        const auto corner = [&](std::size_t k) -> Vector {
            return (to_vector(mesh.vertices()[triangle[k]]) - centre) / longest;
        };
        sum += corner(0).dot(corner(1).cross(corner(2)));
    }
    return sum < 0;
}

Sites make_sites(const Mesh& mesh, bool with_normals) {
    const std::vector<Triangle>& triangles = mesh.triangles();
    const FacesOfVertices faces(mesh);
    UninitializedVector<FaceShape> shapes;
    Sites sites;
    sites.triangles.resize(triangles.size());
    if (with_normals) {
        sites.encloses_negative_volume = encloses_negative_volume(mesh);
        sites.normals.resize(18 * triangles.size());
        shapes.resize(triangles.size());
        for_each_index(triangles.size(), [&](std::size_t face) { shapes[face] = shape_of(mesh, triangles[face]); });
    }
    for_each_range(mesh.vertices().size(), [&](std::size_t begin, std::size_t end) {
        SiteNames names(mesh, faces, shapes, sites);
        for (std::size_t vertex = begin; vertex < end; ++vertex) names.name(static_cast<std::uint32_t>(vertex));
    });
    return sites;
}

}  // namespace clsdf::polyhedra
