#include "points/face_sides.hpp"

#include "core/parallel.hpp"
#include "frusta/frames.hpp"
#include "points/signs_by_host.hpp"
#include "side_shapes.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numeric>
#include <vector>

namespace clsdf::points {

namespace {

using engine::Vector;

constexpr double least_gap = LEAST_SIDE_GAP, least_altitude = LEAST_SIDE_ALTITUDE, least_sine = LEAST_SIDE_SINE,
                 least_angle = LEAST_SIDE_ANGLE, least_cosine_at_vertex = LEAST_COSINE_OF_VERTEX,
                 offset_in_front = OFFSET_IN_FRONT, least_altitude_in_front = LEAST_ALTITUDE_IN_FRONT;
constexpr std::size_t most_in_fan = MOST_SIDES_IN_FAN;

/// A face's corners in units, and what follows from them.
struct Shape {
    std::array<Vector, 3> corners;
    Vector normal;
    double altitude;  ///< the least; 0: no normal
    double longest;   ///< side
};

Shape shape_of(const engine::PointMesh& mesh, std::size_t face) {
    Shape shape{};
    const auto corners = mesh.corners(face);
    for (std::size_t k = 0; k < 3; ++k) shape.corners[k] = engine::to_vector(mesh.in_units(corners[k]));
    const auto& [a, b, c] = shape.corners;
    const Vector product = (b - a).cross(c - a);
    const double length = product.norm();
    const double longest = std::sqrt(std::max({(b - a).squaredNorm(), (c - b).squaredNorm(), (a - c).squaredNorm()}));
    shape.altitude = length > 0 ? length / longest : 0;
    shape.longest = longest;
    shape.normal = length > 0 ? Vector(product / length) : Vector(0, 0, 0);
    return shape;
}

/// Whether a plane separates all of the points by more than the gap from the others.
template <typename Points, typename Others>
bool separates(const Vector& axis, const Points& points, const Others& others, double gap) {
    constexpr double infinite = std::numeric_limits<double>::infinity();
    double least = infinite, most = -infinite, least_other = infinite, most_other = -infinite;
    for (const Vector& p : points) {
        const double at = engine::dot(axis, p);
        least = std::min(least, at);
        most = std::max(most, at);
    }
    for (const Vector& p : others) {
        const double at = engine::dot(axis, p);
        least_other = std::min(least_other, at);
        most_other = std::max(most_other, at);
    }
    return std::max(least - most_other, least_other - most) > gap * axis.norm();
}

/// Whether two faces without a common vertex are apart.
bool are_apart(const Shape& f, const Shape& g) {
    if (separates(f.normal, f.corners, g.corners, least_gap) || separates(g.normal, f.corners, g.corners, least_gap))
        return true;
    for (std::size_t i = 0; i < 3; ++i)
        for (std::size_t j = 0; j < 3; ++j) {
            const Vector axis = (f.corners[(i + 1) % 3] - f.corners[i]).cross(g.corners[(j + 1) % 3] - g.corners[j]);
            if (axis.squaredNorm() > 1e-20 && separates(axis, f.corners, g.corners, least_gap)) return true;
        }
    return false;
}

/// Whether a plane through the common vertex of two faces (their i-th and j-th) separates their angles.
bool spread_apart(const Shape& f, std::size_t i, const Shape& g, std::size_t j) {
    const auto edges_at = [](const Shape& shape, std::size_t k) {
        return std::array<Vector, 2>{(shape.corners[(k + 1) % 3] - shape.corners[k]).normalized(),
                                     (shape.corners[(k + 2) % 3] - shape.corners[k]).normalized()};
    };
    const auto of_f = edges_at(f, i), of_g = edges_at(g, j);
    const auto divides = [&](const Vector& axis) {
        const double least = least_angle * axis.norm();
        const auto all = [least](const auto& edges, const Vector& direction) {
            return engine::dot(edges[0], direction) > least && engine::dot(edges[1], direction) > least;
        };
        return (all(of_f, axis) && all(of_g, -axis));
    };
    const Vector middle = (of_f[0] + of_f[1]).normalized() - (of_g[0] + of_g[1]).normalized();
    if (divides(middle)) return true;
    // From the pairs of edges that face each other, with each edge's own weight.
    for (const Vector& a : of_f)
        for (const Vector& b : of_g)
            if (divides(a - b) || divides(middle + (a - b))) return true;
    return false;
}

/// Whether two faces with a common edge fold onto each other. The edge begins at vertex i of one; `apex` is the vertex
/// of the other that is not on it.
bool is_folded(const Shape& f, std::size_t i, const Shape& g, std::size_t apex) {
    const Vector edge = (f.corners[(i + 1) % 3] - f.corners[i]).normalized();
    const auto away = [&](const Vector& p) {
        const Vector from = p - f.corners[i];
        return Vector((from - edge * engine::dot(edge, from)).normalized());
    };
    return engine::dot(away(f.corners[(i + 2) % 3]), away(g.corners[apex])) > 1 - least_angle * least_angle / 2;
}

/// Finds the sides of a mesh's faces.
class Finder {
public:
    Finder(const engine::SearchedMesh& searched, SignRule rule)
        : searched_(searched), mesh_(searched.mesh), topology_(*mesh_.topology), rule_(rule) {
        const std::size_t count = mesh_.face_count();
        shapes_.resize(count);
        is_excluded_.assign(count, 0);
        for_each_index(count, [&](std::size_t face) {
            shapes_[face] = shape_of(mesh_, face);
            const Shape& shape = shapes_[face];
            const bool is_sliver = !(shape.altitude > std::max(least_altitude, least_sine * shape.longest));
            const bool is_in_a_large_fan = std::ranges::any_of(
                vertices(face), [&](std::uint32_t vertex) { return topology_.rings.size(vertex) > most_in_fan; });
            const bool is_other_for_sign = mesh_.has_joined_vertex(face) || mesh_.sign_count(face) == 0;
            is_excluded_[face] = is_sliver || is_in_a_large_fan || is_other_for_sign ? 1 : 0;
        });
    }

    /// The sides of each face.
    std::vector<std::uint16_t> find() {
        compare_all();
        join();
        look_in_front();
        look_at_vertices();
        std::vector<std::uint16_t> sides(mesh_.face_count());
        for_each_index(sides.size(), [&](std::size_t face) { sides[face] = sides_of(face); });
        return sides;
    }

private:
    const Triangle& vertices(std::size_t face) const { return topology_.faces.triangles[face]; }

    /// All pairs but those of two faces that are excluded from the start. Slivers and large fans have too many of
    /// these.
    void compare_all() {
        const std::vector<std::uint8_t> at_first = is_excluded_;
        for_each_index(mesh_.face_count(), [&](std::size_t face) {
            if (at_first[face] != 0) return;
            const engine::WideTree& tree = searched_.tree;
            engine::visit_faces(tree, engine::face_box(tree, face), [&](std::size_t other) {
                const bool is_once = other > face || at_first[other] != 0;
                if (other != face && is_once && !is_harmless(face, other)) {
                    exclude(face);
                    exclude(other);
                }
                return false;
            });
        });
    }

    void exclude(std::size_t face) { std::atomic_ref(is_excluded_[face]).store(1, std::memory_order_relaxed); }

    /// Whether the two come together in common vertices alone.
    bool is_harmless(std::size_t f, std::size_t g) const {
        if (!(shapes_[f].altitude > least_altitude) || !(shapes_[g].altitude > least_altitude)) return false;
        std::array<std::size_t, 3> of_f{}, of_g{};
        std::size_t common = 0;
        for (std::size_t i = 0; i < 3; ++i)
            for (std::size_t j = 0; j < 3; ++j)
                if (vertices(f)[i] == vertices(g)[j] && common < 3) {
                    of_f[common] = i;
                    of_g[common++] = j;
                }
        if (common == 0) return are_apart(shapes_[f], shapes_[g]);
        if (common == 1) return spread_apart(shapes_[f], of_f[0], shapes_[g], of_g[0]);
        if (common > 2) return false;
        const std::size_t first = (of_f[0] + 1) % 3 == of_f[1] ? of_f[0] : of_f[1];
        return !is_folded(shapes_[f], first, shapes_[g], 3 - of_g[0] - of_g[1]);
    }

    bool is_included(std::size_t face) const { return is_excluded_[face] == 0; }

    /// The face across an edge that two faces of one orientation share; or the same face.
    std::size_t across(std::size_t face, std::size_t edge) const {
        const engine::FaceEdges& edges = topology_.edges.faces[face];
        return edges.marks[edge] == 0 ? Corner::unpack(edges.across[edge]).face : face;
    }

    /// Faces whose fronts are one place get one root.
    void join() {
        root_.resize(mesh_.face_count());
        std::iota(root_.begin(), root_.end(), 0U);
        for (std::size_t face = 0; face < root_.size(); ++face)
            for (std::size_t edge = 0; edge < 3; ++edge) {
                const std::size_t other = across(face, edge);
                if (other < face && is_included(face) && is_included(other)) root_[root_of(face)] = root_of(other);
            }
        for (std::size_t face = 0; face < root_.size(); ++face) root_[face] = root_of(face);
    }

    std::uint32_t root_of(std::size_t face) {
        auto at = static_cast<std::uint32_t>(face);
        while (root_[at] != at) at = root_[at] = root_[root_[at]];
        return at;
    }

    /// The sides of each root: crossings from a point in front of the face with the greatest altitude.
    void look_in_front() {
        std::vector<std::uint32_t> faces(root_.size(), CLSDF_NO_FACE);
        for (std::size_t face = 0; face < root_.size(); ++face) {
            std::uint32_t& best = faces[root_[face]];
            if (is_included(face) && (best == CLSDF_NO_FACE || shapes_[face].altitude > shapes_[best].altitude))
                best = static_cast<std::uint32_t>(face);
        }
        of_root_.assign(root_.size(), 0);
        for_each_index(root_.size(), [&](std::size_t root) {
            if (faces[root] != CLSDF_NO_FACE) of_root_[root] = sides_by_crossings(faces[root]);
        });
    }

    /// CLSDF_SIDES_KNOWN and which sides are inside; or nothing.
    std::uint16_t sides_by_crossings(std::size_t face) const {
        const Shape& shape = shapes_[face];
        if (!(shape.altitude > least_altitude_in_front)) return 0;
        const Vector middle = (shape.corners[0] + shape.corners[1] + shape.corners[2]) / 3;
        const Vector aim = middle + offset_in_front * shape.normal;
        Vec3 point{};
        for (std::size_t axis = 0; axis < 3; ++axis)
            point[axis] = mesh_.lattice.origin[axis] + aim[static_cast<Eigen::Index>(axis)] * mesh_.lattice.unit;
        const Vec3 in_units = mesh_.in_units(point);
        // Coordinates far from zero are too coarse.
        if (!((engine::to_vector(in_units) - aim).norm() < 0.5 * offset_in_front)) return 0;
        const Crossings in_front = count_crossings(searched_, point, in_units);
        const Crossings behind{in_front.winding + mesh_.sign_count(face), in_front.count + 1};
        return static_cast<std::uint16_t>(CLSDF_SIDES_KNOWN |
                                          (in_front.are_inside(rule_) ? CLSDF_SIDES_FRONT_INSIDE : 0) |
                                          (behind.are_inside(rule_) ? CLSDF_SIDES_BACK_INSIDE : 0));
    }

    /// Bits of the sites that tell the side too: all their faces have it.
    std::uint16_t sides_of(std::size_t face) const {
        if (!is_included(face)) return 0;
        std::uint16_t sides = of_root_[root_[face]];
        // The pseudonormals of a face that is turned around point to its back.
        if (sides == 0 || mesh_.sign_count(face) < 0) return sides;
        for (std::size_t k = 0; k < 3; ++k) {
            if (const std::size_t other = across(face, k); other != face && has_root_of(face, other))
                sides = static_cast<std::uint16_t>(sides | 1U << (3 + k));
            if (tells_side_[vertices(face)[k]] != 0) sides = static_cast<std::uint16_t>(sides | 1U << k);
        }
        return sides;
    }

    bool has_root_of(std::size_t face, std::size_t other) const {
        return is_included(other) && root_[other] == root_[face];
    }

    /// Vertices whose faces go once around them, have one root, and are flat enough.
    void look_at_vertices() {
        tells_side_.resize(topology_.faces.vertices.size());
        for_each_index(tells_side_.size(), [&](std::size_t vertex) {
            const std::size_t count = topology_.rings.size(vertex);
            if (count == 0 || count > most_in_fan) return;
            const Corner first = topology_.rings.corner(vertex, 0);
            const bool is_one_fan = engine::walk_fan(topology_.edges.faces, first, count, [&](const Corner& corner) {
                return has_root_of(first.face, corner.face);
            });
            tells_side_[vertex] = is_one_fan && is_flat_enough(vertex) ? 1 : 0;
        });
    }

    /// Whether the normals of the faces at a vertex are all near their sum, weighted by angles.
    bool is_flat_enough(std::size_t vertex) const {
        const std::size_t count = topology_.rings.size(vertex);
        Vector sum(0, 0, 0);
        for (std::size_t i = 0; i < count; ++i) {
            const Corner corner = topology_.rings.corner(vertex, i);
            const Shape& shape = shapes_[corner.face];
            const Vector one = shape.corners[(corner.vertex + 1) % 3] - shape.corners[corner.vertex];
            const Vector other = shape.corners[(corner.vertex + 2) % 3] - shape.corners[corner.vertex];
            sum += std::atan2(one.cross(other).norm(), engine::dot(one, other)) * shape.normal;
        }
        const double least = least_cosine_at_vertex * sum.norm();
        for (std::size_t i = 0; i < count; ++i)
            if (!(engine::dot(shapes_[topology_.rings.corner(vertex, i).face].normal, sum) > least)) return false;
        return true;
    }

    engine::SearchedMesh searched_;
    const engine::PointMesh& mesh_;
    const engine::MeshTopology& topology_;
    SignRule rule_;
    UninitializedVector<Shape> shapes_;
    std::vector<std::uint8_t> is_excluded_;
    std::vector<std::uint32_t> root_;
    std::vector<std::uint16_t> of_root_;
    std::vector<std::uint8_t> tells_side_;  ///< by vertex: 1 if its pseudonormal tells the side of its faces
};

}  // namespace

bool are_sides_worthwhile(std::size_t points, std::size_t faces) {
    constexpr std::size_t fewest = 16384;
    return points >= std::max(faces, fewest);
}

FaceSides find_face_sides(const engine::DeviceTools& tools, const engine::SearchedMesh& searched, SignRule rule) {
    const std::vector<std::uint16_t> sides = Finder(searched, rule).find();
    FaceSides result;
    result.sides = device::uploaded(tools.context, tools.pool, sides, "sides of faces");
    return result;
}

}  // namespace clsdf::points
