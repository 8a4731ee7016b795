#include <clsdf/error.hpp>
#include <clsdf/papers.hpp>

#include "core/parallel.hpp"
#include "frusta/frusta.hpp"
#include "frusta/gaps.hpp"
#include "frusta/slopes.hpp"
#include "mesh/box_index.hpp"
#include "papers/convex_polyhedron.hpp"
#include "papers/pieces.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

namespace clsdf {

namespace {

using namespace papers;
using namespace engine;

/// The surface of a polyhedron that is not empty, in triangles: `origin` + `unit` times its vertices.
Mesh solid_mesh(const ConvexPolyhedron& solid, const Vector& origin, double unit = 1) {
    std::vector<Vec3> vertices;
    for (const Vector& vertex : solid.vertices) {
        const Vector place = origin + unit * vertex;
        vertices.push_back({place.x(), place.y(), place.z()});
    }
    std::vector<Triangle> triangles;
    for (const ConvexPolyhedron::Face& face : solid.faces) {
        const std::span<const std::uint32_t> ring = solid.polygon(face);
        for (std::size_t i = 2; i < ring.size(); ++i) triangles.push_back({ring[0], ring[i - 1], ring[i]});
    }
    return {std::move(vertices), std::move(triangles), "polyhedron"};
}

/// Throws Error(invalid_argument) for a half width that is not positive and finite, or a triangle out of range.
void check_solids_asked_for(const Mesh& mesh, std::span<const std::uint32_t> triangles, double half_width) {
    if (!(half_width > 0) || !std::isfinite(half_width))
        throw Error(ErrorCode::invalid_argument,
                    fmt::format("polyhedra need a positive and finite half width, not {}", half_width));
    for (const std::uint32_t triangle : triangles)
        if (triangle >= mesh.triangles().size())
            throw Error(ErrorCode::invalid_argument, fmt::format("{} has no triangle {}: its triangles are 0 to {}",
                                                                 mesh.name(), triangle, mesh.triangles().size() - 1));
}

constexpr double half_width_in_units = 16;

/// One side of a leaned frustum, from the foot of the frame: |Z| up to the half width, and the outward distance from
/// every edge up to its slope times |Z| and up to the half width.
ConvexPolyhedron side_of(const TriangleFrame& frame, const FaceSlopes& slopes, bool is_front) {
    const double cap = half_width_in_units;
    const Vector along = to_vector(frame.face.along);
    const Vector up = is_front ? frame.normal : Vector(-frame.normal);
    std::vector<HalfSpace> half_spaces{
        {-up, 0}, {up, cap}, {along, frame.face.right + cap}, {-along, frame.face.left + cap}};
    for (std::uint32_t k = 0; k < 3; ++k) {
        const Vector outward = -frame.inwards[k];
        // The base lies at Y = 0, a slanted edge goes through an end of it.
        double offset = 0;
        if (frame.polyhedron_edge(k) == CLSDF_EDGE_RIGHT) offset = outward.dot(along) * frame.face.right;
        if (frame.polyhedron_edge(k) == CLSDF_EDGE_LEFT) offset = -outward.dot(along) * frame.face.left;
        const auto slope = static_cast<double>(is_front ? slopes.above[k] : slopes.below[k]);
        half_spaces.push_back({outward - slope * up, offset});
        half_spaces.push_back({outward, offset + cap});
    }
    const double reach = frame.base_length() + frame.face.altitude + 4 * cap;
    return clip({{-reach, -reach, -reach}, {reach, reach, reach}}, half_spaces);
}

/// From the triangle's first corner.
ConvexPolyhedron solid_of(const BisectorPolyhedron& polyhedron) {
    constexpr double reach = 8;
    std::vector<HalfSpace> half_spaces{{polyhedron.normal, polyhedron.half_width},
                                       {-polyhedron.normal, polyhedron.half_width}};
    Box box;
    for (std::size_t k = 0; k < 3; ++k) {
        const Vector corner = polyhedron.corners[k] - polyhedron.corners[0];
        half_spaces.push_back({polyhedron.bisector[k], polyhedron.bisector[k].dot(corner) + polyhedron.shift[k]});
        const Vec3 place{corner[0], corner[1], corner[2]};
        add(box, {place, place});
    }
    for (double& lower : box.lower) lower -= reach * polyhedron.half_width;
    for (double& upper : box.upper) upper += reach * polyhedron.half_width;
    return clip(box, half_spaces);
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
    const PairedEdges edges = pair_edges(triangles, rings);
    const FaceMeasures measures(faces, rings, edges);
    UninitializedVector<MeasuredFace> measured(triangles.size());
    for_each_index(measured.size(), [&](std::size_t face) {
        measured[face] = measures.measure(static_cast<std::uint32_t>(face));
        lean(measured[face].frame, measured[face].slopes);
    });

    std::vector<BoundingSolid> result;
    const auto add = [&](std::uint32_t triangle, SolidPart part, const TriangleFrame& frame, const FaceSlopes& planes) {
        const ConvexPolyhedron solid = side_of(frame, planes, part != SolidPart::back);
        if (solid.is_empty()) return;
        const Vector foot = to_vector(lattice.origin) + lattice.unit * to_vector(frame.face.foot);
        result.push_back({triangle, part, solid_mesh(solid, foot, lattice.unit)});
    };
    for (const std::uint32_t face : selected) {
        add(face, SolidPart::front, measured[face].frame, measured[face].slopes);
        add(face, SolidPart::back, measured[face].frame, measured[face].slopes);
    }

    std::vector<std::uint32_t> indices(rings.vertex_count());
    std::iota(indices.begin(), indices.end(), 0U);
    std::vector<std::uint32_t> used;
    for (const std::uint32_t vertex : indices)
        if (rings.size(vertex) > 0) used.push_back(vertex);
    const std::vector<std::uint8_t> marks = find_gaps(faces, edges.faces, rings, MeasuredFaces(measured), used);
    for (std::size_t n = 0; n < used.size(); ++n) {
        if (!(marks[n] & vertex_gap)) continue;
        const std::uint32_t vertex = used[n];
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

std::vector<BoundingSolid> peikert_sigg_solids(const Mesh& mesh, std::span<const std::uint32_t> selected,
                                               double half_width, bool close_gaps) {
    check_solids_asked_for(mesh, selected, half_width);
    const BisectorPolyhedra all = peikert_sigg_polyhedra(mesh, half_width, close_gaps);
    std::vector<BoundingSolid> result;
    for (const std::uint32_t triangle : selected) {
        const auto found = std::lower_bound(
            all.polyhedra.begin(), all.polyhedra.end(), triangle,
            [](const BisectorPolyhedron& polyhedron, std::uint32_t index) { return polyhedron.triangle < index; });
        if (found == all.polyhedra.end() || found->triangle != triangle) continue;  // with repeated vertices
        const ConvexPolyhedron solid = solid_of(*found);
        if (!solid.is_empty())
            result.push_back({triangle, SolidPart::both_sides, solid_mesh(solid, found->corners[0])});
    }
    return result;
}

}  // namespace clsdf
