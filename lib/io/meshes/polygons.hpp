#pragma once

#include "mesh/mesh_arrays.hpp"

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace clsdf {

/// Polygons that stay fans because their ears were not found within a limit of steps.
struct UncutPolygons {
    std::size_t count = 0;
    std::size_t first_triangle = 0;  ///< of the first of them
    std::size_t corners = 0;         ///< of the first of them

    /// Adds those of later triangles.
    void add(const UncutPolygons& later) {
        if (count == 0) {
            first_triangle = later.first_triangle;
            corners = later.corners;
        }
        count += later.count;
    }
};

/// The polygons of a mesh file. A polygon of n corners becomes n - 2 triangles of its winding:
/// - a fan around its first corner, if no triangle of the fan faces against the polygon's normal;
/// - else ears (G. H. Meisters, Polygons Have Ears, 1975), in the plane that drops the normal's largest component.
///   A corner on a straight line, or equal to another one, may get a triangle without area;
/// - the fan nevertheless, if the polygon has no area, if no such triangles exist because it crosses itself, or if they
///   are not found within a limit of steps.
class Polygons {
public:
    /// Adds the polygon's fan to the triangles. The vertices may follow later.
    void add(MeshArrays& mesh, std::span<const std::uint32_t> corners);

    /// Replaces fans by ears where that is needed, once all vertices are known.
    UncutPolygons triangulate(MeshArrays& mesh) const;

private:
    struct Fan {
        std::size_t first_triangle;
        std::size_t triangles;
    };

    std::vector<Fan> fans_;
};

}  // namespace clsdf
