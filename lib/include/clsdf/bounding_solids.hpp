#pragma once

#include <clsdf/export.hpp>
#include <clsdf/mesh.hpp>

#include <cstdint>
#include <span>
#include <vector>

/// Bounding polyhedra as closed meshes, to look at.
namespace clsdf {

enum class SolidPart : std::uint8_t {
    both_sides,  ///< of the triangle
    front,       ///< the side from which the triangle is counter-clockwise
    back,
    point_site,  ///< of a vertex whose triangles' polyhedra leave a gap
};

/// A polyhedron without the slack that the device's rounding takes.
struct BoundingSolid {
    std::uint32_t triangle = 0;  ///< index in the mesh; of a point site, one of the vertex's
    SolidPart part = SolidPart::both_sides;
    Mesh mesh;  ///< closed, convex, faces counter-clockwise from outside; in the mesh's units
};

/// The triangles with a corner where the vertex is, in order: equal vertices count as one. Throws
/// Error(invalid_argument) where there is no such vertex, or none of its triangles.
CLSDF_EXPORT std::vector<std::uint32_t> triangles_at(const Mesh& mesh, std::uint32_t vertex);

/// The leaned frusta (docs/method.md) of selected triangles of a mesh, in the order given, front and back; then the
/// point sites at those of their vertices that have no other triangles. `half_width` > 0 in the mesh's units. Parts
/// without volume are left out. Throws Error(invalid_argument) for a half width or a triangle out of range.
CLSDF_EXPORT std::vector<BoundingSolid> leaned_solids(const Mesh& mesh, std::span<const std::uint32_t> selected,
                                                      double half_width);

/// The same of Peikert & Sigg's polyhedra, before or after their gaps were closed. What reaches farther than eight half
/// widths from the triangle's box is cut off: planes that are nearly parallel to the triangle meet anywhere.
CLSDF_EXPORT std::vector<BoundingSolid> peikert_sigg_solids(const Mesh& mesh, std::span<const std::uint32_t> selected,
                                                            double half_width, bool close_gaps = true);

}  // namespace clsdf
