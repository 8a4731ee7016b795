#include <clsdf/papers.hpp>

#include "core/parallel.hpp"
#include "frusta/slopes.hpp"
#include "mesh/equal_vertices.hpp"
#include "papers/gap_tests.hpp"
#include "topology/topology.hpp"

#include <tbb/enumerable_thread_specific.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cstddef>
#include <optional>
#include <string>
#include <utility>

namespace clsdf::papers {

namespace {

using namespace engine;

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

MeshSurface::MeshSurface(const Mesh& mesh)
    : mesh_(&mesh),
      representatives_(first_equal_vertices(mesh.vertices())),
      sources_(faces_of_three_vertices(mesh, representatives_)),
      triangles_(select(mesh, representatives_, sources_)),
      frames_(triangles_.size()),
      rings_(triangles_, mesh.vertices().size()) {
    const LatticeView unit = unit_of(mesh);
    const MeshFaces faces{mesh.vertices(), triangles_, unit};
    PairedEdges edges = pair_edges(triangles_, rings_);
    const FaceMeasures measures(faces, rings_, edges);
    std::vector<std::array<std::uint8_t, 3>> marks(triangles_.size());
    for_each_index(marks.size(), [&](std::size_t face) {
        const MeasuredFace measured = measures.measure(static_cast<std::uint32_t>(face));
        frames_[face] = measured.frame;
        marks[face] = measured.marks;
    });
    for_each_index(marks.size(), [&](std::size_t face) { edges.faces[face].marks = marks[face]; });
    edges_ = std::move(edges.faces);
}

EdgeKind MeshSurface::kind(const Corner& edge) const {
    const std::uint8_t set = marks(edge);
    if (set & edge_non_manifold) return EdgeKind::non_manifold;
    if (set & edge_unoriented) return EdgeKind::unoriented;
    if (set & edge_convex) return EdgeKind::convex;
    if (set & edge_concave) return EdgeKind::concave;
    return has_pair(edge) ? EdgeKind::flat : EdgeKind::boundary;
}

bool MeshSurface::has_pair(const Corner& edge) const {
    const std::uint8_t set = marks(edge);
    return !(set & edge_non_manifold) && (!(set & edge_open) || (set & edge_folded) != 0);
}

VertexKind MeshSurface::kind(std::size_t vertex, VertexFans& fans) const {
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

std::size_t MeshSurface::open_fan_size(std::size_t vertex) const {
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

void MeshSurface::build_fans(std::size_t vertex, VertexFans& fans) const {
    fans.build(triangles_, edges_, rings_, vertex);
}

std::vector<Corner> MeshSurface::edges_at(const Corner& edge) const {
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

}  // namespace clsdf::papers

namespace clsdf {

namespace {

using namespace papers;
using engine::VertexFans;

constexpr std::array<const char*, edge_kinds> edge_names{"convex",   "concave",    "flat",
                                                         "boundary", "unoriented", "non-manifold"};
constexpr std::array<const char*, vertex_kinds> vertex_names{"convex",   "concave",      "flat",  "saddle",
                                                             "boundary", "non-manifold", "unused"};

enum Mark : std::uint8_t { saddle = 1, irregular = 2, adjacent_gap = 4, gap = 8 };

std::uint8_t examine(FanSigns& signs) {
    std::uint8_t marks = saddle;
    if (!flipped_faces(signs).empty()) marks |= irregular;
    if (!failing_lines(signs).empty()) marks |= adjacent_gap;
    if (has_gap(signs)) marks |= gap;
    return marks;
}

double squared_length(const MeshSurface& surface, const Corner& edge) {
    const Triangle& triangle = surface.triangles()[edge.face];
    const Vector from = engine::to_vector(surface.position(triangle[edge.vertex]));
    return (engine::to_vector(surface.position(triangle[next_of_three(edge.vertex)])) - from).squaredNorm();
}

/// The change that mends a vertex.
struct Remedy {
    bool irregular = false;
    std::optional<Corner> edge;  ///< to cut: opposite to the vertex, the longest among its flipped faces
};

Remedy remedy_for(const MeshSurface& surface, std::size_t vertex, VertexFans& fans) {
    if (surface.kind(vertex, fans) != VertexKind::saddle) return {};
    const Fan fan = fan_at(surface, vertex, fans);
    FanSigns signs(fan);
    const std::vector<std::size_t> flipped = flipped_faces(signs);
    Remedy remedy{!flipped.empty(), std::nullopt};
    if (!remedy.irregular || !has_view(signs)) return remedy;
    for (const std::size_t i : flipped) {
        const Corner& corner = fans.faces()[i].corner;
        const Corner opposite{corner.face, next_of_three(corner.vertex)};
        if (!remedy.edge || squared_length(surface, opposite) > squared_length(surface, *remedy.edge))
            remedy.edge = opposite;
    }
    return remedy;
}

std::vector<Remedy> remedies(const MeshSurface& surface) {
    std::vector<Remedy> result(surface.mesh().vertices().size());
    tbb::enumerable_thread_specific<VertexFans> fans_of_thread;
    for_each_index(result.size(),
                   [&](std::size_t vertex) { result[vertex] = remedy_for(surface, vertex, fans_of_thread.local()); });
    return result;
}

/// Cuts every face at each of the edges in two; an edge of which some face is cut already has to wait.
Mesh cut(const MeshSurface& surface, const std::vector<Remedy>& remedies) {
    std::vector<Vec3> vertices = surface.mesh().vertices();
    std::vector<Triangle> triangles = surface.mesh().triangles();
    std::vector<bool> is_cut(surface.triangles().size(), false);
    for (const auto& [irregular, edge] : remedies) {
        if (!edge) continue;
        const std::vector<Corner> uses = surface.edges_at(*edge);
        bool waits = false;
        for (const Corner& use : uses) waits = waits || is_cut[use.face];
        if (waits) continue;

        const auto middle = static_cast<std::uint32_t>(vertices.size());
        const Triangle& cut_triangle = surface.triangles()[edge->face];
        const Vec3& from = surface.position(cut_triangle[edge->vertex]);
        const Vec3& to = surface.position(cut_triangle[next_of_three(edge->vertex)]);
        vertices.push_back({from[0] / 2 + to[0] / 2, from[1] / 2 + to[1] / 2, from[2] / 2 + to[2] / 2});
        for (const Corner& use : uses) {
            is_cut[use.face] = true;
            const std::uint32_t source = surface.sources()[use.face];
            const Triangle whole = triangles[source];
            triangles[source][next_of_three(use.vertex)] = middle;
            Triangle rest = whole;
            rest[use.vertex] = middle;
            triangles.push_back(rest);
        }
    }
    return {std::move(vertices), std::move(triangles), surface.mesh().name()};
}

}  // namespace

const char* name_of(EdgeKind kind) {
    return edge_names[static_cast<std::size_t>(kind)];
}

const char* name_of(VertexKind kind) {
    return vertex_names[static_cast<std::size_t>(kind)];
}

Classification classify_convexity(const Mesh& mesh) {
    using namespace engine;
    const MeshSurface surface(mesh);
    const std::vector<std::uint32_t>& representatives = surface.representatives();

    Classification result;
    result.vertices.assign(mesh.vertices().size(), VertexKind::unused);
    tbb::enumerable_thread_specific<VertexFans> fans_of_thread;
    for_each_index(mesh.vertices().size(),
                   [&](std::size_t vertex) { result.vertices[vertex] = surface.kind(vertex, fans_of_thread.local()); });
    for (std::size_t vertex = 0; vertex < result.vertices.size(); ++vertex) {
        VertexKind& kind = result.vertices[vertex];
        const bool counts = representatives[vertex] == vertex;
        if (!counts) kind = result.vertices[representatives[vertex]];
        result.vertex_counts[static_cast<std::size_t>(kind)] += counts;
    }
    std::vector<EdgeEntry> entries;
    for (std::uint32_t vertex = 0; vertex < result.vertices.size(); ++vertex) {
        edges_above(surface.triangles(), surface.rings(), vertex, entries);
        for_each_edge(entries, [&](std::span<const EdgeEntry> faces) {
            ++result.edge_counts[static_cast<std::size_t>(surface.kind(faces.front().edge()))];
        });
    }
    return result;
}

SaddleReport examine_saddles(const Mesh& mesh) {
    const MeshSurface surface(mesh);
    std::vector<std::uint8_t> marks(mesh.vertices().size());
    std::atomic<std::size_t> decisions = 0;
    std::atomic<std::size_t> exact_decisions = 0;
    tbb::enumerable_thread_specific<engine::VertexFans> fans_of_thread;
    for_each_index(marks.size(), [&](std::size_t vertex) {
        engine::VertexFans& fans = fans_of_thread.local();
        if (surface.kind(vertex, fans) != VertexKind::saddle) return;
        const Fan fan = fan_at(surface, vertex, fans);
        FanSigns signs(fan);
        marks[vertex] = examine(signs);
        decisions += signs.decisions();
        exact_decisions += signs.exact_decisions();
    });

    SaddleReport report;
    for (std::uint32_t vertex = 0; vertex < marks.size(); ++vertex) {
        if (marks[vertex] & saddle) ++report.saddles;
        if (marks[vertex] & irregular) report.irregular.push_back(vertex);
        if (marks[vertex] & adjacent_gap) report.adjacent_gaps.push_back(vertex);
        if (marks[vertex] & gap) report.gaps.push_back(vertex);
    }
    report.decisions = decisions;
    report.exact_decisions = exact_decisions;
    return report;
}

RegularMesh subdivide_irregular(const Mesh& mesh, std::size_t rounds) {
    RegularMesh result{mesh};
    for (std::size_t round = 0;; ++round) {
        const MeshSurface surface(result.mesh);
        const std::vector<Remedy> found = remedies(surface);
        const auto count = [&](const auto& property) {
            return static_cast<std::size_t>(std::count_if(found.begin(), found.end(), property));
        };
        result.irregular_vertices = count([](const Remedy& remedy) { return remedy.irregular; });
        result.added_vertices = result.mesh.vertices().size() - mesh.vertices().size();
        if (round == rounds || count([](const Remedy& remedy) { return remedy.edge.has_value(); }) == 0) return result;
        result.mesh = cut(surface, found);
    }
}

}  // namespace clsdf
