#include "tree/closed_down.hpp"

#include <clsdf/outputs.hpp>

#include <algorithm>
#include <memory>
#include <utility>
#include <vector>

namespace clsdf::engine {

namespace {

Vec3 lowered(const Vec3& p, double floor) {
    return {p[0], p[1], floor};
}

/// The positions, those of the rim, those of the rim on the floor, and the positions on the floor.
template <typename Positions>
Positions with_walls_and_floor(const Positions& positions, const OpenBoundary& boundary) {
    Positions all(2 * (positions.size() + boundary.corners.size()));
    const double floor = *boundary.floor;
    auto to = std::ranges::copy(positions, all.begin()).out;
    to = std::ranges::copy(boundary.corners, to).out;
    to = std::ranges::transform(boundary.corners, to, [floor](const Vec3& p) { return lowered(p, floor); }).out;
    std::ranges::transform(positions, to, [floor](const Vec3& p) { return lowered(p, floor); });
    return all;
}

/// Two for each edge of the rim: the mesh's faces lie left of it. first: the number of its first vertex.
std::vector<Triangle> triangles_of_walls(const OpenBoundary& boundary, std::uint32_t first) {
    std::vector<Triangle> triangles;
    triangles.reserve(2 * boundary.corners.size());
    const auto count = static_cast<std::uint32_t>(boundary.corners.size());
    for (std::size_t loop = 0; loop + 1 < boundary.begins.size(); ++loop) {
        const auto begin = static_cast<std::uint32_t>(boundary.begins[loop]),
                   end = static_cast<std::uint32_t>(boundary.begins[loop + 1]);
        for (std::uint32_t i = begin; i < end; ++i) {
            const std::uint32_t a = first + i, b = first + (i + 1 < end ? i + 1 : begin);
            triangles.push_back({b, a, a + count});
            triangles.push_back({b, a + count, b + count});
        }
    }
    return triangles;
}

}  // namespace

ClosedMesh closed_down(const PointMesh& mesh, const OpenBoundary& boundary) {
    ClosedMesh result;
    PointMesh& closed = result.mesh;
    closed.lattice = mesh.lattice;
    closed.box = mesh.sign_box();
    closed.lattice.origin = closed.box.lower;
    closed.count = 2 * mesh.count + 2 * boundary.corners.size();
    closed.is_part = mesh.is_part;
    closed.has_several_regions = mesh.has_several_regions;
    closed.positions = with_walls_and_floor(mesh.positions, boundary);
    if (!mesh.sign_positions.empty()) closed.sign_positions = with_walls_and_floor(mesh.sign_positions, boundary);

    const auto rim = static_cast<std::uint32_t>(mesh.positions.size()),
               floor = rim + static_cast<std::uint32_t>(2 * boundary.corners.size());
    const std::vector<Triangle> walls = triangles_of_walls(boundary, rim);
    OrderedFaces faces;
    faces.triangles.resize(closed.count);
    auto to = std::ranges::copy(mesh.topology->faces.triangles, faces.triangles.begin()).out;
    to = std::ranges::copy(walls, to).out;
    std::ranges::transform(mesh.topology->faces.triangles, to, [floor](const Triangle& face) {
        return Triangle{face[0] + floor, face[2] + floor, face[1] + floor};
    });
    UninitializedVector<std::uint32_t> order(faces.triangles.size(), no_triangle);
    std::ranges::copy(mesh.topology->order, order.begin());
    if (!mesh.sign_counts.empty()) {
        closed.sign_counts = UninitializedVector<std::int8_t>(faces.triangles.size(), 1);
        std::ranges::copy(mesh.sign_counts, closed.sign_counts.begin());
        std::ranges::copy(mesh.sign_counts, closed.sign_counts.begin() + mesh.count + walls.size());
    }
    closed.topology = std::make_shared<const MeshTopology>(
        std::move(order), std::move(faces), OneRings(UninitializedVector<std::uint32_t>{0}, {}), PairedEdges{});
    return result;
}

}  // namespace clsdf::engine
