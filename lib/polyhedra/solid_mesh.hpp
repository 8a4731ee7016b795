#pragma once

#include "polyhedra/convex_polyhedron.hpp"

#include <clsdf/mesh.hpp>

namespace clsdf::polyhedra {

/// The surface of a polyhedron that is not empty, in triangles: `origin` + `unit` times its vertices.
Mesh solid_mesh(const ConvexPolyhedron& solid, const Vector& origin, double unit = 1);

/// Throws Error(invalid_argument) for a half width that is not positive and finite, or a triangle out of range.
void check_solids_asked_for(const Mesh& mesh, std::span<const std::uint32_t> triangles, double half_width);

}  // namespace clsdf::polyhedra
