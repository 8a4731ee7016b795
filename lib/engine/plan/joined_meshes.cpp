#include "plan/joined_meshes.hpp"

#include "core/parallel.hpp"
#include "frusta/device_faces.hpp"
#include "frusta/prepared_mesh.hpp"
#include "lattice/layout_of.hpp"
#include "lists/coarse_lists.hpp"

#include <algorithm>
#include <utility>

namespace clsdf::engine {

namespace {

/// Where the items of a mesh begin among those of all.
struct Begins {
    std::uint32_t face = 0;            // also of its triangles
    std::uint32_t corner = 0;          // in the one-rings
    std::uint32_t vertex = 0;          // in the topology
    std::uint32_t vertex_of_mesh = 0;  // in the mesh
};

std::vector<Begins> begins_of(std::span<const MeshToJoin> meshes) {
    std::vector<Begins> begins(meshes.size() + 1);
    std::size_t faces = 0;
    for (std::size_t i = 0; i < meshes.size(); ++i) {
        const MeshTopology& topology = *meshes[i].topology;
        const Begins& own = begins[i];
        faces += in_record_groups(topology.order.size());
        checked_face_count(faces);
        begins[i + 1] = {static_cast<std::uint32_t>(faces),
                         own.corner + static_cast<std::uint32_t>(topology.rings.corners().size()),
                         own.vertex + static_cast<std::uint32_t>(topology.faces.vertices.size()),
                         own.vertex_of_mesh + static_cast<std::uint32_t>(meshes[i].mesh->vertices().size())};
    }
    return begins;
}

Triangle moved(const Triangle& triangle, std::uint32_t by) {
    return {triangle[0] + by, triangle[1] + by, triangle[2] + by};
}

/// The arrays in the making.
struct Arrays {
    explicit Arrays(const Begins& ends)
        : triangles(ends.face),
          numbers(ends.face),
          order(ends.face),
          faces{UninitializedVector<Triangle>(ends.face), UninitializedVector<std::uint32_t>(ends.vertex)},
          starts(ends.vertex + 1),
          corners(ends.corner) {
        edges.faces = UninitializedVector<FaceEdges>(ends.face);
        starts.back() = ends.corner;
    }

    /// The faces of a mesh, and its last one again up to the next mesh.
    void set_faces(const MeshToJoin& from, const Begins& begin, std::uint32_t end) {
        const MeshTopology& topology = *from.topology;
        const std::size_t last = topology.order.size() - 1;
        for (std::size_t i = 0; begin.face + i < end; ++i) {
            const std::size_t own = std::min(i, last), face = begin.face + i;
            triangles[face] = moved(from.mesh->triangles()[own], begin.vertex_of_mesh);
            numbers[face] = static_cast<std::uint32_t>(own);
            order[face] = topology.order[own] + begin.face;
            faces.triangles[face] = moved(topology.faces.triangles[own], begin.vertex);
            FaceEdges& edge = edges.faces[face] = topology.edges.faces[own];
            // Of an edge without one other face, the number has no meaning.
            for (std::uint32_t& across : edge.across) across += Corner{begin.face, 0}.packed();
        }
    }

    void set_vertices(const MeshToJoin& from, const Begins& begin) {
        const MeshTopology& topology = *from.topology;
        for (std::size_t i = 0; i < topology.faces.vertices.size(); ++i) {
            faces.vertices[begin.vertex + i] = topology.faces.vertices[i] + begin.vertex_of_mesh;
            starts[begin.vertex + i] = topology.rings.starts()[i] + begin.corner;
        }
        for (std::size_t i = 0; i < topology.rings.corners().size(); ++i)
            corners[begin.corner + i] = topology.rings.corners()[i] + Corner{begin.face, 0}.packed();
    }

    std::vector<Triangle> triangles;
    std::vector<std::uint32_t> numbers;
    UninitializedVector<std::uint32_t> order;
    OrderedFaces faces;
    UninitializedVector<std::uint32_t> starts;
    UninitializedVector<std::uint32_t> corners;
    PairedEdges edges;
};

}  // namespace

JoinedMeshes join_meshes(std::span<const MeshToJoin> meshes, std::vector<Vec3> positions) {
    const std::vector<Begins> begins = begins_of(meshes);
    Arrays arrays(begins.back());
    constexpr std::size_t grain = 4;
    for_each_index(
        meshes.size(),
        [&](std::size_t i) {
            arrays.set_faces(meshes[i], begins[i], begins[i + 1].face);
            arrays.set_vertices(meshes[i], begins[i]);
        },
        grain);
    arrays.edges.are_paired = true;
    std::vector<JoinedPart> parts;
    for (std::size_t i = 0; i < meshes.size(); ++i) {
        const MeshTopology& topology = *meshes[i].topology;
        arrays.edges.are_paired = arrays.edges.are_paired && topology.edges.are_paired;
        for (const std::uint32_t end : topology.edges.non_manifold_ends)
            arrays.edges.non_manifold_ends.push_back(end + begins[i].vertex);
        parts.push_back(
            {begins[i].face, begins[i].face + static_cast<std::uint32_t>(topology.order.size()), begins[i + 1].vertex});
    }
    auto topology = std::make_shared<MeshTopology>(std::move(arrays.order), std::move(arrays.faces),
                                                   OneRings(std::move(arrays.starts), std::move(arrays.corners)),
                                                   std::move(arrays.edges));
    topology->joined = std::move(parts);
    return {Mesh(std::move(positions), std::move(arrays.triangles), "bodies"), std::move(topology),
            std::move(arrays.numbers)};
}

bool can_be_joined(const Box& box, const Grid& grid, const Band& band, SignRule sign) {
    return has_uniform_bounds(layout_of(grid, band, sign)) && is_plain(box, lattice_of(grid));
}

NearRecords records_of_meshes(const MeshTopology& joined, const FoundFrusta& frusta,
                              std::span<const std::uint32_t> meshes) {
    NearRecords found;
    auto site = frusta.sites.begin();
    const auto number = [&](auto place) { return static_cast<std::size_t>(place - frusta.sites.begin()); };
    for (const std::uint32_t mesh : meshes) {
        const JoinedPart& part = joined.joined[mesh];
        const std::uint32_t first_vertex = mesh > 0 ? joined.joined[mesh - 1].vertex_end : 0;
        found.faces.push_back({part.face_begin, part.face_end});
        found.face_count += part.face_end - part.face_begin;
        const auto begin = std::ranges::lower_bound(site, frusta.sites.end(), first_vertex, {}, &SiteFrustum::vertex);
        site = std::ranges::lower_bound(begin, frusta.sites.end(), part.vertex_end, {}, &SiteFrustum::vertex);
        if (begin == site) continue;
        found.sites.push_back({number(begin), number(site)});
        found.site_count += found.sites.back().end - found.sites.back().begin;
    }
    return found;
}

}  // namespace clsdf::engine
