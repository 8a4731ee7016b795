#pragma once

#include <clsdf/grid.hpp>
#include <clsdf/mesh.hpp>

#include <cstddef>
#include <span>

namespace clsdf::bench {

/// What a scan was made of.
struct SoftwareScanCounts {
    std::size_t polyhedra = 0;      ///< towers, wedges and cones
    std::size_t intersections = 0;  ///< polygons in which a slice cuts a polyhedron
    std::size_t distances = 0;      ///< computed, one for each sample of a polyhedron
};

/// The literature's method on a processor: scan conversion of Mauch's polyhedra (S. Mauch, A Fast Algorithm for
/// Computing the Closest Point and Distance Transform, 2000; his program cpt), in float.
///
/// A tower on both sides of each face, a wedge at each edge on the side where it is convex, and at each vertex the cone
/// of directions away from all its faces, also at saddle vertices, are built as solids with corners and faces. Slice by
/// slice, each is cut into a convex polygon, this into rows, and at each sample of a row the signed distance to the one
/// site replaces what is there if it is less. Slabs of slices are computed independently, each with the list of
/// polyhedra that cut it, so that no two threads write to the same sample. What no polyhedron holds has the half width
/// and the sign of the sample before it in its row, or of the row before.
///
/// The mesh must be closed and manifold, its faces counter-clockwise from outside; the grid's spacing equal on all axes
/// (else Error(unsupported)). `half_width` in the mesh's units, two voxels at least for signs to be
/// right beyond the band. `distance` has grid.sample_count() values.
SoftwareScanCounts software_scan(const Mesh& mesh, const Grid& grid, double half_width, std::size_t threads,
                                 std::span<float> distance);

}  // namespace clsdf::bench
