#include "frusta/records.hpp"

#include "frusta/one_lane.hpp"
#include "topology/topology.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <new>

namespace clsdf::engine {

namespace {

/// The foot of the altitude from a sample, in units. foot: the same, too coarse along an axis on which it is far.
Vector foot_from(const Vector& sample, Vector foot, const TriangleFrame& frame, std::span<const Vec3> positions,
                 const Triangle& corners, const LatticeView& lattice) {
    // From the end of the base that is nearer; the base runs from its left end to its right one, the next corner.
    const bool is_right = frame.face.right <= frame.face.left;
    const double to_foot = is_right ? -frame.face.right : frame.face.left;
    const Vec3& end = positions[corners[is_right ? next_of_three(frame.base_edge) : frame.base_edge]];
    const Vector along = to_vector(frame.face.along), from_lattice = to_vector(frame.face.foot);
    for (int axis = 0; axis < 3; ++axis) {
        if (!(std::abs(from_lattice[axis]) > LatticeView::far)) continue;
        const auto a = static_cast<std::size_t>(axis);
        foot[axis] = lattice.from_sample(a, end[a], sample[axis]) + to_foot * along[axis];
    }
    return foot;
}

}  // namespace

Polyhedron pack(const TriangleFrame& frame, const FaceSlopes& slopes, std::uint32_t triangle,
                std::span<const Vec3> positions, const Triangle& corners, const LatticeView& lattice) {
    const FaceLattice view = face_lattice(lattice);
    one_lane::LaneSlopes by_edge;
    for (std::uint32_t k = 0; k < 3; ++k) {
        by_edge.above[frame.polyhedron_edge(k)] = static_cast<double>(slopes.above[k]);
        by_edge.below[frame.polyhedron_edge(k)] = static_cast<double>(slopes.below[k]);
    }
    const one_lane::Vectors origin = origins_of(view, frame.face.foot);
    const Vector foot = foot_from(to_vector(origin), to_vector(feet_from_origins(view, frame.face.foot, origin)), frame,
                                  positions, corners, lattice);
    return std::bit_cast<Polyhedron>(records_of(view, &frame.face, &by_edge, triangle, origin, vectors_of(foot)));
}

void write_face_record(const MeshTopology& topology, const Frusta& frusta, const LatticeView& lattice, std::size_t face,
                       Polyhedron& record) {
    const Triangle& corners = topology.faces.triangles[face];
    const MeshFaces faces{frusta.positions, topology.faces.triangles, lattice};
    // Constructed in its place rather than copied there.
    new (&record) Polyhedron(
        pack(faces.frame(face), frusta.slopes[face], topology.order[face], frusta.positions, corners, lattice));
    if (topology.edges.is_non_manifold(face)) record.flags |= CLSDF_POLYHEDRON_NON_MANIFOLD;
}

void write_site_records(const MeshTopology& topology, const Frusta& frusta, const LatticeView& lattice,
                        std::size_t first, std::span<Polyhedron> records) {
    for (std::size_t i = 0; i < records.size(); ++i) {
        const SiteFrustum& site = frusta.sites[first + i];
        const Vector position = (to_vector(frusta.positions[site.vertex]) - to_vector(lattice.origin)) / lattice.unit;
        new (&records[i]) Polyhedron(pack(point_frame(position, site.normal), site.slopes, topology.order[site.face],
                                          frusta.positions, {site.vertex, site.vertex, site.vertex}, lattice));
        const Triangle& corners = topology.faces.triangles[site.face];
        const auto corner =
            static_cast<std::uint32_t>(std::find(corners.begin(), corners.end(), site.vertex) - corners.begin());
        records[i].flags |= CLSDF_POLYHEDRON_POINT | corner << CLSDF_POLYHEDRON_VERTEX_SHIFT;
    }
}

}  // namespace clsdf::engine
