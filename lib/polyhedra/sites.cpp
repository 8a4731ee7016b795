#include "polyhedra/sites.hpp"

#include "core/parallel.hpp"
#include "polyhedra/frames.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <span>
#include <vector>

namespace clsdf::polyhedra {

namespace {

/// A sum of unit vectors that is shorter than its rounding has no direction.
constexpr double cancelled = 1e-6;

/// A face's unit normal, or nothing but zeros, and its angles. In double, for normals that nearly cancel each other.
struct FaceShape {
    Vector normal;
    std::array<double, 3> angles;
};

FaceShape shape_of(const std::array<Vector, 3>& corners) {
    std::array<Vector, 3> edges;
    double longest = 0;
    for (std::uint32_t k = 0; k < 3; ++k) {
        edges[k] = corners[next_of_three(k)] - corners[k];
        longest = std::max(longest, edges[k].cwiseAbs().maxCoeff());
    }
    FaceShape shape{Vector::Zero(), {0, 0, 0}};
    if (!(longest > 0)) return shape;
    for (Vector& edge : edges) edge /= longest;  // their squares stay in a double's range
    // From the shortest two edges, whose product rounds least.
    std::array<double, 3> squared{};
    for (std::size_t k = 0; k < 3; ++k) squared[k] = edges[k].squaredNorm();
    const auto base = static_cast<std::uint32_t>(std::max_element(squared.begin(), squared.end()) - squared.begin());
    const Vector cross = edges[next_of_three(base)].cross(edges[previous_of_three(base)]);
    const double area = cross.norm();
    if (!(area > 0)) return shape;
    shape.normal = cross / area;
    for (std::uint32_t k = 0; k < 3; ++k)
        shape.angles[k] = std::atan2(area, -edges[k].dot(edges[previous_of_three(k)]));
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

/// A site as one of the faces that share it has it.
struct SiteOfFace {
    std::uint32_t triangle;  ///< the face's index in the caller's order
    std::uint32_t site;
    std::uint32_t face;
    bool is_reversed;  ///< of an edge: it runs to the vertex with the lower number

    bool operator<(const SiteOfFace& other) const {
        return triangle != other.triangle ? triangle < other.triangle : site < other.site;
    }
};

SiteOfFace vertex_of(const MeshTopology& topology, const Corner& corner) {
    return {topology.order[corner.face], corner.vertex, corner.face, false};
}

SiteOfFace edge_of(const MeshTopology& topology, const Corner& edge) {
    const Triangle& triangle = topology.faces.triangles[edge.face];
    return {topology.order[edge.face], 3 + edge.vertex, edge.face,
            triangle[edge.vertex] > triangle[next_of_three(edge.vertex)]};
}

/// Calls f(faces) for each vertex and edge, with the site as each of its faces has it, in the caller's order; from
/// several threads.
template <typename Function>
void for_each_site(const MeshTopology& topology, const Function& f) {
    for_each_range(topology.rings.vertex_count(), [&](std::size_t begin, std::size_t end) {
        std::vector<SiteOfFace> faces;
        for (std::size_t vertex = begin; vertex < end; ++vertex) {
            faces.clear();
            for (std::size_t i = 0; i < topology.rings.size(vertex); ++i)
                faces.push_back(vertex_of(topology, topology.rings.corner(vertex, i)));
            std::sort(faces.begin(), faces.end());
            f(std::span<const SiteOfFace>(faces));
        }
    });
    for_each_index(topology.order.size(), [&](std::size_t face) {
        const auto& [across, marks] = topology.edges.faces[face];
        for (std::uint32_t k = 0; k < 3; ++k) {
            if (marks[k] & edge_non_manifold) continue;
            std::array<SiteOfFace, 2> faces{edge_of(topology, {static_cast<std::uint32_t>(face), k})};
            const bool is_alone = (marks[k] & (edge_open | edge_at_box)) != 0;
            if (!is_alone) faces[1] = edge_of(topology, Corner::unpack(across[k]));
            if (is_alone || faces[0] < faces[1]) f(std::span<const SiteOfFace>(faces).first(is_alone ? 1 : 2));
        }
    });
    const std::vector<std::uint32_t>& ends = topology.edges.non_manifold_ends;
    for_each_range(ends.size(), [&](std::size_t begin, std::size_t end) {
        std::vector<EdgeEntry> entries;
        std::vector<SiteOfFace> faces;
        for (std::size_t i = begin; i < end; ++i) {
            edges_above(topology.faces.triangles, topology.rings, ends[i], entries);
            for_each_edge(entries, [&](std::span<const EdgeEntry> edge) {
                if (!is_non_manifold(edge)) return;
                faces.clear();
                for (const EdgeEntry& entry : edge) faces.push_back(edge_of(topology, entry.edge()));
                std::sort(faces.begin(), faces.end());
                f(std::span<const SiteOfFace>(faces));
            });
        }
    });
}

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

void name_sites(const MeshTopology& topology, std::span<TriangleSites> names) {
    for_each_site(topology, [&](std::span<const SiteOfFace> faces) {
        const SiteOfFace& lowest = faces.front();
        for (const SiteOfFace& face : faces) {
            const std::uint32_t turned = face.is_reversed != lowest.is_reversed ? CLSDF_SITE_REVERSED : 0U;
            names[face.triangle].triangle[face.site] = lowest.triangle;
            names[face.triangle].site[face.site] = static_cast<std::uint8_t>(lowest.site | turned);
        }
    });
}

void make_pseudonormals(const MeshTopology& topology, std::span<const Vec3> positions, std::span<float> normals) {
    UninitializedVector<FaceShape> shapes(topology.order.size());
    for_each_index(shapes.size(), [&](std::size_t face) {
        const auto& [a, b, c] = topology.faces.triangles[face];
        const auto at = [&](std::uint32_t vertex) { return to_vector(positions[topology.faces.vertices[vertex]]); };
        shapes[face] = shape_of({at(a), at(b), at(c)});
    });
    for_each_site(topology, [&](std::span<const SiteOfFace> faces) {
        NormalSum sum;
        for (const SiteOfFace& face : faces)
            sum.add(shapes[face.face].normal, face.site < 3 ? shapes[face.face].angles[face.site] : 1);
        std::array<float, 3> normal;
        sum.store(normal.data());
        for (const SiteOfFace& face : faces)
            std::copy(normal.begin(), normal.end(),
                      normals.begin() + static_cast<std::ptrdiff_t>(18 * std::size_t{face.triangle} + 3 * face.site));
    });
}

}  // namespace clsdf::polyhedra
