#include <clsdf/bounding_solids.hpp>
#include <clsdf/error.hpp>

#include "polyhedra/edge_slopes.hpp"
#include "polyhedra/frame_planes.hpp"
#include "polyhedra/gaps.hpp"
#include "polyhedra/non_manifold_edges.hpp"
#include "polyhedra/point_site.hpp"
#include "polyhedra/solid_mesh.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <numeric>

namespace clsdf {

namespace {

using namespace polyhedra;

constexpr double half_width_in_units = 16;

/// One side of a leaned frustum, from the foot of the frame: |Z| up to the half width, and the outward distance from
/// every edge up to its slope times |Z| and up to the half width.
ConvexPolyhedron side_of(const TriangleFrame& frame, const FaceSlopes& slopes, bool is_front) {
    const double cap = half_width_in_units;
    const Vector up = is_front ? frame.normal : Vector(-frame.normal);
    std::vector<HalfSpace> half_spaces{{-up, 0},
                                       {up, cap},
                                       {frame.along, frame.base[CLSDF_HALF_RIGHT] + cap},
                                       {-frame.along, frame.base[CLSDF_HALF_LEFT] + cap}};
    for (std::uint32_t k = 0; k < 3; ++k) {
        const Vector outward = -frame.inwards[k];
        // The base lies at Y = 0, a slanted edge goes through an end of it.
        double offset = 0;
        if (frame.polyhedron_edge(k) == CLSDF_EDGE_RIGHT)
            offset = outward.dot(frame.along) * frame.base[CLSDF_HALF_RIGHT];
        if (frame.polyhedron_edge(k) == CLSDF_EDGE_LEFT)
            offset = -outward.dot(frame.along) * frame.base[CLSDF_HALF_LEFT];
        const double slope = is_front ? slopes.above[k] : slopes.below[k];
        half_spaces.push_back({outward - slope * up, offset});
        half_spaces.push_back({outward, offset + cap});
    }
    const double reach = frame.base_length() + frame.altitude + 4 * cap;
    return clip({{-reach, -reach, -reach}, {reach, reach, reach}}, half_spaces);
}

}  // namespace

std::vector<std::uint32_t> triangles_at(const Mesh& mesh, std::uint32_t vertex) {
    const std::size_t count = mesh.vertices().size();
    if (vertex >= count)
        throw Error(ErrorCode::invalid_argument,
                    fmt::format("{} has no vertex {}: its vertices are 0 to {}", mesh.name(), vertex, count - 1));
    const Vec3& position = mesh.vertices()[vertex];
    std::vector<std::uint32_t> result;
    for (std::uint32_t face = 0; face < mesh.triangles().size(); ++face) {
        const Triangle& triangle = mesh.triangles()[face];
        if (std::any_of(triangle.begin(), triangle.end(),
                        [&](std::uint32_t corner) { return mesh.vertices()[corner] == position; }))
            result.push_back(face);
    }
    if (result.empty())
        throw Error(ErrorCode::invalid_argument,
                    fmt::format("vertex {} of {} belongs to no triangle; choose another", vertex, mesh.name()));
    return result;
}

std::vector<BoundingSolid> leaned_solids(const Mesh& mesh, std::span<const std::uint32_t> selected, double half_width) {
    check_solids_asked_for(mesh, selected, half_width);
    const Mesh welded = weld(mesh);
    const std::vector<Triangle>& triangles = welded.triangles();
    const LatticeView lattice{welded.box().lower, half_width / half_width_in_units};

    std::vector<std::uint32_t> order(triangles.size());
    std::iota(order.begin(), order.end(), 0U);
    const MeshFaces faces{welded.vertices(), triangles, lattice};
    const OneRings rings(triangles, welded.vertices().size());
    PairedEdges edges = pair_edges(triangles, rings);
    const std::vector<EdgeSlope> of_non_manifold = non_manifold_slopes(faces, rings, edges, CLSDF_OPEN_SLOPE);
    UninitializedVector<TriangleFrame> frames(triangles.size());
    std::vector<FaceSlopes> slopes(triangles.size());
    std::vector<FramePlanes::Directions> directions(triangles.size());
    measure_edges(faces, edges.faces, of_non_manifold, CLSDF_OPEN_SLOPE, [&](EdgeSlopes& stretch) {
        for (std::size_t face = stretch.begin(); face < stretch.end(); ++face) {
            frames[face] = stretch.frame(face);
            lean(frames[face], stretch.slopes(face));
            slopes[face] = stretch.slopes(face);
            directions[face] = {frames[face].normal, frames[face].inwards};
        }
    });

    std::vector<BoundingSolid> result;
    const auto add = [&](std::uint32_t triangle, SolidPart part, const TriangleFrame& frame, const FaceSlopes& planes) {
        const ConvexPolyhedron solid = side_of(frame, planes, part != SolidPart::back);
        if (solid.is_empty()) return;
        const Vector foot = to_vector(lattice.origin) + lattice.unit * frame.foot;
        result.push_back({triangle, part, solid_mesh(solid, foot, lattice.unit)});
    };
    for (const std::uint32_t face : selected) {
        add(face, SolidPart::front, frames[face], slopes[face]);
        add(face, SolidPart::back, frames[face], slopes[face]);
    }

    std::vector<std::uint8_t> marks(rings.vertex_count());
    std::vector<std::uint32_t> indices(rings.vertex_count());
    std::iota(indices.begin(), indices.end(), 0U);
    std::vector<std::uint32_t> used;
    for (std::uint32_t vertex = 0; vertex < marks.size(); ++vertex)
        if (rings.size(vertex) > 0) used.push_back(vertex);
    find_gaps(faces, edges.faces, rings, FramePlanes(directions, slopes), rejection_margin, used, marks);
    for (std::uint32_t vertex = 0; vertex < marks.size(); ++vertex) {
        if (!(marks[vertex] & vertex_gap)) continue;
        bool all = true;
        for (std::size_t i = 0; i < rings.size(vertex) && all; ++i)
            all = std::find(selected.begin(), selected.end(), rings.corner(vertex, i).face) != selected.end();
        if (!all) continue;
        const SiteFrustum site = point_site(faces, order, indices, rings, vertex);
        const Vector position = (to_vector(faces.position(vertex)) - to_vector(lattice.origin)) / lattice.unit;
        add(site.face, SolidPart::point_site, point_frame(position, site.normal), site.slopes);
    }
    return result;
}

}  // namespace clsdf
