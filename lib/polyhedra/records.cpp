#include "polyhedra/records.hpp"

#include "core/parallel.hpp"
#include "polyhedra/topology.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <new>

namespace clsdf::polyhedra {

namespace {

void store(double x, double& exact, float& rounded) {
    exact = x;
    rounded = static_cast<float>(x);
}

/// The nearest sample along an axis. Beyond the clamp the offset in the constants does the rest.
clsdf_int32 nearest_sample(double samples) {
    constexpr double limit = 1 << 30;
    return static_cast<clsdf_int32>(std::lrint(std::clamp(samples, -limit, limit)));
}

bool is_compact(const TriangleFrame& frame, const Polyhedron& polyhedron) {
    const auto is_flat = [](float slope) { return slope <= 1; };
    return std::min(frame.normal_along[0], frame.normal_along[1]) > 0.15 &&
           std::all_of(polyhedron.slope_above, polyhedron.slope_above + 3, is_flat) &&
           std::all_of(polyhedron.slope_below, polyhedron.slope_below + 3, is_flat);
}

bool is_near(const TriangleFrame& frame, const Polyhedron& polyhedron) {
    const auto is_short = [](double length) { return std::abs(length) <= CLSDF_NEAR_LENGTH; };
    return is_short(frame.base[0]) && is_short(frame.base[1]) && is_short(frame.altitude) &&
           std::all_of(polyhedron.foot, polyhedron.foot + 3, is_short);
}

/// The foot of the altitude from a sample, in units.
Vector foot_from(const Vector& sample, const TriangleFrame& frame, std::span<const Vec3> positions,
                 const Triangle& corners, const LatticeView& lattice) {
    Vector foot = frame.foot - sample.cwiseProduct(to_vector(lattice.spacing_in_units));
    if (frame.foot.cwiseAbs().maxCoeff() <= LatticeView::far) return foot;
    // From the end of the base that is nearer; the base runs from its left end to its right one, the next corner.
    const bool is_right = frame.base[CLSDF_HALF_RIGHT] <= frame.base[CLSDF_HALF_LEFT];
    const double to_foot = is_right ? -frame.base[CLSDF_HALF_RIGHT] : frame.base[CLSDF_HALF_LEFT];
    const Vec3& end = positions[corners[is_right ? next_of_three(frame.base_edge) : frame.base_edge]];
    for (int axis = 0; axis < 3; ++axis) {
        if (!(std::abs(frame.foot[axis]) > LatticeView::far)) continue;
        const auto a = static_cast<std::size_t>(axis);
        foot[axis] = lattice.from_sample(a, end[a], sample[axis]) + to_foot * frame.along[axis];
    }
    return foot;
}

void pack_origin(const TriangleFrame& frame, std::span<const Vec3> positions, const Triangle& corners,
                 const LatticeView& lattice, Polyhedron& polyhedron) {
    const Vector spacing = to_vector(lattice.spacing_in_units);
    const Vector samples = frame.foot.cwiseQuotient(spacing);
    polyhedron.origin_x = nearest_sample(samples.x());
    polyhedron.origin_y = nearest_sample(samples.y());
    polyhedron.origin_z = nearest_sample(samples.z());
    const Vector origin(polyhedron.origin_x, polyhedron.origin_y, polyhedron.origin_z);
    const Vector offset = foot_from(origin, frame, positions, corners, lattice);
    for (int axis = 0; axis < 3; ++axis) polyhedron.foot[axis] = static_cast<float>(offset[axis]);
    const Vector constant(-dot(frame.along, offset), -dot(frame.across(), offset), -dot(frame.normal, offset));
    for (int i = 0; i < 3; ++i)
        store(constant[i], polyhedron.exact_constant_at_origin[i], polyhedron.constant_at_origin[i]);
}

void pack_gradients(const TriangleFrame& frame, const LatticeView& lattice, Polyhedron& polyhedron) {
    const auto pack_axis = [&](int axis, double* exact, float* rounded) {
        const double spacing = lattice.spacing_in_units[static_cast<std::size_t>(axis)];
        store(frame.along[axis] * spacing, exact[0], rounded[0]);
        store(frame.across()[axis] * spacing, exact[1], rounded[1]);
        store(frame.normal[axis] * spacing, exact[2], rounded[2]);
    };
    pack_axis(0, polyhedron.exact_gradient_x, polyhedron.gradient_x);
    pack_axis(1, polyhedron.exact_gradient_y, polyhedron.gradient_y);
    pack_axis(2, polyhedron.exact_gradient_z, polyhedron.gradient_z);
}

}  // namespace

Polyhedron pack(const TriangleFrame& frame, const FaceSlopes& slopes, std::uint32_t triangle,
                std::span<const Vec3> positions, const Triangle& corners, const LatticeView& lattice) {
    // NOLINTNEXTLINE(cppcoreguidelines-pro-type-member-init): every member is set below; clearing first costs as much
    Polyhedron polyhedron;
    pack_origin(frame, positions, corners, lattice, polyhedron);
    pack_gradients(frame, lattice, polyhedron);
    polyhedron.exact_altitude = frame.altitude;
    for (std::size_t half = 0; half < 2; ++half) {
        store(frame.base[half], polyhedron.exact_base[half], polyhedron.base[half]);
        store(frame.normal_along[half], polyhedron.exact_normal_along[half], polyhedron.normal_along[half]);
        store(frame.normal_across[half], polyhedron.exact_normal_across[half], polyhedron.normal_across[half]);
    }
    for (std::uint32_t k = 0; k < 3; ++k) {
        polyhedron.slope_above[frame.polyhedron_edge(k)] = slopes.above[k];
        polyhedron.slope_below[frame.polyhedron_edge(k)] = slopes.below[k];
    }
    polyhedron.triangle = triangle;
    polyhedron.flags = frame.base_edge << CLSDF_POLYHEDRON_VERTEX_SHIFT;
    if (is_compact(frame, polyhedron)) polyhedron.flags |= CLSDF_POLYHEDRON_COMPACT;
    if (is_near(frame, polyhedron)) polyhedron.flags |= CLSDF_POLYHEDRON_NEAR;
    return polyhedron;
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

void write_face_records(const MeshTopology& topology, const Frusta& frusta, const LatticeView& lattice,
                        std::span<Polyhedron> records) {
    for_each_index(records.size(),
                   [&](std::size_t face) { write_face_record(topology, frusta, lattice, face, records[face]); });
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

}  // namespace clsdf::polyhedra
