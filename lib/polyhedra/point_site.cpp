#include "polyhedra/point_site.hpp"

#include <algorithm>
#include <optional>
#include <vector>

namespace clsdf::polyhedra {

namespace {

/// Vertices with more neighbours get an unbounded polyhedron instead of a search among all pairs.
constexpr std::size_t few_neighbours = 24;

/// Directions to the vertex' neighbours, each once, in the caller's order.
std::vector<Vector> neighbour_directions(const MeshFaces& faces, std::span<const std::uint32_t> vertices,
                                         const OneRings& rings, std::uint32_t vertex) {
    std::vector<std::uint32_t> neighbours;
    for (std::size_t i = 0; i < rings.size(vertex); ++i) {
        const Corner corner = rings.corner(vertex, i);
        neighbours.push_back(faces.triangles[corner.face][next_of_three(corner.vertex)]);
        neighbours.push_back(faces.triangles[corner.face][previous_of_three(corner.vertex)]);
    }
    std::sort(neighbours.begin(), neighbours.end(),
              [&](std::uint32_t a, std::uint32_t b) { return vertices[a] < vertices[b]; });
    neighbours.erase(std::unique(neighbours.begin(), neighbours.end()), neighbours.end());
    std::vector<Vector> directions;
    directions.reserve(neighbours.size());
    for (const std::uint32_t neighbour : neighbours)
        directions.push_back(
            ((to_vector(faces.position(neighbour)) - to_vector(faces.position(vertex))) / faces.lattice.unit)
                .normalized());
    return directions;
}

/// The extreme rays of the normal cone {u : u . n <= 0 for all n}, each perpendicular to two neighbours; nullopt where
/// there are too many neighbours, or two of them are too nearly parallel to trust their cross product.
std::optional<std::vector<Vector>> extreme_rays(const std::vector<Vector>& neighbours) {
    constexpr double nearly_parallel = 1e-6;
    constexpr double tolerance = 1e-8;  // above the rounding of a ray, 2^-52 / nearly_parallel
    if (neighbours.size() > few_neighbours) return std::nullopt;
    std::vector<Vector> rays;
    for (std::size_t i = 0; i < neighbours.size(); ++i) {
        for (std::size_t j = i + 1; j < neighbours.size(); ++j) {
            const Vector cross = neighbours[i].cross(neighbours[j]);
            const double length = cross.norm();
            if (!(length > nearly_parallel)) return std::nullopt;
            for (const Vector& ray : {Vector(cross / length), Vector(-cross / length)}) {
                const auto in_cone = [&](const Vector& n) { return n.dot(ray) <= tolerance; };
                if (std::all_of(neighbours.begin(), neighbours.end(), in_cone)) rays.push_back(ray);
            }
        }
    }
    return rays;
}

/// Sets the slopes of a frame around the rays' mean; false where the cone is too wide, or no cone.
bool set_slopes(const std::vector<Vector>& rays, const TriangleFrame& frame, FaceSlopes& slopes) {
    constexpr double lowest = 1e-3;  // sine of a ray's angle to the frame's plane
    constexpr double tolerance = 1e-6;
    for (std::uint32_t k = 0; k < 3; ++k) {
        const Vector outward = -frame.inwards[k];
        double slope = 0;
        for (const Vector& ray : rays) {
            const double height = ray.dot(frame.normal);
            if (height < lowest) return false;
            slope = std::max(slope, ray.dot(outward) / height);
        }
        slopes.above[k] = widened(slope + tolerance);
        slopes.below[k] = 0;
    }
    return true;
}

}  // namespace

SiteFrustum point_site(const MeshFaces& faces, std::span<const std::uint32_t> order,
                       std::span<const std::uint32_t> vertices, const OneRings& rings, std::uint32_t vertex) {
    SiteFrustum site;
    site.vertex = vertex;
    site.face = rings.corner(vertex, 0).face;
    for (std::size_t i = 1; i < rings.size(vertex); ++i) {
        const std::uint32_t face = rings.corner(vertex, i).face;
        if (order[face] < order[site.face]) site.face = face;
    }
    const auto rays = extreme_rays(neighbour_directions(faces, vertices, rings, vertex));
    Vector sum = Vector::Zero();
    if (rays)
        for (const Vector& ray : *rays) sum += ray;
    const double length = sum.norm();
    site.normal = length > 1e-3 ? Vector(sum / length) : Vector::UnitZ();
    const TriangleFrame frame = point_frame(Vector::Zero(), site.normal);
    const bool bounded = rays && rays->size() >= 3 && length > 1e-3 && set_slopes(*rays, frame, site.slopes);
    if (!bounded) site.slopes.above = site.slopes.below = {CLSDF_OPEN_SLOPE, CLSDF_OPEN_SLOPE, CLSDF_OPEN_SLOPE};
    return site;
}

}  // namespace clsdf::polyhedra
