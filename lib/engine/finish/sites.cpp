#include "finish/sites.hpp"

#include "core/parallel.hpp"
#include "frusta/frames.hpp"

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <limits>
#include <span>
#include <vector>

namespace clsdf::engine {

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
        if (face > 0 && topology.order[face] == topology.order[face - 1]) return;  // it fills up a group of records
        const auto& [across, marks, unused] = topology.edges.faces[face];
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
                if (!has_mark(topology.edges.faces, edge.front().edge(), edge_non_manifold)) return;
                faces.clear();
                for (const EdgeEntry& entry : edge) faces.push_back(edge_of(topology, entry.edge()));
                std::sort(faces.begin(), faces.end());
                f(std::span<const SiteOfFace>(faces));
            });
        }
    });
}

/// Far above the rounding of frames and of what kernels take for no distance (kernels/finish/finish.h). In samples.
constexpr double meeting_tolerance = 1e-5;
/// Edges that are longer, or lie farther out, are not looked at. In samples.
constexpr double longest_edge = 64, farthest_end = 0x1p31;

double nearest_whole(double x) {
    return static_cast<double>(static_cast<std::int64_t>(x < 0 ? x - 0.5 : x + 0.5));
}

/// Whether there is a whole number in [low, high]. low: above -farthest_end.
bool has_whole(double low, double high) {
    const auto whole = static_cast<double>(static_cast<std::int64_t>(high + farthest_end)) - farthest_end;
    return whole >= low;
}

/// Whether an edge may pass a point with whole coordinates: it does so near a whole coordinate on its longest axis.
bool may_meet_sample(const Vec3& a, const Vec3& b) {
    bool is_near = true, has_point = true;  // without branches: most edges have no such point in their box
    for (std::size_t i = 0; i < 3; ++i) {
        is_near &= std::abs(a[i]) < farthest_end && std::abs(b[i]) < farthest_end;
        has_point &= has_whole(std::min(a[i], b[i]) - meeting_tolerance, std::max(a[i], b[i]) + meeting_tolerance);
    }
    if (!is_near) return true;
    if (!has_point) return false;
    std::size_t axis = 0;
    for (std::size_t i = 1; i < 3; ++i)
        if (std::abs(b[i] - a[i]) > std::abs(b[axis] - a[axis])) axis = i;
    const double length = b[axis] - a[axis];
    if (!(std::abs(length) < longest_edge)) return true;
    const double low = std::min(a[axis], b[axis]) - meeting_tolerance;
    const double high = std::max(a[axis], b[axis]) + meeting_tolerance;
    for (double whole = nearest_whole(low); whole <= high; ++whole) {
        const double part = length != 0 ? std::clamp((whole - a[axis]) / length, 0.0, 1.0) : 0;
        const auto is_whole = [&](std::size_t i) {
            const double at = a[i] + part * (b[i] - a[i]);
            return std::abs(at - nearest_whole(at)) <= meeting_tolerance;
        };
        if (is_whole((axis + 1) % 3) && is_whole((axis + 2) % 3) && is_whole(axis)) return true;
    }
    return false;
}

}  // namespace

bool may_meet_samples(const MeshTopology& topology, std::span<const Vec3> positions, const Vec3& origin,
                      const Vec3& spacing) {
    const Vec3 per_spacing{1 / spacing[0], 1 / spacing[1], 1 / spacing[2]};
    const auto in_samples = [&](std::uint32_t vertex) {
        Vec3 at{};
        for (std::size_t i = 0; i < 3; ++i) at[i] = (positions[vertex][i] - origin[i]) * per_spacing[i];
        return at;
    };
    std::atomic<bool> found = false;
    for_each_range(topology.order.size(), [&](std::size_t begin, std::size_t end) {
        for (std::size_t face = begin; face < end && !found; ++face) {
            const Triangle& triangle = topology.faces.triangles[face];
            const std::array corners{in_samples(triangle[0]), in_samples(triangle[1]), in_samples(triangle[2])};
            for (std::uint32_t k = 0; k < 3; ++k) {
                const std::uint32_t next = next_of_three(k);
                // Only one of two faces that run along an edge in opposite directions looks at it.
                if (triangle[k] > triangle[next] && topology.edges.faces[face].marks[k] == 0) continue;
                if (may_meet_sample(corners[k], corners[next])) found = true;
            }
        }
    });
    return found;
}

void name_sites(const MeshTopology& topology, std::span<TriangleSites> names) {
    for_each_site(topology, [&](std::span<const SiteOfFace> faces) {
        const SiteOfFace& lowest = faces.front();
        for (const SiteOfFace& face : faces) {
            const std::uint32_t turned = face.is_reversed != lowest.is_reversed ? CLSDF_SITE_REVERSED : 0U;
            TriangleSites& named = names[face.triangle];
            named.triangle[face.site] = lowest.triangle;
            named.site[face.site] = static_cast<std::uint8_t>(lowest.site | turned);
            if (face.site == 0) named.unused[0] = named.unused[1] = 0;
        }
    });
}

namespace {

/// How often a face of the caller's order counts, and in which direction: of a mesh that decides its sign itself.
constexpr int once(std::uint32_t) {
    return 1;
}

template <typename Count>
void make_pseudonormals(const MeshTopology& topology, std::span<const Vec3> positions, const Count& count,
                        bool keeps_others, std::span<float> normals) {
    UninitializedVector<FaceShape> shapes(topology.order.size());
    for_each_index(shapes.size(), [&](std::size_t face) {
        const auto& [a, b, c] = topology.faces.triangles[face];
        const auto at = [&](std::uint32_t vertex) { return to_vector(positions[topology.faces.vertices[vertex]]); };
        shapes[face] = shape_of({at(a), at(b), at(c)});
    });
    for_each_site(topology, [&](std::span<const SiteOfFace> faces) {
        NormalSum sum;
        for (const SiteOfFace& face : faces)
            if (const int times = count(face.triangle); times != 0)
                sum.add(times * shapes[face.face].normal, face.site < 3 ? shapes[face.face].angles[face.site] : 1);
        if (keeps_others && sum.weights == 0) return;
        std::array<float, 3> normal;
        sum.store(normal.data());
        for (const SiteOfFace& face : faces)
            std::copy(normal.begin(), normal.end(),
                      normals.begin() + static_cast<std::ptrdiff_t>(18 * std::size_t{face.triangle} + 3 * face.site));
    });
}

}  // namespace

void make_pseudonormals(const MeshTopology& topology, std::span<const Vec3> positions, std::span<float> normals) {
    make_pseudonormals(topology, positions, once, false, normals);
}

void make_pseudonormals(const Mesh& mesh, const SignSurface& surface, const MeshTopology& topology,
                        std::span<float> normals) {
    make_pseudonormals(topology, mesh.vertices(), normals);
    if (surface.is_mesh()) return;
    std::vector<Triangle> triangles = mesh.triangles();
    for (Triangle& triangle : triangles)
        for (std::uint32_t& index : triangle) index = surface.vertex(index);
    const MeshTopology of_surface(Mesh(mesh.vertices(), std::move(triangles), mesh.name()), topology.order);
    make_pseudonormals(
        of_surface, mesh.vertices(), [&](std::uint32_t face) { return surface.count(face); }, true, normals);
}

}  // namespace clsdf::engine
