#pragma once

#include <clsdf/mesh.hpp>

#include <array>
#include <cmath>
#include <cstddef>
#include <numbers>

namespace clsdf::test {

/// The generalised winding number: the sum of the solid angles of all faces, in extended precision.
inline double winding_by_faces(const Mesh& mesh, const Vec3& p) {
    using Wide = long double;
    Wide sum = 0;
    for (const Triangle& triangle : mesh.triangles()) {
        std::array<std::array<Wide, 3>, 3> at{};
        std::array<Wide, 3> length{};
        for (std::size_t k = 0; k < 3; ++k) {
            for (std::size_t axis = 0; axis < 3; ++axis)
                at[k][axis] = Wide(mesh.vertices()[triangle[k]][axis]) - Wide(p[axis]);
            length[k] = std::sqrt(at[k][0] * at[k][0] + at[k][1] * at[k][1] + at[k][2] * at[k][2]);
        }
        const auto dot = [&](std::size_t a, std::size_t b) {
            return at[a][0] * at[b][0] + at[a][1] * at[b][1] + at[a][2] * at[b][2];
        };
        const Wide volume = at[0][0] * (at[1][1] * at[2][2] - at[1][2] * at[2][1]) +
                            at[0][1] * (at[1][2] * at[2][0] - at[1][0] * at[2][2]) +
                            at[0][2] * (at[1][0] * at[2][1] - at[1][1] * at[2][0]);
        const Wide rest =
            length[0] * length[1] * length[2] + dot(0, 1) * length[2] + dot(1, 2) * length[0] + dot(2, 0) * length[1];
        if (volume != 0 || rest != 0) sum += std::atan2(volume, rest);
    }
    return static_cast<double>(sum / (2 * std::numbers::pi_v<Wide>));
}

}  // namespace clsdf::test
