#include "triangle_frame.hpp"

#include <clsdf/reference.hpp>

namespace clsdf::reference {

Nearest nearest_on_triangle(const Vec3& query, const Vec3& a, const Vec3& b, const Vec3& c) {
    const TriangleFrame::Closest closest = TriangleFrame(a, b, c).closest({query, {}});
    return {closest.distance, 0, closest.site, closest.point};
}

Nearest nearest_by_brute_force(const Mesh& mesh, const Vec3& query) {
    Nearest nearest;
    nearest.distance = std::numeric_limits<double>::infinity();
    for (std::uint32_t index = 0; index < mesh.triangles().size(); ++index) {
        const Triangle& triangle = mesh.triangles()[index];
        const Nearest candidate = nearest_on_triangle(query, mesh.vertices()[triangle[0]], mesh.vertices()[triangle[1]],
                                                      mesh.vertices()[triangle[2]]);
        if (candidate.distance < nearest.distance) {
            nearest = candidate;
            nearest.triangle = index;
        }
    }
    return nearest;
}

}  // namespace clsdf::reference
