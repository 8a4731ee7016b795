#include "frusta/mesh_part.hpp"

#include "core/parallel.hpp"
#include "mesh/moved_mesh.hpp"

#include <algorithm>
#include <numeric>
#include <utility>

namespace clsdf::engine {

namespace {

constexpr std::uint32_t absent = 0xFFFFFFFFU;

/// The faces of clusters that are wanted, ascending.
std::vector<std::uint32_t> faces_of(const Frusta& frusta, const NearRecords& near, std::size_t face_count) {
    std::vector<bool> is_wanted(chunk_count(face_count, ClusterIndex::cluster));
    for (const RecordRange& range : near.faces)
        for (std::size_t face = range.begin; face < range.end; face += ClusterIndex::cluster)
            is_wanted[face / ClusterIndex::cluster] = true;
    for (const RecordRange& range : near.sites)
        for (std::size_t site = range.begin; site < range.end; ++site)
            is_wanted[frusta.sites[site].face / ClusterIndex::cluster] = true;
    const auto clusters = static_cast<std::size_t>(std::count(is_wanted.begin(), is_wanted.end(), true));
    std::vector<std::uint32_t> faces;
    faces.reserve(clusters * ClusterIndex::cluster);
    for (std::size_t face = 0; face < face_count; ++face)
        if (is_wanted[face / ClusterIndex::cluster]) faces.push_back(static_cast<std::uint32_t>(face));
    return faces;
}

/// For each of `count` numbers its place in an ascending list, or `absent`.
UninitializedVector<std::uint32_t> places_in(const std::vector<std::uint32_t>& list, std::size_t count) {
    UninitializedVector<std::uint32_t> places(count);
    for_each_index(count, [&](std::size_t i) { places[i] = absent; });
    for_each_index(list.size(), [&](std::size_t i) { places[list[i]] = static_cast<std::uint32_t>(i); });
    return places;
}

/// The part may lack faces of an edge. The edge stays non-manifold: records need the mark.
void keep_non_manifold(std::span<const std::uint32_t> edges, MeshTopology& part) {
    if (edges.empty()) return;
    std::vector<std::uint32_t>& ends = part.edges.non_manifold_ends;
    for (const std::uint32_t edge : edges) {
        const std::uint32_t face = edge / 3, k = edge % 3;
        part.edges.faces[face].marks[k] |= edge_non_manifold;
        const Triangle& triangle = part.faces.triangles[face];
        ends.push_back(std::min(triangle[k], triangle[next_of_three(k)]));
    }
    std::sort(ends.begin(), ends.end());
    ends.erase(std::unique(ends.begin(), ends.end()), ends.end());
}

/// The non-manifold edges of these faces of a mesh, which are numbered by their places in the list.
std::vector<std::uint32_t> non_manifold_edges(const PairedEdges& edges, std::span<const std::uint32_t> faces) {
    std::vector<std::uint32_t> found;
    if (edges.non_manifold_ends.empty()) return found;
    for (std::size_t i = 0; i < faces.size(); ++i)
        for (std::uint32_t k = 0; k < 3; ++k)
            if (has_mark(edges.faces, {faces[i], k}, edge_non_manifold))
                found.push_back(static_cast<std::uint32_t>(3 * i) + k);
    return found;
}

}  // namespace

std::vector<std::uint32_t> non_manifold_edges(const MeshTopology& topology) {
    std::vector<std::uint32_t> all(topology.order.size());
    std::iota(all.begin(), all.end(), 0U);
    return non_manifold_edges(topology.edges, all);
}

MeshPart make_part(Mesh mesh, const Box& box, SignSurface surface, std::vector<std::uint32_t> triangles,
                   UninitializedVector<std::uint32_t> order, std::span<const std::uint32_t> non_manifold) {
    MeshPart part{with_box(std::move(mesh), box), std::move(surface), std::move(triangles), nullptr, {}, {}};
    auto made = std::make_shared<MeshTopology>(part.mesh, std::move(order));
    keep_non_manifold(non_manifold, *made);
    part.topology = std::move(made);
    part.frusta.positions = ordered_positions(*part.topology, part.mesh.vertices());
    return part;
}

MeshPart part_of(const Mesh& mesh, const SignSurface& surface, const MeshTopology& topology, const Frusta& frusta,
                 const NearRecords& near) {
    const std::vector<std::uint32_t> faces = faces_of(frusta, near, topology.order.size());
    // The lists are kept: their memory has just their size.
    std::vector<std::uint32_t> triangles(faces.size()), vertices;
    for_each_index(faces.size(), [&](std::size_t i) { triangles[i] = topology.order[faces[i]]; });
    std::sort(triangles.begin(), triangles.end());
    std::vector<bool> is_used(mesh.vertices().size());
    for (const std::uint32_t triangle : triangles)
        for (const std::uint32_t vertex : mesh.triangles()[triangle])
            is_used[vertex] = is_used[surface.vertex(vertex)] = true;
    vertices.reserve(static_cast<std::size_t>(std::count(is_used.begin(), is_used.end(), true)));
    for (std::size_t vertex = 0; vertex < is_used.size(); ++vertex)
        if (is_used[vertex]) vertices.push_back(static_cast<std::uint32_t>(vertex));
    std::vector<Vec3> positions(vertices.size());
    for_each_index(vertices.size(), [&](std::size_t i) { positions[i] = mesh.vertices()[vertices[i]]; });
    const auto vertex_places = places_in(vertices, mesh.vertices().size());
    const auto triangle_places = places_in(triangles, mesh.triangles().size());
    std::vector<Triangle> of_part(triangles.size());
    for_each_index(triangles.size(), [&](std::size_t i) {
        for (std::size_t k = 0; k < 3; ++k) of_part[i][k] = vertex_places[mesh.triangles()[triangles[i]][k]];
    });
    UninitializedVector<std::uint32_t> order(faces.size());
    for_each_index(faces.size(), [&](std::size_t i) { order[i] = triangle_places[topology.order[faces[i]]]; });

    SignSurface of_surface;
    if (!surface.vertices.empty())
        for (const std::uint32_t vertex : vertices)
            of_surface.vertices.push_back(vertex_places[surface.vertex(vertex)]);
    if (!surface.faces.empty())
        for (const std::uint32_t triangle : triangles) of_surface.faces.push_back(surface.faces[triangle]);

    MeshPart part =
        make_part(Mesh(std::move(positions), std::move(of_part), mesh.name()), mesh.box(), std::move(of_surface),
                  std::move(triangles), std::move(order), non_manifold_edges(topology.edges, faces));
    const OrderedFaces& ordered = part.topology->faces;
    UninitializedVector<std::uint32_t> numbers(part.mesh.vertices().size());  // of the part's vertices, in its topology
    for_each_index(ordered.vertices.size(),
                   [&](std::size_t i) { numbers[ordered.vertices[i]] = static_cast<std::uint32_t>(i); });

    Frusta& result = part.frusta;
    result.slopes.resize(faces.size());
    for_each_index(faces.size(), [&](std::size_t i) { result.slopes[i] = frusta.slopes[faces[i]]; });
    const auto face_place = [&](std::uint32_t face) { return std::lower_bound(faces.begin(), faces.end(), face); };
    for (const RecordRange& range : near.sites)
        for (std::size_t i = range.begin; i < range.end; ++i) {
            SiteFrustum site = frusta.sites[i];
            site.vertex = numbers[vertex_places[topology.faces.vertices[site.vertex]]];
            site.face = static_cast<std::uint32_t>(face_place(site.face) - faces.begin());
            result.sites.push_back(site);
        }
    for (const std::uint32_t sliver : frusta.slivers)
        if (const auto place = face_place(sliver); place != faces.end() && *place == sliver)
            result.slivers.push_back(static_cast<std::uint32_t>(place - faces.begin()));
    result.saddle_vertices = frusta.saddle_vertices;
    result.boxes = frusta.boxes;
    part.vertices = std::move(vertices);
    return part;
}

}  // namespace clsdf::engine
