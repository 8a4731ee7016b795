#include "peikert_sigg/surface.hpp"

#include "mesh/equal_vertices.hpp"
#include "polyhedra/edge_slopes.hpp"
#include "polyhedra/non_manifold_edges.hpp"
#include "polyhedra/pair_edges.hpp"

#include <algorithm>
#include <cstddef>
#include <utility>

namespace clsdf::peikert_sigg {

namespace {

using namespace polyhedra;

std::vector<std::uint32_t> faces_of_three_vertices(const Mesh& mesh, const std::vector<std::uint32_t>& vertices) {
    std::vector<std::uint32_t> faces;
    for (std::uint32_t face = 0; face < mesh.triangles().size(); ++face) {
        const auto& [a, b, c] = mesh.triangles()[face];
        if (vertices[a] != vertices[b] && vertices[b] != vertices[c] && vertices[c] != vertices[a])
            faces.push_back(face);
    }
    return faces;
}

std::vector<Triangle> select(const Mesh& mesh, const std::vector<std::uint32_t>& vertices,
                             const std::vector<std::uint32_t>& faces) {
    std::vector<Triangle> triangles;
    triangles.reserve(faces.size());
    for (const std::uint32_t face : faces) {
        const auto& [a, b, c] = mesh.triangles()[face];
        triangles.push_back({vertices[a], vertices[b], vertices[c]});
    }
    return triangles;
}

LatticeView unit_of(const Mesh& mesh) {
    const double side = mesh.box().longest_side();
    return {mesh.box().lower, side > 0 ? side : 1};
}

}  // namespace

Surface::Surface(const Mesh& mesh)
    : mesh_(&mesh),
      representatives_(first_equal_vertices(mesh.vertices())),
      sources_(faces_of_three_vertices(mesh, representatives_)),
      triangles_(select(mesh, representatives_, sources_)),
      frames_(triangles_.size()),
      rings_(triangles_, mesh.vertices().size()) {
    const LatticeView unit = unit_of(mesh);
    const MeshFaces faces{mesh.vertices(), triangles_, unit};
    PairedEdges edges = pair_edges(triangles_, rings_);
    // Of the slopes only what they are decided from is used: the edges' marks and pairs.
    const float open = 1;
    const std::vector<EdgeSlope> of_non_manifold = non_manifold_slopes(faces, rings_, edges, open);
    measure_edges(faces, edges.faces, of_non_manifold, open, [&](const EdgeSlopes& stretch) {
        for (std::size_t face = stretch.begin(); face < stretch.end(); ++face) frames_[face] = stretch.frame(face);
    });
    edges_ = std::move(edges.faces);
}

EdgeKind Surface::kind(const Corner& edge) const {
    const std::uint8_t set = marks(edge);
    if (set & edge_non_manifold) return EdgeKind::non_manifold;
    if (set & edge_unoriented) return EdgeKind::unoriented;
    if (set & edge_convex) return EdgeKind::convex;
    if (set & edge_concave) return EdgeKind::concave;
    return has_pair(edge) ? EdgeKind::flat : EdgeKind::boundary;
}

bool Surface::has_pair(const Corner& edge) const {
    const std::uint8_t set = marks(edge);
    return !(set & edge_non_manifold) && (!(set & edge_open) || (set & edge_folded) != 0);
}

VertexKind Surface::kind(std::size_t vertex, VertexFans& fans) const {
    if (rings_.size(vertex) == 0) return VertexKind::unused;
    std::array<bool, edge_kinds> has{};
    for (std::size_t i = 0; i < rings_.size(vertex); ++i) {
        const Corner corner = rings_.corner(vertex, i);
        has[static_cast<std::size_t>(kind(corner))] = true;
        has[static_cast<std::size_t>(kind({corner.face, previous_of_three(corner.vertex)}))] = true;
    }
    const auto any = [&](EdgeKind kind) { return has[static_cast<std::size_t>(kind)]; };
    if (any(EdgeKind::non_manifold) || any(EdgeKind::unoriented)) return VertexKind::non_manifold;
    if (any(EdgeKind::boundary)) {
        return open_fan_size(vertex) == rings_.size(vertex) ? VertexKind::boundary : VertexKind::non_manifold;
    }
    build_fans(vertex, fans);
    if (fans.fan_count() != 1) return VertexKind::non_manifold;
    if (any(EdgeKind::convex)) return any(EdgeKind::concave) ? VertexKind::saddle : VertexKind::convex;
    return any(EdgeKind::concave) ? VertexKind::concave : VertexKind::flat;
}

std::size_t Surface::open_fan_size(std::size_t vertex) const {
    std::size_t size = 0;
    for (std::size_t i = 0; i < rings_.size(vertex) && size == 0; ++i) {
        Corner corner = rings_.corner(vertex, i);
        if (has_pair(corner)) continue;
        for (size = 1;; ++size) {
            const Corner arriving{corner.face, previous_of_three(corner.vertex)};
            if (!has_pair(arriving)) break;
            corner = across(arriving);
        }
    }
    return size;
}

void Surface::build_fans(std::size_t vertex, VertexFans& fans) const {
    fans.build(triangles_, edges_, rings_, vertex);
}

std::vector<Corner> Surface::edges_at(const Corner& edge) const {
    const std::uint32_t from = triangles_[edge.face][edge.vertex];
    const std::uint32_t to = triangles_[edge.face][next_of_three(edge.vertex)];
    std::vector<Corner> result;
    for (std::size_t i = 0; i < rings_.size(from); ++i) {
        const Corner corner = rings_.corner(from, i);
        const std::uint32_t previous = previous_of_three(corner.vertex);
        if (triangles_[corner.face][next_of_three(corner.vertex)] == to) result.push_back(corner);
        if (triangles_[corner.face][previous] == to) result.push_back({corner.face, previous});
    }
    std::sort(result.begin(), result.end(), [](const Corner& a, const Corner& b) { return a.packed() < b.packed(); });
    return result;
}

}  // namespace clsdf::peikert_sigg
