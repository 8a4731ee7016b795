#include "tree/point_mesh.hpp"

#include "core/parallel.hpp"
#include "core/refuse.hpp"
#include "device/buffer_pool.hpp"
#include "frusta/records.hpp"
#include "launch/commands.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <limits>
#include <span>
#include <utility>
#include <vector>

namespace clsdf::engine {

namespace {

/// Without the lowest face.
PointFace face_of(const Polyhedron& record) {
    PointFace result{};
    for (std::size_t column = 0; column < 3; ++column)
        result.offset[column] = record.exact_constant_at_origin[column] -
                                record.exact_gradient_x[column] * static_cast<double>(record.origin_x) -
                                record.exact_gradient_y[column] * static_cast<double>(record.origin_y) -
                                record.exact_gradient_z[column] * static_cast<double>(record.origin_z);
    result.triangle = record.triangle;
    return result;
}

/// The lower, in the caller's order, of a face and of the one across its first edge if they have the same three
/// vertices.
std::uint32_t lower_of_two(const MeshTopology& topology, std::uint32_t face) {
    const std::span<const Triangle> triangles(topology.faces.triangles);
    const FaceEdges& edges = topology.edges.faces[face];
    constexpr unsigned without_face = edge_open | edge_at_box | edge_non_manifold;
    if ((edges.marks[0] & without_face) != 0) return face;
    const Corner across = Corner::unpack(edges.across[0]);
    const bool is_equal = triangles[across.face][previous_of_three(across.vertex)] == triangles[face][2];
    return is_equal && topology.order[across.face] < topology.order[face] ? across.face : face;
}

/// Sets the lowest face with the same three vertices, in the caller's order, of each face. Faces at edges of more than
/// two are sorted by their vertices: any number of them may be equal.
void set_lowest_equal(const MeshTopology& topology, std::span<PointFace> faces) {
    for_each_index(faces.size(), [&](std::size_t face) {
        faces[face].lowest = lower_of_two(topology, static_cast<std::uint32_t>(face));
    });
    std::vector<std::pair<Triangle, std::uint32_t>> sorted;  // vertices ascending, face
    for (std::uint32_t face = 0; face < faces.size(); ++face)
        if (topology.edges.is_non_manifold(face)) {
            sorted.emplace_back(topology.faces.triangles[face], face);
            std::ranges::sort(sorted.back().first);
        }
    std::ranges::sort(sorted, {},
                      [&](const auto& entry) { return std::pair(entry.first, topology.order[entry.second]); });
    for (std::size_t i = 0; i < sorted.size(); ++i) {
        const bool is_first = i == 0 || sorted[i].first != sorted[i - 1].first;
        faces[sorted[i].second].lowest = is_first ? sorted[i].second : faces[sorted[i - 1].second].lowest;
    }
}

void set_sign_surface(PointMesh& result, const Mesh& mesh, const SignSurface& surface) {
    const MeshTopology& topology = *result.topology;
    if (!surface.vertices.empty()) {
        const KeptArray<std::uint32_t>& vertices = topology.faces.vertices;
        std::vector<bool> is_joined(mesh.vertices().size());
        for (std::uint32_t vertex = 0; vertex < is_joined.size(); ++vertex)
            if (const std::uint32_t other = surface.vertex(vertex); other != vertex)
                is_joined[vertex] = is_joined[other] = true;
        result.sign_positions.resize(vertices.size());
        result.is_joined.resize(vertices.size());
        for (std::size_t i = 0; i < vertices.size(); ++i) {
            result.sign_positions[i] = mesh.vertices()[surface.vertex(vertices[i])];
            result.is_joined[i] = is_joined[vertices[i]];
        }
    }
    if (surface.faces.empty()) return;
    result.sign_counts.resize(result.face_count());
    for_each_index(result.face_count(), [&](std::size_t face) {
        result.sign_counts[face] = static_cast<std::int8_t>(surface.count(topology.order[face]));
    });
}

}  // namespace

LatticeView lattice_for_points(const Box& box, const std::string& name) {
    const double longest = box.longest_side();
    LatticeView lattice;
    lattice.origin = box.lower;
    if (longest > 0) lattice.unit = std::ldexp(1.0, std::max(std::ilogb(longest) - 8, -1000));
    constexpr auto smallest = static_cast<double>(std::numeric_limits<float>::min()),
                   largest = static_cast<double>(std::numeric_limits<float>::max());
    if (!(lattice.unit >= smallest && lattice.unit <= largest / 512))
        refuse(
            "the longest side of {}, {}, is beyond the floats that distances are given in; scale "
            "the mesh",
            name, longest);
    return lattice;
}

PointMesh make_host_point_mesh(const Mesh& mesh, const SignSurface& surface,
                               std::shared_ptr<const MeshTopology> topology) {
    PointMesh result;
    result.lattice = lattice_for_points(mesh.box(), mesh.name());
    result.box = mesh.box();
    result.count = topology->order.size();
    result.topology = std::move(topology);
    const KeptArray<std::uint32_t>& vertices = result.topology->faces.vertices;
    result.positions.resize(vertices.size());
    for_each_index(vertices.size(), [&](std::size_t i) { result.positions[i] = mesh.vertices()[vertices[i]]; });

    set_sign_surface(result, mesh, surface);
    return result;
}

PointMesh make_point_mesh(const DeviceTools& tools, const Mesh& mesh, const SignSurface& surface,
                          std::shared_ptr<const MeshTopology> topology, const PointFaces* made) {
    PointMesh result = make_host_point_mesh(mesh, surface, std::move(topology));
    if (made != nullptr) {
        static_cast<PointFaces&>(result) = *made;
        return result;
    }
    device::HostFilling records(tools.context, tools.pool, result.face_count() * sizeof(Polyhedron), "polyhedra");
    device::HostFilling faces(tools.context, tools.pool, result.face_count() * sizeof(PointFace),
                              "faces of the points' tree");
    auto* const polyhedra = static_cast<Polyhedron*>(records.memory());
    const std::span<PointFace> point_faces(static_cast<PointFace*>(faces.memory()), result.face_count());
    const MeshTopology& numbers = *result.topology;
    const std::span<const Triangle> triangles(numbers.faces.triangles);
    const MeshFaces of_mesh{result.positions, triangles, result.lattice};
    for_each_index(result.face_count(), [&](std::size_t face) {
        polyhedra[face] =
            pack(of_mesh.frame(face), {}, numbers.order[face], result.positions, triangles[face], result.lattice);
        point_faces[face] = face_of(polyhedra[face]);
    });
    set_lowest_equal(numbers, point_faces);
    result.polyhedra = std::make_shared<const device::BufferPool::Lease>(records.finish());
    result.faces = std::make_shared<const device::BufferPool::Lease>(faces.finish());
    return result;
}

PointFaces make_point_faces(const DeviceTools& tools, const Box& box, const std::string& name,
                            GeometryOnDevice geometry, const cl::Buffer& found) {
    const DeviceTopology& topology = *geometry.topology;
    const std::size_t count = topology.face_count(), vertices = topology.vertex_count();
    PointFaces result;
    result.lattice = lattice_for_points(box, name);
    result.box = box;
    result.count = count;
    const auto lease = [&](std::size_t bytes, const char* purpose) {
        return std::make_shared<const device::BufferPool::Lease>(tools.pool->lease(bytes, purpose));
    };
    result.polyhedra = lease(count * sizeof(Polyhedron), "polyhedra");
    result.faces = lease(count * sizeof(PointFace), "faces of the points' tree");
    device::guarded([&] {
        device::LentKernel kernel = tools.kernel(tools.programs.point_faces, "make_point_faces");
        launch(tools.queue(), kernel, {std::max(count, vertices)}, static_cast<cl_uint>(count),
               static_cast<cl_uint>(vertices), face_lattice(result.lattice), cl_double{result.lattice.unit},
               **geometry.positions, *topology.names->triangles, *topology.order, *topology.edges, **result.polyhedra,
               **result.faces, found);
    });
    result.geometry = std::move(geometry);
    return result;
}

}  // namespace clsdf::engine
