#pragma once

#include <clsdf/distance_transform.hpp>
#include <clsdf/export.hpp>
#include <clsdf/grid.hpp>
#include <clsdf/mesh.hpp>

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

/// The published methods that clsdf comes from, for comparison. They are a library of its own, clsdf::papers.
///
/// R. Peikert and C. Sigg, Optimized Bounding Polyhedra for GPU-Based Distance Transform, 2006; S. Mauch, Efficient
/// Algorithms for Solving Static Hamilton-Jacobi Equations, 2003.
namespace clsdf {

/// The polyhedra that bound the samples to which a triangle may be nearest. The scan by bricks evaluates a triangle at
/// whole blocks of samples that its polyhedron overlaps, the scan by slices only at the samples in its polyhedron.
enum class Polyhedra : std::int32_t {
    leaned = 0,        ///< exact for every mesh
    peikert_sigg = 1,  ///< as Peikert & Sigg published them, gaps closed; not exact: to be compared with
    mauch = 2,         ///< Mauch's towers of faces, wedges of edges and cones of vertices; exact: to be compared with
};

/// How the samples of the polyhedra are found.
enum class Scan : std::int32_t {
    automatic = 0,    ///< bricks for leaned polyhedra, slices for the others
    bricks = 1,       ///< bricks of 8 x 8 x 8 samples; for leaned polyhedra only
    slices = 2,       ///< slice by slice, each polyhedron's samples row by row, as in Peikert & Sigg
    brute_force = 3,  ///< every sample with every triangle; for leaned polyhedra, which it does not need
};

/// How the scan by slices keeps the least distance and its triangle; the result is the same.
enum class SliceMinimum : std::int32_t {
    automatic = 0,  ///< in one pass if the device has 64-bit atomics and memory for a slice of them
    one_pass = 1,   ///< an ordered key of distance and triangle: 64-bit atomics
    two_passes = 2  ///< first the distances, then the triangles of the least ones: 32-bit atomics
};

/// "leaned", "peikert-sigg", "mauch".
CLSDF_EXPORT const char* name_of(Polyhedra polyhedra);

/// "auto", "bricks", "slices", "brute-force".
CLSDF_EXPORT const char* name_of(Scan scan);

/// The scan that will be used, never `automatic`. Throws Error(unsupported) for other polyhedra than leaned ones by
/// bricks or by brute force.
CLSDF_EXPORT Scan resolve_scan(Polyhedra polyhedra, Scan asked);

struct PapersOptions {
    Polyhedra polyhedra = Polyhedra::leaned;
    Scan scan = Scan::automatic;
    bool close_gaps = true;  ///< of Peikert & Sigg's polyhedra, as they do; else as they are before that
    SliceMinimum slice_minimum = SliceMinimum::automatic;
};

/// A transform that computes fields with other polyhedra or another scan; with the default of PapersOptions it is that
/// of the core. query() and classify() do not depend on PapersOptions; restrict_to() throws Error(unsupported). The
/// scans by slices and by brute force give the distance and the triangle; other outputs are Error(unsupported). Mauch's
/// towers, wedges and cones count as WorkCounts::polyhedra.
///
/// WorkCounts::method_counts has, of the scan by slices:
///
///     closed_gaps          vertices whose gap was closed as in the paper
///     active_pieces        (convex piece of a polyhedron, slice)
///     slice_intersections  intersections of a piece and a slice that were visited   with CallOptions::count_work
///     empty_intersections  of these, empty ones: none                               with CallOptions::count_work
///
/// Throws what the constructor of DistanceTransform and resolve_scan() throw. Computations throw Error(unsupported) if
/// `slice_minimum` is one_pass and the device has no 64-bit atomics.
CLSDF_EXPORT DistanceTransform make_transform(Device device, const Mesh& mesh, const PapersOptions& method,
                                              const TransformOptions& options = {}, const CallOptions& call = {});

// Peikert & Sigg's classification of a mesh, decided exactly on the coordinates as given. Vertices of equal coordinates
// count as one, and faces with repeated vertices drop out.

enum class EdgeKind : std::uint8_t {
    convex = 0,
    concave = 1,
    flat = 2,          ///< its two faces lie in one plane
    boundary = 3,      ///< one face
    unoriented = 4,    ///< two faces that run along it in the same direction
    non_manifold = 5,  ///< three faces or more
};
inline constexpr std::size_t edge_kinds = 6;

enum class VertexKind : std::uint8_t {
    convex = 0,   ///< convex edges, and no concave one
    concave = 1,  ///< concave edges, and no convex one
    flat = 2,     ///< neither
    saddle = 3,   ///< both
    boundary = 4,
    non_manifold = 5,  ///< an edge that is unoriented or not manifold, or several fans of faces
    unused = 6,        ///< no face
};
inline constexpr std::size_t vertex_kinds = 7;

/// "convex", "non-manifold", ...
CLSDF_EXPORT const char* name_of(EdgeKind kind);
CLSDF_EXPORT const char* name_of(VertexKind kind);

struct Classification {
    std::vector<VertexKind> vertices;  ///< by vertex; equal ones are of one kind

    std::size_t count(EdgeKind kind) const { return edge_counts[static_cast<std::size_t>(kind)]; }
    std::size_t count(VertexKind kind) const { return vertex_counts[static_cast<std::size_t>(kind)]; }

    std::array<std::size_t, edge_kinds> edge_counts{};
    std::array<std::size_t, vertex_kinds> vertex_counts{};  ///< equal vertices count as one
};

CLSDF_EXPORT Classification classify_convexity(const Mesh& mesh);

/// Findings at the saddle vertices, the lower vertex first.
struct SaddleReport {
    /// A face is flipped when seen along the average of the incident faces' unit normals: Peikert & Sigg presuppose
    /// that none is. A face that is seen edgewise, or has no area, counts as flipped.
    std::vector<std::uint32_t> irregular;
    /// The published test fails: a line in which two successive bisector planes meet lies strictly on one side of all
    /// others.
    std::vector<std::uint32_t> adjacent_gaps;
    /// The complete test fails: there are points strictly on one side of all bisector planes. Holds for all of the
    /// former.
    std::vector<std::uint32_t> gaps;

    std::size_t saddles = 0;
    std::size_t decisions = 0;        ///< signs that were asked for
    std::size_t exact_decisions = 0;  ///< of these, the ones that interval arithmetic left open
};

/// Interval arithmetic decides; if it cannot, exact sums of square roots do. There are no tolerances. Parallel planes
/// give no test point. Nor does the plane of an edge if its faces are folded onto each other exactly, or if one of them
/// has no area.
CLSDF_EXPORT SaddleReport examine_saddles(const Mesh& mesh);

struct RegularMesh {
    Mesh mesh;
    std::size_t irregular_vertices = 0;  ///< saddle vertices that still are not regular
    std::size_t added_vertices = 0;
};

/// Peikert & Sigg's remedy for irregular saddle vertices: the same surface with some triangles cut in two, through the
/// middle of an edge. After a cut, the flipped face counts twice in the average of the vertex's normals: a step of the
/// perceptron. So the cuts end if there is a direction from which no face is flipped; if there is none, nothing is cut.
/// The middles are rounded to double, by which a flat edge can become convex or concave. Stops after `rounds`; each of
/// them cuts at most once at a vertex.
CLSDF_EXPORT RegularMesh subdivide_irregular(const Mesh& mesh, std::size_t rounds = 32);

// Mauch's scan in software.

/// The counts of software_scan().
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
/// The faces must be counter-clockwise from outside. `half_width` > 0 in the mesh's units; signs beyond the band need
/// two voxels at least. `threads` 0: all cores. `distance` has grid.sample_count() values. Throws Error(invalid_mesh)
/// unless two faces of one orientation meet at each edge, Error(unsupported) unless the grid's spacing is equal on all
/// axes, Error(invalid_argument) for a half width or a number of distances out of range.
CLSDF_EXPORT SoftwareScanCounts software_scan(const Mesh& mesh, const Grid& grid, double half_width,
                                              std::size_t threads, std::span<float> distance);

// Bounding polyhedra as closed meshes, to look at.

enum class SolidPart : std::uint8_t {
    both_sides = 0,  ///< of the triangle
    front = 1,       ///< the side from which the triangle is counter-clockwise
    back = 2,
    point_site = 3,  ///< of a vertex whose triangles' polyhedra leave a gap
};

/// A polyhedron without the slack that the device's rounding takes.
struct BoundingSolid {
    std::uint32_t triangle = 0;  ///< index in the mesh; of a point site, one of the vertex's
    SolidPart part = SolidPart::both_sides;
    Mesh mesh;  ///< closed, convex, faces counter-clockwise from outside; in the mesh's units
};

/// The triangles with a corner where the vertex is, in order: equal vertices count as one. Throws
/// Error(invalid_argument) if there is no such vertex, or none of its triangles.
CLSDF_EXPORT std::vector<std::uint32_t> triangles_at(const Mesh& mesh, std::uint32_t vertex);

/// The leaned frusta (docs/method.md) of selected triangles of a mesh, in the order given, front and back; then the
/// point sites at those of their vertices that have no other triangles. `half_width` > 0 in the mesh's units. Parts
/// without volume are left out. Throws Error(invalid_argument) for a half width or a triangle out of range.
CLSDF_EXPORT std::vector<BoundingSolid> leaned_solids(const Mesh& mesh, std::span<const std::uint32_t> selected,
                                                      double half_width);

/// The same of Peikert & Sigg's polyhedra, before or after their gaps were closed. They are cut off
/// at eight half widths from the triangle's box: planes that are nearly parallel to the triangle meet anywhere.
CLSDF_EXPORT std::vector<BoundingSolid> peikert_sigg_solids(const Mesh& mesh, std::span<const std::uint32_t> selected,
                                                            double half_width, bool close_gaps = true);

}  // namespace clsdf
