#include "polyhedra/solid_mesh.hpp"

#include <clsdf/error.hpp>

#include <fmt/format.h>

#include <cmath>
#include <utility>

namespace clsdf::polyhedra {

Mesh solid_mesh(const ConvexPolyhedron& solid, const Vector& origin, double unit) {
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

void check_solids_asked_for(const Mesh& mesh, std::span<const std::uint32_t> triangles, double half_width) {
    if (!(half_width > 0) || !std::isfinite(half_width))
        throw Error(ErrorCode::invalid_argument,
                    fmt::format("polyhedra need a positive and finite half width, not {}", half_width));
    for (const std::uint32_t triangle : triangles)
        if (triangle >= mesh.triangles().size())
            throw Error(ErrorCode::invalid_argument, fmt::format("{} has no triangle {}: its triangles are 0 to {}",
                                                                 mesh.name(), triangle, mesh.triangles().size() - 1));
}

}  // namespace clsdf::polyhedra
