#pragma once

#include <clsdf/grid.hpp>
#include <clsdf/mesh.hpp>

#include <cstddef>
#include <span>

namespace clsdf::bench {

/// The counts of a scan.
struct SoftwareScanCounts {
    std::size_t polyhedra = 0;      ///< towers, wedges and cones
    std::size_t intersections = 0;  ///< polygons in which a slice cuts a polyhedron
    std::size_t distances = 0;      ///< computed, one for each sample of a polyhedron
};

/// The literature's method on a processor: scan conversion of Mauch's polyhedra (S. Mauch, A Fast Algorithm for
/// Computing the Closest Point and Distance Transform, 2000; his program cpt), in float.
///
/// The polyhedra are solids with corners and faces: a tower on both sides of each face, a wedge on the convex side of
/// each edge, and at each vertex, also at saddle vertices, the cone of directions away from all its faces. Each slice
/// cuts a solid into a convex polygon, which is cut into rows. At each sample of a row the signed distance to the site
/// replaces the value if it is less. Slabs of slices are computed independently, each with its list of polyhedra, so no
/// two threads write to the same sample. A sample in no polyhedron has the half width and the sign of the sample before
/// it in its row, or of the row before.
///
/// The mesh must be closed and manifold, its faces counter-clockwise from outside; the grid's spacing equal on all axes
/// (else Error(unsupported)). `half_width` in the mesh's units, two voxels at least for signs to be
/// right beyond the band. `distance` has grid.sample_count() values.
SoftwareScanCounts software_scan(const Mesh& mesh, const Grid& grid, double half_width, std::size_t threads,
                                 std::span<float> distance);

}  // namespace clsdf::bench
