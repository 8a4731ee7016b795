#include "points/sign_faces.hpp"

#include "core/large_memory.hpp"
#include "core/parallel.hpp"
#include "launch/commands.hpp"
#include "mesh/expansions.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

namespace clsdf::points {

namespace {

/// Positions in units, whose division by a power of two rounds none that is in range, and makes no other one 0.
UninitializedVector<Vec3> in_units(std::span<const Vec3> positions, double unit) {
    UninitializedVector<Vec3> result(positions.size());
    for_each_index(positions.size(), [&](std::size_t i) {
        for (std::size_t axis = 0; axis < 3; ++axis) {
            const double given = positions[i][axis], scaled = given / unit;
            result[i][axis] = scaled == 0 && given != 0 ? std::numeric_limits<double>::denorm_min() : scaled;
        }
    });
    return result;
}

/// As SignFaces::are_moderate.
bool are_moderate(std::span<const Vec3> positions) {
    return std::ranges::all_of(positions, [](const Vec3& p) {
        return std::ranges::all_of(p, [](double coordinate) {
            const double size = std::abs(coordinate);
            return size == 0 || (size >= 0x1p-60 && size <= 0x1p40);
        });
    });
}

SignFaces sign_faces_of(const engine::PointFaces& mesh, SignRule rule) {
    SignFaces faces{};
    faces.count = static_cast<clsdf_uint32>(mesh.count);
    faces.per_unit = 1 / mesh.lattice.unit;
    faces.lower_x = mesh.box.lower[0];
    faces.upper_x = mesh.box.upper[0];
    faces.has_sign = rule != SignRule::none;
    faces.is_parity = rule == SignRule::parity;
    return faces;
}

}  // namespace

DeviceSignFaces make_sign_faces(const engine::DeviceTools& tools, const engine::PointFaces& mesh, SignRule rule) {
    DeviceSignFaces result;
    result.are_exact = mesh.found.inexact == 0;
    if (!result.are_exact) return result;
    result.faces = sign_faces_of(mesh, rule);
    result.faces.are_moderate = mesh.found.immoderate == 0;
    const engine::GeometryOnDevice& geometry = *mesh.geometry;
    const std::size_t count = geometry.topology->vertex_count();
    result.positions = tools.pool->lease(count * sizeof(Vec3), "the surface that decides signs");
    device::guarded([&] {
        device::LentKernel kernel = tools.kernel(tools.programs.point_faces, "positions_in_units");
        engine::launch(tools.queue(), kernel, {count}, static_cast<cl_uint>(count), cl_double{mesh.lattice.unit},
                       **geometry.positions, *result.positions);
    });
    return result;
}

DeviceSignFaces make_sign_faces(const engine::DeviceTools& tools, const engine::PointMesh& mesh, SignRule rule,
                                const OpenBoundary* boundary) {
    const double unit = mesh.lattice.unit;
    const auto upload = [&](const auto& values) {
        return device::uploaded(tools.context, tools.pool, values, "the surface that decides signs");
    };
    DeviceSignFaces result;
    const UninitializedVector<Vec3> positions = in_units(mesh.positions, unit);
    const UninitializedVector<Vec3> sign_positions = in_units(mesh.sign_positions, unit);
    UninitializedVector<Vec3> floor;
    if (boundary != nullptr && boundary->floor)
        floor = in_units(std::array<Vec3, 1>{Vec3{0, 0, *boundary->floor}}, unit);
    result.are_exact =
        expansions::are_exact(positions) && expansions::are_exact(sign_positions) && expansions::are_exact(floor);
    if (!result.are_exact) return result;
    SignFaces& faces = result.faces = sign_faces_of(mesh, rule);
    faces.are_moderate = are_moderate(positions) && are_moderate(sign_positions);
    faces.is_backward = mesh.is_part || boundary != nullptr;
    result.positions = upload(positions);
    if (!sign_positions.empty()) {
        faces.has_sign_positions = 1;
        result.sign_positions = upload(sign_positions);
    }
    if (!mesh.sign_counts.empty()) {
        faces.has_counts = 1;
        result.counts = upload(mesh.sign_counts);
    }
    if (boundary != nullptr && !boundary->empty()) {
        std::vector<std::uint32_t> begins(boundary->begins.begin(), boundary->begins.end());
        faces.loops = static_cast<clsdf_uint32>(begins.size() - 1);
        result.corner_count = boundary->corners.size();
        result.corners = upload(in_units(boundary->corners, unit));
        result.begins = upload(begins);
        faces.has_floor = !floor.empty();
        if (!floor.empty()) faces.floor = floor[0][2];
    }
    return result;
}

}  // namespace clsdf::points
