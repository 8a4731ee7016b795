#include "tree/crossed_faces.hpp"

#include "core/parallel.hpp"
#include "mesh/expansions.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
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

/// The area of a face.
double area_of(const CrossedFaces::Corners& corners) {
    Vec3 cross{};
    for (std::size_t axis = 0; axis < 3; ++axis) {
        const std::size_t i = (axis + 1) % 3, j = (axis + 2) % 3;
        cross[axis] = (corners[1][i] - corners[0][i]) * (corners[2][j] - corners[0][j]) -
                      (corners[1][j] - corners[0][j]) * (corners[2][i] - corners[0][i]);
    }
    return 0.5 * std::sqrt(cross[0] * cross[0] + cross[1] * cross[1] + cross[2] * cross[2]);
}

/// A face of the area A turns the winding number of a point that is d away by at most A / (4 pi d^2). So where d^2 is
/// greater than the whole area / (2 pi), the winding number is less than 1/2.
void set_ball(const PointMesh& mesh, double per_unit, CrossedFaces& faces) {
    double square = 0;
    for (std::size_t axis = 0; axis < 3; ++axis) {
        const double lower = mesh.box.lower[axis] * per_unit, upper = mesh.box.upper[axis] * per_unit;
        faces.centre[axis] = 0.5 * (lower + upper);
        square += (upper - lower) * (upper - lower);
    }
    faces.diagonal = std::sqrt(square);
    double area = 0;
    for (std::size_t face = 0; face < mesh.face_count(); ++face)
        if (mesh.sign_count(face) != 0) area += area_of(faces.of_sign(face));
    faces.radius = 0.51 * faces.diagonal + 1.1 * std::sqrt(area / (2 * std::numbers::pi));
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
    if (mesh.film) set_ball(mesh, per_unit, faces);
    return faces;
}

}  // namespace clsdf::engine
