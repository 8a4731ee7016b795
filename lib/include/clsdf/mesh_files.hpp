#pragma once

/// Files of meshes and points, and defects of meshes, in a separate target, clsdf::meshes. It links no other library
/// than the core does: a program with its own HDF5, for instance the parallel one, may link it. clsdf/io.hpp has the
/// files of fields, too.
#include <clsdf/export.hpp>
#include <clsdf/field.hpp>
#include <clsdf/mesh.hpp>
#include <clsdf/outer.hpp>
#include <clsdf/outputs.hpp>

#include <array>
#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <vector>

namespace clsdf {

/// How files of meshes are read.
struct ReadOptions {
    /// Called with a warning that names the file for each kind of thing that was skipped or changed: faces of one or
    /// two corners, bytes after the last row of a binary .ply, lines without a keyword in its header, lines of an .obj
    /// with unknown keywords, vertices of an .obj with a fourth number w other than 1, by which x, y and z are divided,
    /// and polygons that become fans because their ears take too many steps.
    std::function<void(const std::string& message)> log{};
    /// Every position x of the file becomes R (x * scale) + translate, in double; without a rotation R, the product and
    /// the sum are each rounded once. 0.001 makes metres of millimetres. Finite, and the scale > 0: a mirrored mesh
    /// would be inside out.
    double scale = 1;
    Vec3 translate{};
    /// The axis of the file that points up: "x", "y", "z", "-x", "-y" or "-z". The mesh gets z up, by a rotation about
    /// x, or about y for "x" and "-x": of a file with y up, (x, y, z) becomes (x, -z, y).
    std::string up = "z";
    /// Degrees about the fixed axes x, y and z, one after the other (roll, pitch and yaw), after `up`. Multiples of 90
    /// exchange and negate coordinates, and round nothing.
    Vec3 rotate{};
    /// A property of the faces of .ply files, of an integer type: its values are the names of the groups.
    std::string group_by{};
    /// Faces with a coordinate that is not finite, or that name a vertex that does not exist, are left out; `log` gets
    /// their number and the first of them. Without this they are errors.
    bool skip_bad_facets = false;
};

/// Reads .off, .obj, .stl (ASCII and binary) or .ply (ASCII and binary, both byte orders, single faces and triangle
/// strips). Numbers in text may be as Fortran writes them, 1.0D+00 or 1.0+120. A polygon becomes a fan
/// around its first corner; if the fan would leave a concave polygon, the polygon is cut into ears. A polygon that
/// crosses itself stays a fan. Vertices of equal coordinates in an STL file become one. Throws Error(unreadable_input
/// or invalid_mesh) that names the file, the line or element and the value, also for a file that is not what its ending
/// says, as a pointer of Git LFS; Error(unsupported) for an unknown ending; Error(invalid_argument) for a scale, a
/// rotation or a translation that makes no sense or that makes a vertex in use infinite, or for a property of groups
/// that the file does not have.
///
/// Mesh::groups() are the solids of an ASCII STL file, the groups and objects of an OBJ file ("object/group" if a face
/// has both), or the values of `group_by` of a PLY file; docs/formats.md has the rules.
CLSDF_EXPORT Mesh read_mesh(const std::string& path, const ReadOptions& options = {});

/// Reads several files as one mesh: the vertices and the triangles of each file follow those of the one before it.
/// Each file is a group with the file's name without folder and ending; a file with several groups has "name/group".
/// Throws as read_mesh(), and Error(invalid_argument) for no path.
CLSDF_EXPORT Mesh read_meshes(std::span<const std::string> paths, const ReadOptions& options = {});

/// Red, green and blue, sRGB.
using FaceColour = std::array<std::uint8_t, 3>;

/// Writes .off, .obj, .stl (binary) or .ply (binary, little endian) by the file's ending; complete or not at all.
/// `colours`: one for each triangle, or none; only .ply stores them. Throws Error(invalid_argument) for another number
/// of them, Error(unsupported) for an unknown ending, Error(output_failure).
CLSDF_EXPORT void write_mesh(const Mesh& mesh, const std::string& path, std::span<const FaceColour> colours = {});

/// The same of an outer surface. A .ply file has the property `given_face` (uint) of each triangle, too:
/// OuterSurface::faces.
CLSDF_EXPORT void write_mesh(const OuterSurface& surface, const std::string& path);

/// Throws the error that write_mesh() would throw for the ending or the folder. Leaves no file.
CLSDF_EXPORT void check_mesh_path(const std::string& path);

/// Defects of a mesh other than those of its edges, which Topology describes. Vertices of equal coordinates count as
/// one. The distance is exact in spite of them.
struct Defects {
    std::size_t zero_area_faces = 0;  ///< three different vertices on one line, exactly
    std::size_t duplicate_faces = 0;  ///< with the three different vertices of an earlier face, in whatever order
    std::size_t components = 0;       ///< parts of the mesh that share no vertex
};

CLSDF_EXPORT Defects find_defects(const Mesh& mesh);

/// How a mesh differs from the one that it was welded from (weld() of clsdf/mesh.hpp), face by face.
struct WeldReport {
    std::size_t lost_faces = 0;        ///< had three different vertices, and have fewer now, so no area
    std::size_t coinciding_faces = 0;  ///< have the three vertices of other faces now, and did not before
    /// A closed mesh has its volume, > 0 if its faces look outwards; an open one that of the cones from the faces to
    /// the centre of the box.
    double volume_before = 0;
    double volume_after = 0;
    /// What the faces that are lost or coincide mean, with the remedy; empty if there are none.
    std::string warning;
};

/// `welded`: weld(mesh, tolerance). A thin wall may be flat then. Throws Error(invalid_argument) unless both have as
/// many triangles.
CLSDF_EXPORT WeldReport describe_weld(const Mesh& mesh, const Mesh& welded);

/// Reads points from .npy (shape (n, 3), float32 or float64, in C or Fortran order), .csv (a header row with the
/// columns x, y and z; other columns are skipped; an empty field or NA is NaN) or .ply (its vertices, with or without
/// faces). Throws
/// Error(unreadable_input) that names the file, the row and the value; Error(unsupported) for an unknown ending. log:
/// called with warnings about a .ply file, as ReadOptions::log.
CLSDF_EXPORT std::vector<Vec3> read_points(const std::string& path,
                                           const std::function<void(const std::string& message)>& log = {});

/// Writes what DistanceTransform::query() found, a row for each point, by the file's ending: .npy (a structured array
/// of the outputs), .csv or .ply (binary; both with x, y and z before them); complete or not at all. The columns are
/// the distance, the outputs in `wanted`, and every other output whose array is not empty; docs/formats.md describes
/// them. `wanted` is needed only without points. winding: of the points, for a last column, or empty. groups: of the
/// mesh, for a column of the numbers of the nearest triangles' groups; needs the output triangle; or null. Throws
/// Error(invalid_argument) if an array does not fit the points, Error(unsupported) for an unknown ending,
/// Error(output_failure).
CLSDF_EXPORT void write_points(std::span<const Vec3> points, const FieldSlab& results, const std::string& path,
                               OutputSet wanted = {}, std::span<const float> winding = {},
                               const FaceGroups* groups = nullptr);

/// Rays in the order of a file.
struct RayRows {
    std::vector<Vec3> origins;
    std::vector<Vec3> directions;  ///< as many
};

/// Reads rays from .npy (shape (n, 6), float32 or float64: the origin, then the direction) or .csv (a header row with
/// the columns x, y, z, dx, dy and dz). Throws as read_points().
CLSDF_EXPORT RayRows read_rays(const std::string& path);

/// What DistanceTransform::rays() found.
struct RayHits {
    std::size_t most = 1;         ///< numbers of `t` and `triangles` for each ray
    std::span<const double> t{};  ///< packed
    std::span<const std::uint32_t> triangles{};
    std::span<const std::uint32_t> counts{};  ///< or empty: no column
};

/// Writes them, a row for each ray, by the file's ending: .npy (a structured array of t, triangle, group and count; of
/// several hits t, triangle and group are vectors) or .csv (with x, y, z, dx, dy and dz before them); complete or not
/// at all. Throws as write_points().
/// groups: of the mesh, for a column with the number of the group of each triangle; null: none.
CLSDF_EXPORT void write_rays(const RayRows& rays, const RayHits& hits, const std::string& path,
                             const FaceGroups* groups = nullptr);

/// Throws the error that write_rays() would throw for the ending or the folder. Leaves no file.
CLSDF_EXPORT void check_rays_path(const std::string& path);

/// Throws the error that write_points() would throw for the ending or the folder. Leaves no file.
CLSDF_EXPORT void check_points_path(const std::string& path);

}  // namespace clsdf
