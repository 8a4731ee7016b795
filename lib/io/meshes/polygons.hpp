#pragma once

#include "mesh/mesh_arrays.hpp"

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace clsdf {

/// The polygons of a mesh file. A polygon of n corners becomes n - 2 triangles of its winding:
/// - a fan around its first corner, if no triangle of the fan faces against the polygon's normal;
/// - else ears (G. H. Meisters, Polygons Have Ears, 1975), in the plane that drops the normal's largest component.
///   A corner on a straight line, or equal to another one, may get a triangle without area;
/// - the fan nevertheless, if the polygon has no area, or if no such triangles exist because it crosses itself.
class Polygons {
public:
    /// Adds the polygon's fan to the triangles. The vertices may follow later.
    void add(MeshArrays& mesh, std::span<const std::uint32_t> corners);

    /// Replaces fans by ears where that is needed, once all vertices are known.
    void triangulate(MeshArrays& mesh) const;

private:
    struct Fan {
        std::size_t first_triangle;
        std::size_t triangles;
    };

    std::vector<Fan> fans_;
};

}  // namespace clsdf
