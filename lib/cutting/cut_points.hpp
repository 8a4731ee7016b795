#pragma once

#include <clsdf/mesh.hpp>

#include "cutting/filtered_number.hpp"
#include "mesh/mesh_arrays.hpp"

#include <CGAL/MP_Float.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <unordered_map>
#include <vector>

/// The points at which faces of a mesh are cut: exact, and numbered so that equal points are one.
namespace clsdf::cutting {

using Exact = CGAL::MP_Float;

/// What cuts a face: the plane of another face, or that through an edge in the face's own plane, along an axis.
struct Cutter {
    static constexpr std::uint8_t of_face = 3;

    std::uint32_t first = 0;      ///< the face, or a vertex of the edge,
    std::uint32_t second = 0;     ///< and its other vertex
    std::uint8_t axis = of_face;  ///< along which the plane of an edge runs

    static Cutter face(std::uint32_t face) { return {face, 0, of_face}; }
    static Cutter edge(std::uint32_t a, std::uint32_t b, std::size_t along) {
        return {std::min(a, b), std::max(a, b), static_cast<std::uint8_t>(along)};
    }
    friend auto operator<=>(const Cutter&, const Cutter&) = default;
};

/// The definition of a cut point: a vertex; an edge and a plane; three planes.
struct Source {
    enum Kind : std::uint8_t { vertex, edge, planes };

    Kind kind = vertex;
    std::array<std::uint32_t, 2> vertices{};  ///< the vertex; the edge's, the lower number first
    std::array<Cutter, 3> cutters{};          ///< one; three, ascending

    static Source of_vertex(std::uint32_t v) { return {vertex, {v, v}, {}}; }
    static Source of_edge(std::uint32_t a, std::uint32_t b, const Cutter& cutter) {
        return {edge, {std::min(a, b), std::max(a, b)}, {cutter}};
    }
    static Source of_planes(std::array<Cutter, 3> cutters);

    bool is_on_edge(std::uint32_t a, std::uint32_t b) const {
        return kind == edge && vertices[0] == std::min(a, b) && vertices[1] == std::max(a, b);
    }
    /// Whether it is known to lie on the cutter. If not, it may lie there all the same.
    bool is_on(const Cutter& cutter) const {
        const auto count = kind == vertex ? 0 : kind == edge ? 1 : 3;
        return std::find(cutters.begin(), cutters.begin() + count, cutter) != cutters.begin() + count;
    }

    friend bool operator==(const Source&, const Source&) = default;
};

/// Homogeneous coordinates: a point (x / w, y / w, z / w), w > 0.
template <typename Number>
struct HomogeneousPoint {
    std::array<Number, 3> at;
    Number w;
};

/// Mesh, and the points on it.
class CutPoints {
public:
    /// Exact places that are needed more than once. For one thread.
    using Cache = std::unordered_map<std::uint32_t, HomogeneousPoint<Exact>>;

    /// A point that has no number yet.
    struct Found {
        Source source;
        HomogeneousPoint<FilteredNumber> near;
        Vec3 rounded;  ///< to the nearest doubles
    };

    /// Vertices have the first numbers; equal ones must be one. triangles: those that are cut.
    CutPoints(std::span<const Vec3> vertices, std::span<const Triangle> triangles);

    std::span<const Vec3> vertices() const { return vertices_; }
    std::span<const Triangle> triangles() const { return triangles_; }
    const Vec3& vertex(std::uint32_t v) const { return vertices_[v]; }

    /// Thread-safe.
    Found find(const Source& source) const;
    /// The number of a point: that of an equal one, or a new one.
    std::uint32_t number(const Found& found);

    std::size_t size() const { return points_.size(); }
    const Source& source(std::uint32_t point) const { return points_[point].source; }
    /// Nearest to the point on each axis.
    const Vec3& rounded(std::uint32_t point) const { return points_[point].rounded; }

    /// 1: a, b, c run counterclockwise, seen along the axis from its positive end.
    int orientation(std::uint32_t a, std::uint32_t b, std::uint32_t c, std::size_t axis, Cache& cache) const;
    /// 1: a's coordinate is greater.
    int compare(std::uint32_t a, std::uint32_t b, std::size_t axis, Cache& cache) const;

    /// Barycentric coordinates of a point of a face: the weights of the vertices 1 and 2. axis: the face's view.
    std::array<double, 2> weights(std::uint32_t point, std::uint32_t face, std::size_t axis, Cache& cache) const;

    /// A point within a triangle of points: their mean with such weights.
    class Inner {
    public:
        Inner(const CutPoints& points, const std::array<std::uint32_t, 3>& corners, const Vec3& weights);

        /// Around the point; small.
        Box box() const;
        /// 1: vertices a, b and the point run counterclockwise, seen along the axis.
        int orientation(std::uint32_t a, std::uint32_t b, std::size_t axis);
        /// 1: the point is on the side of the face to which its normal points.
        int side(const Triangle& face);

    private:
        template <typename Number>
        HomogeneousPoint<Number> homogeneous() const;
        const HomogeneousPoint<Exact>& exact();

        const CutPoints& points_;
        std::array<std::uint32_t, 3> corners_;
        Vec3 weights_;
        HomogeneousPoint<FilteredNumber> near_;
        std::vector<HomogeneousPoint<Exact>> exact_;  // none or one
        Vec3 middle_{};                               // near the point,
        double off_ = 0;                              // off by at most that
    };

private:
    template <typename Number>
    HomogeneousPoint<Number> homogeneous(const Source& source) const;
    const HomogeneousPoint<Exact>& exact(std::uint32_t point, Cache& cache) const;

    std::span<const Vec3> vertices_;
    std::span<const Triangle> triangles_;
    std::vector<Found> points_;
    std::unordered_multimap<std::uint64_t, std::uint32_t> by_rounded_;  // points by the hash of their coordinates
};

}  // namespace clsdf::cutting
