#include "tree/crossed_faces.hpp"

#include "core/parallel.hpp"
#include "mesh/expansions.hpp"

#include <algorithm>
#include <span>

namespace clsdf::engine {

namespace {

bool are_exact(std::span<const Vec3> positions, double per_unit) {
    return reduce_ranges(
        positions.size(), usual_grain, true,
        [&](std::size_t begin, std::size_t end, bool are) {
            return are && std::ranges::all_of(positions.subspan(begin, end - begin),
                                              [&](const Vec3& p) { return is_exact_in_units(p, per_unit); });
        },
        [](bool a, bool b) { return a && b; });
}

UninitializedVector<CrossedFaces::Corners> corners_of(std::size_t count, double per_unit, const auto& corners_of_face) {
    UninitializedVector<CrossedFaces::Corners> result(count);
    for_each_index(count, [&](std::size_t face) {
        const CrossedFaces::Corners corners = corners_of_face(face);
        for (std::size_t k = 0; k < 3; ++k) result[face][k] = scaled(corners[k], per_unit);
    });
    return result;
}

}  // namespace

bool is_exact_in_units(const Vec3& p, double per_unit) {
    return std::ranges::all_of(p, [per_unit](double x) {
        const double in_units = x * per_unit;
        return x == 0 || (in_units != 0 && expansions::is_in_exact_range(in_units));
    });
}

CrossedFaces make_crossed_faces(const PointMesh& mesh) {
    const double per_unit = 1 / mesh.lattice.unit;
    CrossedFaces faces;
    faces.are_exact = are_exact(mesh.positions, per_unit) && are_exact(mesh.sign_positions, per_unit);
    if (!faces.are_exact) return faces;
    faces.corners = corners_of(mesh.face_count(), per_unit, [&](std::size_t face) { return mesh.corners(face); });
    if (!mesh.sign_positions.empty())
        faces.sign_corners =
            corners_of(mesh.face_count(), per_unit, [&](std::size_t face) { return mesh.sign_corners(face); });
    return faces;
}

}  // namespace clsdf::engine
