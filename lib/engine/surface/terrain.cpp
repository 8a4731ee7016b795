#include "surface/terrain.hpp"

#include "core/parallel.hpp"
#include "core/refuse.hpp"
#include "mesh/box_index.hpp"
#include "surface/parts.hpp"
#include "surface/ray_side.hpp"
#include "surface/topology.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <functional>
#include <tuple>
#include <utility>
#include <vector>

namespace clsdf {

namespace {

/// Faces that look up and down, by the exact sign of their area, seen from above.
struct Looks {
    std::size_t up = 0, down = 0, first_down = 0;

    friend Looks operator+(const Looks& a, const Looks& b) {
        return {a.up + b.up, a.down + b.down, a.down > 0 ? a.first_down : b.first_down};
    }
};

Looks looks_of(const Mesh& mesh, std::span<const Triangle> triangles) {
    constexpr std::size_t grain = 4096;
    const std::vector<Vec3>& vertices = mesh.vertices();
    return reduce_ranges(
        triangles.size(), grain, Looks{},
        [&](std::size_t begin, std::size_t end, Looks looks) {
            for (std::size_t face = begin; face < end; ++face) {
                const auto& [a, b, c] = triangles[face];
                if (has_repeated_vertex(triangles[face])) continue;
                const int side = side_of_line(vertices[a], vertices[b], vertices[c], 0, 1);
                looks = looks + Looks{side > 0 ? 1U : 0U, side < 0 ? 1U : 0U, face};
            }
            return looks;
        },
        std::plus<>());
}

/// The edges of a rim, seen from above. The mesh lies left of each.
class PlaneRim {
public:
    PlaneRim(const OpenLoops& rim, const std::vector<Vec3>& vertices)
        : edges_(edges_of(rim, vertices)), index_(boxes()) {}

    /// The edges that cross others, or on whose left side the rim does not go around the plane just once. If there is
    /// a part of the plane that it goes around more often, it has a corner at the end of such an edge, or at a
    /// crossing.
    std::vector<std::array<Vec3, 2>> overlapping() const {
        std::vector<std::uint8_t> is_found(edges_.size());
        for_each_index(edges_.size(), [&](std::size_t i) {
            const auto& [from, to] = edges_[i];
            is_found[i] =
                crosses(edges_[i]) || turns_beside(edges_[i], from, to) != 1 || turns_beside(edges_[i], to, from) != 1
                    ? 1
                    : 0;
        });
        std::vector<std::array<Vec3, 2>> found;
        for (std::size_t i = 0; i < edges_.size(); ++i)
            if (is_found[i] != 0) found.push_back(edges_[i]);
        return found;
    }

private:
    using Edge = std::array<Vec3, 2>;

    /// Vertical ones are points of the plane.
    static std::vector<Edge> edges_of(const OpenLoops& rim, const std::vector<Vec3>& vertices) {
        std::vector<Edge> edges;
        for (std::size_t loop = 0; loop + 1 < rim.begins.size(); ++loop) {
            const std::size_t begin = rim.begins[loop], end = rim.begins[loop + 1];
            for (std::size_t i = begin; i < end; ++i) {
                const Vec3 &a = vertices[rim.vertices[i]], &b = vertices[rim.vertices[i + 1 < end ? i + 1 : begin]];
                if (a[0] != b[0] || a[1] != b[1]) edges.push_back({a, b});
            }
        }
        return edges;
    }

    std::vector<Box> boxes() const {
        std::vector<Box> boxes;
        for (const auto& [a, b] : edges_)
            boxes.push_back(
                {{std::min(a[0], b[0]), std::min(a[1], b[1]), 0}, {std::max(a[0], b[0]), std::max(a[1], b[1]), 0}});
        return boxes;
    }

    static int side(const Vec3& a, const Vec3& b, const Vec3& p) { return side_of_line(a, b, p, 0, 1); }

    bool crosses(const Edge& edge) const {
        const auto& [a, b] = edge;
        Box box{a, a};
        add(box, {b, b});
        box.lower[2] = box.upper[2] = 0;
        return index_.any(box, [&](std::size_t other) {
            const auto& [c, d] = edges_[other];
            return side(a, b, c) * side(a, b, d) < 0 && side(c, d, a) * side(c, d, b) < 0;
        });
    }

    /// How often the rim goes around the point at + e (towards - at) + e^2 l, e positive and arbitrarily small, where
    /// l points to the left of the edge. at, towards: the ends of the edge.
    int turns_beside(const Edge& edge, const Vec3& at, const Vec3& towards) const {
        const auto& [from, to] = edge;
        const auto is_beneath = [&](const Vec3& p) {  // the point, in y
            if (p[1] != at[1]) return p[1] < at[1];
            return towards[1] != at[1] ? at[1] < towards[1] : from[0] < to[0];
        };
        const auto side_beside = [&](const Vec3& c, const Vec3& d) {
            if (const int given = side(c, d, at); given != 0) return given;
            if (const int along = side(c, d, towards); along != 0) return along;
            const std::size_t axis = from[0] != to[0] ? 0 : 1;
            return (c[axis] < d[axis]) == (from[axis] < to[axis]) ? 1 : -1;
        };
        Box ray{{-infinite_length, at[1], 0}, {at[0], at[1], 0}};
        int turns = 0;
        index_.any(ray, [&](std::size_t other) {
            const auto& [c, d] = edges_[other];
            const bool is_ascending = is_beneath(c);
            if (is_ascending == is_beneath(d)) return false;
            const int direction = is_ascending ? 1 : -1;
            if (side_beside(c, d) == -direction) turns -= direction;
            return false;
        });
        return turns;
    }

    std::vector<Edge> edges_;
    BoxIndex index_;
};

/// Appends copies of the vertices in use on the floor, and returns their numbers; those above each other have one.
std::vector<std::uint32_t> append_copies(std::span<const Triangle> triangles, double floor,
                                         std::vector<Vec3>& vertices) {
    std::vector<std::uint32_t> used;
    for (const Triangle& triangle : triangles) used.insert(used.end(), triangle.begin(), triangle.end());
    std::ranges::sort(used, {}, [&](std::uint32_t v) { return std::tuple(vertices[v][0], vertices[v][1], v); });
    std::vector<std::uint32_t> copies(vertices.size());
    for (const std::uint32_t v : used) {
        const Vec3 copy{vertices[v][0], vertices[v][1], floor};
        if (vertices.size() == copies.size() || vertices.back() != copy) vertices.push_back(copy);
        copies[v] = static_cast<std::uint32_t>(vertices.size() - 1);
    }
    return copies;
}

}  // namespace

bool describe_looks(const Mesh& mesh, std::span<const Triangle> triangles, Topology& report) {
    const Looks looks = looks_of(mesh, triangles);
    report.downward_faces = looks.down;
    report.first_downward_face = looks.down > 0 ? looks.first_down : 0;
    return looks.down == 0 && looks.up > 0;
}

void describe_rim(const Mesh& mesh, const OpenLoops& rim, Topology& report) {
    report.rim_loops = rim.begins.size() - 1;
    const auto found = PlaneRim(rim, mesh.vertices()).overlapping();
    report.overlapping_rim_edges = found.size();
    constexpr std::size_t limit = 5;
    for (std::size_t i = 0; i < std::min(found.size(), limit); ++i)
        report.first_overlapping_rim_edges.push_back({found[i][0], found[i][1]});
}

void check_floor(double floor, const Box& box, const std::string& mesh_name) {
    if (std::isfinite(floor) && floor < box.lower[2]) return;
    refuse(
        "the floor is at z = {}, and the lowest vertex of {} at z = {}; the sign rule below needs "
        "a finite floor below it",
        floor, mesh_name, box.lower[2]);
}

Mesh close_down(const Mesh& mesh, double floor) {
    const DescribedMesh described = describe_mesh(mesh, SignRule::below);
    resolve_sign_rule(SignRule::below, described.topology);
    check_floor(floor, mesh.box(), mesh.name());
    std::vector<Vec3> vertices = mesh.vertices();
    std::vector<Triangle> triangles = mesh.triangles();
    const std::vector<std::uint32_t> copies = append_copies(triangles, floor, vertices);
    const auto add = [&](const Triangle& triangle) {
        if (!has_repeated_vertex(triangle)) triangles.push_back(triangle);
    };
    const OpenLoops& rim = described.surface.open_loops;
    for (std::size_t loop = 0; loop + 1 < rim.begins.size(); ++loop) {
        const std::size_t begin = rim.begins[loop], end = rim.begins[loop + 1];
        for (std::size_t i = begin; i < end; ++i) {
            const std::uint32_t a = rim.vertices[i], b = rim.vertices[i + 1 < end ? i + 1 : begin];
            add({b, a, copies[a]});
            add({b, copies[a], copies[b]});
        }
    }
    for (std::size_t face = 0; face < mesh.triangles().size(); ++face) {
        const auto& [a, b, c] = mesh.triangles()[face];
        if (described.surface.count(face) != 0) add({copies[a], copies[c], copies[b]});
    }
    return {std::move(vertices), std::move(triangles), mesh.name()};
}

}  // namespace clsdf
