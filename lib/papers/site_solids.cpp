#include "papers/site_solids.hpp"

#include "core/parallel.hpp"
#include "core/parallel_sort.hpp"
#include "frusta/frames.hpp"

#include <clsdf/error.hpp>

#include <fmt/format.h>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <optional>

namespace clsdf::papers {

namespace {

using engine::any_perpendicular;
using engine::Vector;
using Vector2 = Eigen::Vector2d;

constexpr std::size_t most_rays = SiteSolid::most_corners - 1;

/// An edge of a face that runs from the lower to the higher vertex, or back.
struct FaceEdge {
    std::uint64_t vertices;  ///< lower above higher
    std::uint32_t face;
    std::uint32_t corner;

    bool operator<(const FaceEdge& other) const {
        return vertices != other.vertices ? vertices < other.vertices : face < other.face;
    }
};

/// The part of a convex polygon with n . (x, y) <= limit.
void cut(std::vector<Vector2>& polygon, const Vector2& n, double limit, std::vector<Vector2>& result) {
    result.clear();
    for (std::size_t i = 0; i < polygon.size(); ++i) {
        const Vector2& from = polygon[i];
        const Vector2& to = polygon[i + 1 < polygon.size() ? i + 1 : 0];
        const double before = n.dot(from) - limit, after = n.dot(to) - limit;
        if (before <= 0) result.push_back(from);
        if ((before < 0 && after > 0) || (before > 0 && after < 0))
            result.emplace_back(from + before / (before - after) * (to - from));
    }
    polygon.swap(result);
}

class Builder {
public:
    Builder(const Mesh& mesh, const Grid& grid, double half_width)
        : mesh_(mesh), half_width_(half_width / grid.voxel()) {
        positions_.resize(mesh.vertices().size());
        for_each_index(positions_.size(), [&](std::size_t v) {
            for (std::size_t axis = 0; axis < 3; ++axis)
                positions_[v][static_cast<Eigen::Index>(axis)] =
                    (mesh.vertices()[v][axis] - grid.origin[axis]) / grid.spacing[axis] -
                    static_cast<double>(grid.first[axis]);
        });
        normals_.resize(mesh.triangles().size());
        for_each_index(normals_.size(), [&](std::size_t face) {
            const auto& [a, b, c] = mesh.triangles()[face];
            normals_[face] = (positions_[b] - positions_[a]).cross(positions_[c] - positions_[a]).normalized();
        });
        edges_.resize(3 * normals_.size());
        for_each_index(normals_.size(), [&](std::size_t face) {
            for (std::uint32_t k = 0; k < 3; ++k) {
                const std::uint32_t from = mesh.triangles()[face][k];
                const std::uint32_t to = mesh.triangles()[face][(k + 1) % 3];
                const std::uint64_t low = std::min(from, to), high = std::max(from, to);
                edges_[3 * face + k] = {low << 32 | high, static_cast<std::uint32_t>(face), k};
            }
        });
        sort_on_all_cores(edges_);
        check_pairs();
        starts_.assign(positions_.size() + 1, 0);
        for (const Triangle& triangle : mesh.triangles())
            for (const std::uint32_t vertex : triangle) ++starts_[vertex + 1];
        for (std::size_t v = 0; v < positions_.size(); ++v) starts_[v + 1] += starts_[v];
        corners_.resize(3 * normals_.size());
        std::vector<std::uint32_t> next(starts_.begin(), starts_.end() - 1);
        for (std::uint32_t face = 0; face < normals_.size(); ++face)
            for (std::uint32_t k = 0; k < 3; ++k) corners_[next[mesh.triangles()[face][k]]++] = 3 * face + k;
    }

    std::vector<SiteSolid> build() const {
        const std::size_t faces = normals_.size(), edges = edges_.size() / 2, vertices = positions_.size();
        std::vector<SiteSolid> solids(faces + edges + vertices);
        for_each_index(faces, [&](std::size_t i) { make_tower(i, solids[i]); });
        for_each_index(edges, [&](std::size_t i) { make_wedge(edges_[2 * i], edges_[2 * i + 1], solids[faces + i]); });
        for_each_index(vertices, [&](std::size_t i) { make_cone(i, solids[faces + edges + i]); });
        return solids;
    }

private:
    /// Two faces meet at each edge, which runs one way in one and the other way in the other.
    void check_pairs() const {
        for (std::size_t i = 0; i < edges_.size(); i += 2) {
            const auto start = [&](const FaceEdge& edge) { return mesh_.triangles()[edge.face][edge.corner]; };
            const bool is_pair = i + 1 < edges_.size() && edges_[i].vertices == edges_[i + 1].vertices &&
                                 start(edges_[i]) != start(edges_[i + 1]) &&
                                 (i + 2 == edges_.size() || edges_[i].vertices != edges_[i + 2].vertices);
            if (!is_pair)
                throw Error(ErrorCode::invalid_mesh,
                            fmt::format("the scan of Mauch's polyhedra in software needs a closed manifold mesh whose "
                                        "faces are oriented alike, and the edge of {} from vertex {} to {} is none of "
                                        "such a mesh; weld equal vertices and close holes, or scan leaned polyhedra",
                                        mesh_.name(), edges_[i].vertices >> 32, edges_[i].vertices & 0xFFFFFFFFU));
        }
    }

    static void place(SiteSolid& solid, const Vector& point) {
        for (std::size_t axis = 0; axis < 3; ++axis) {
            const double p = point[static_cast<Eigen::Index>(axis)];
            solid.origin[axis] = static_cast<std::int32_t>(std::lround(p));
            solid.point[axis] = static_cast<float>(p - solid.origin[axis]);
        }
    }
    static void set_corner(SiteSolid& solid, std::size_t i, const Vector& p) {
        for (std::size_t axis = 0; axis < 3; ++axis)
            solid.corners[i][axis] = static_cast<float>(p[static_cast<Eigen::Index>(axis)] - solid.origin[axis]);
    }
    static std::array<float, 3> to_float(const Vector& v) {
        return {static_cast<float>(v.x()), static_cast<float>(v.y()), static_cast<float>(v.z())};
    }

    void make_tower(std::size_t face, SiteSolid& solid) const {
        const Vector& normal = normals_[face];
        if (!(normal.squaredNorm() > 0.5)) return;
        solid.shape = SiteSolid::Shape::prism;
        solid.site = SiteSolid::Site::face;
        solid.sides = 3;
        place(solid, positions_[mesh_.triangles()[face][0]]);
        solid.axes[0] = to_float(normal);
        for (std::size_t k = 0; k < 3; ++k) {
            const Vector& corner = positions_[mesh_.triangles()[face][k]];
            set_corner(solid, k, corner - half_width_ * normal);
            set_corner(solid, 3 + k, corner + half_width_ * normal);
        }
    }

    /// Between the two faces' normals on the convex side of the edge.
    void make_wedge(const FaceEdge& one, const FaceEdge& other, SiteSolid& solid) const {
        const Triangle& triangle = mesh_.triangles()[one.face];
        const Vector& a = positions_[triangle[one.corner]];
        const Vector& b = positions_[triangle[(one.corner + 1) % 3]];
        const Vector along = (b - a).normalized();
        const Vector inward = normals_[one.face].cross(along);
        const double height = normals_[other.face].dot(inward);  // positive if the edge is concave
        constexpr double flat = 1e-9;
        if (!(std::abs(height) > flat)) return;
        solid.sign = height < 0 ? 1.0F : -1.0F;
        const Vector first = static_cast<double>(solid.sign) * normals_[one.face];
        const Vector last = static_cast<double>(solid.sign) * normals_[other.face];
        Vector middle = first + last;
        // Faces folded onto each other leave half a turn.
        middle = middle.squaredNorm() > 1e-12 ? Vector(middle.normalized()) : Vector(-inward);
        solid.shape = SiteSolid::Shape::prism;
        solid.site = SiteSolid::Site::edge;
        place(solid, a);
        solid.axes[0] = to_float(any_perpendicular(along));
        solid.axes[1] = to_float(along.cross(any_perpendicular(along)).normalized());

        // The tangents of the arc of the half width, at its middle alone or at its ends too.
        std::array<Vector, 5> profile;
        const double cosine = middle.dot(first);
        if (cosine > 0.9) {
            solid.sides = 3;
            profile = {Vector::Zero(), half_width_ / cosine * first, half_width_ / cosine * last};
        } else {
            const double half_cosine = std::sqrt((1 + cosine) / 2);
            solid.sides = 5;
            profile = {Vector::Zero(), half_width_ * first, half_width_ / half_cosine * (first + middle).normalized(),
                       half_width_ / half_cosine * (last + middle).normalized(), half_width_ * last};
        }
        for (std::size_t i = 0; i < solid.sides; ++i) {
            set_corner(solid, i, a + profile[i]);
            set_corner(solid, solid.sides + i, b + profile[i]);
        }
    }

    /// The extreme rays of {u : u . n <= 0 for the directions n to all neighbours}: a polygon in the plane u . axis = 1
    /// for an axis with a positive product with every direction of the cone.
    std::vector<Vector> rays_at(std::size_t vertex) const {
        std::vector<Vector> neighbours;
        Vector axis = Vector::Zero();
        for (std::size_t i = starts_[vertex]; i < starts_[vertex + 1]; ++i) {
            const Triangle& triangle = mesh_.triangles()[corners_[i] / 3];
            // In a closed manifold, each neighbour follows the vertex in one face.
            const Vector& to = positions_[triangle[(corners_[i] + 1 - corners_[i] / 3 * 3) % 3]];
            neighbours.push_back((to - positions_[vertex]).normalized());
            axis -= neighbours.back();
        }
        if (!(axis.norm() > 1e-9)) return {};
        axis.normalize();
        const Vector x = any_perpendicular(axis), y = axis.cross(x);
        constexpr double far = 1e7;
        std::vector<Vector2> polygon{{-far, -far}, {far, -far}, {far, far}, {-far, far}}, rest;
        for (const Vector& n : neighbours) {
            cut(polygon, {n.dot(x), n.dot(y)}, -n.dot(axis), rest);
            if (polygon.size() < 3) return {};
        }
        std::vector<Vector> rays;
        rays.reserve(polygon.size());
        for (const Vector2& p : polygon) rays.push_back((axis + p.x() * x + p.y() * y).normalized());
        return rays;
    }

    void make_cone(std::size_t vertex, SiteSolid& solid) const {
        const std::vector<Vector> rays = rays_at(vertex);
        if (rays.size() < 3) return;
        const Vector& tip = positions_[vertex];
        Vector middle = Vector::Zero();
        for (const Vector& ray : rays) middle += ray;
        middle.normalize();
        solid.site = SiteSolid::Site::vertex;
        solid.sign = middle.dot(pseudonormal(vertex)) < 0 ? -1.0F : 1.0F;
        place(solid, tip);
        constexpr double widest = 0.3;  // cosine
        const bool is_narrow =
            rays.size() <= most_rays &&
            std::all_of(rays.begin(), rays.end(), [&](const Vector& ray) { return ray.dot(middle) > widest; });
        if (is_narrow) {
            solid.shape = SiteSolid::Shape::pyramid;
            solid.sides = static_cast<std::uint8_t>(rays.size());
            set_corner(solid, 0, tip);
            for (std::size_t i = 0; i < rays.size(); ++i)
                set_corner(solid, 1 + i, tip + half_width_ / middle.dot(rays[i]) * rays[i]);
            return;
        }
        // A cube about the ball: a vertex is nearest to no sample beyond its cone, so that it does no harm there.
        solid.shape = SiteSolid::Shape::prism;
        solid.sides = 4;
        const Vector x = half_width_ * any_perpendicular(middle), y = middle.cross(x);
        const std::array<Vector, 4> base{-x - y, x - y, x + y, -x + y};
        for (std::size_t i = 0; i < 4; ++i) {
            set_corner(solid, i, tip + base[i] - half_width_ * middle);
            set_corner(solid, 4 + i, tip + base[i] + half_width_ * middle);
        }
    }

    /// The sum of the faces' normals, each times its angle (Baerentzen and Aanaes).
    Vector pseudonormal(std::size_t vertex) const {
        Vector sum = Vector::Zero();
        for (std::size_t i = starts_[vertex]; i < starts_[vertex + 1]; ++i) {
            const std::uint32_t face = corners_[i] / 3, k = corners_[i] % 3;
            const Triangle& triangle = mesh_.triangles()[face];
            const Vector a = positions_[triangle[(k + 1) % 3]] - positions_[vertex];
            const Vector b = positions_[triangle[(k + 2) % 3]] - positions_[vertex];
            sum += std::atan2(a.cross(b).norm(), a.dot(b)) * normals_[face];
        }
        return sum;
    }

    const Mesh& mesh_;
    double half_width_;
    std::vector<Vector> positions_;
    std::vector<Vector> normals_;
    std::vector<FaceEdge> edges_;  ///< of a manifold in pairs
    std::vector<std::uint32_t> starts_;
    std::vector<std::uint32_t> corners_;  ///< 3 * face + which of its vertices
};

}  // namespace

std::vector<SiteSolid> site_solids(const Mesh& mesh, const Grid& grid, double half_width) {
    return Builder(mesh, grid, half_width).build();
}

}  // namespace clsdf::papers
