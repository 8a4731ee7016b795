#include "tree/crossed_faces.hpp"

#include "core/parallel.hpp"
#include "core/refuse.hpp"
#include "mesh/expansions.hpp"

#include <clsdf/error.hpp>

#include <algorithm>
#include <cmath>
#include <numbers>

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

double area_of(const CrossedFaces::Corners& corners) {
    Vec3 cross{};
    for (std::size_t axis = 0; axis < 3; ++axis) {
        const std::size_t i = (axis + 1) % 3, j = (axis + 2) % 3;
        cross[axis] = (corners[1][i] - corners[0][i]) * (corners[2][j] - corners[0][j]) -
                      (corners[1][j] - corners[0][j]) * (corners[2][i] - corners[0][i]);
    }
    return 0.5 * std::sqrt(cross[0] * cross[0] + cross[1] * cross[1] + cross[2] * cross[2]);
}

}  // namespace

bool is_exact_in_units(const Vec3& p, double per_unit) {
    return std::ranges::all_of(p, [per_unit](double x) {
        const double in_units = x * per_unit;
        return x == 0 || (in_units != 0 && expansions::is_in_exact_range(in_units));
    });
}

bool are_exact(const PointMesh& mesh) {
    const double per_unit = 1 / mesh.lattice.unit;
    return are_exact(mesh.positions, per_unit) && are_exact(mesh.sign_positions, per_unit);
}

void refuse_inexact(const PointMesh& mesh, const std::string& name) {
    for (const auto& positions : {std::span<const Vec3>(mesh.positions), std::span<const Vec3>(mesh.sign_positions)})
        for (const Vec3& p : positions)
            for (const double x : p)
                if (!is_exact_in_units({x, 0, 0}, 1 / mesh.lattice.unit))
                    refuse_unsupported(
                        "{} has the coordinate {}, which in units of {} is smaller than 2^-300 or "
                        "greater than 2^300: where segments meet the surface cannot be decided "
                        "then; set such coordinates to 0",
                        name, x, mesh.lattice.unit);
    throw Error(ErrorCode::wrong_results, name + " has no coordinate out of range, and one was found");
}

// A face of the area A turns the winding number of a point that is d away by at most A / (4 pi d^2). So where d^2 is
// greater than the whole area / (2 pi), the winding number is less than 1/2.
CrossedExtent crossed_extent(const PointMesh& mesh) {
    CrossedExtent extent;
    extent.are_exact = are_exact(mesh);
    if (!extent.are_exact || !mesh.film) return extent;
    const CrossedFaces faces{mesh};
    const Vec3 lower = scaled(mesh.box.lower, faces.per_unit), upper = scaled(mesh.box.upper, faces.per_unit);
    double square = 0;
    for (std::size_t axis = 0; axis < 3; ++axis) {
        extent.centre[axis] = 0.5 * (lower[axis] + upper[axis]);
        square += (upper[axis] - lower[axis]) * (upper[axis] - lower[axis]);
    }
    extent.diagonal = std::sqrt(square);
    double area = 0;
    for (std::size_t face = 0; face < faces.count(); ++face)
        if (mesh.sign_count(face) != 0) area += area_of(faces.sign_corners(face));
    extent.radius = 0.51 * extent.diagonal + 1.1 * std::sqrt(area / (2 * std::numbers::pi));
    return extent;
}

}  // namespace clsdf::engine
