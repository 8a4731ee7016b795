#pragma once

#include <clsdf/arrays.hpp>
#include <clsdf/export.hpp>

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <utility>
#include <vector>

namespace clsdf {

/// A point or vector (x, y, z) in the mesh's units.
using Vec3 = std::array<double, 3>;

/// A triple of sample counts or sample indices (i, j, k); i runs along x.
using Index3 = std::array<std::int64_t, 3>;

/// An axis-parallel box in the mesh's units, limits included.
struct CLSDF_EXPORT Box {
    Vec3 lower{};
    Vec3 upper{};

    Vec3 extent() const { return {upper[0] - lower[0], upper[1] - lower[1], upper[2] - lower[2]}; }

    /// The longest side: the unit of a length given in percent.
    double longest_side() const;
};

/// Three vertex indices, counter-clockwise seen from outside.
using Triangle = std::array<std::uint32_t, 3>;

/// The group of a sample or point beyond the band.
inline constexpr std::uint32_t no_group = 0xFFFFFFFFU;

/// Groups of a mesh's triangles, each with a name: the solids of an STL file, the patches of a case, the links of a
/// robot.
struct FaceGroups {
    std::vector<std::string> names;      ///< all different; "" may be that of triangles to which a file gives none
    std::vector<std::uint32_t> numbers;  ///< of each triangle: the index of its name

    bool empty() const { return names.empty(); }
    /// The number of a triangle, for instance of the nearest one of a point; no_group for no_triangle.
    std::uint32_t of(std::uint32_t triangle) const { return triangle < numbers.size() ? numbers[triangle] : no_group; }
};

/// A triangle mesh in the caller's arrays; nothing is copied, and the arrays must outlive the view. mesh_view() of
/// clsdf/eigen.hpp makes one of Eigen's matrices.
class CLSDF_EXPORT MeshView {
public:
    /// Vertices are floats or doubles, triangles are indices of 32 or 64 bits. Throws Error(invalid_mesh) for other
    /// types, if an array of numbers has a length that is no multiple of three, or if host memory of known size is too
    /// small.
    MeshView(const InputArray& vertices, const InputArray& triangles);

    const InputArray& vertices() const { return vertices_; }
    const InputArray& triangles() const { return triangles_; }

private:
    InputArray vertices_;
    InputArray triangles_;
};

namespace detail {
struct MeshAccess;

/// The triangles of a mesh, which its copies share. A mesh that was moved from still has them.
class SharedTriangles {
public:
    SharedTriangles(std::vector<Triangle> triangles)  // NOLINT(google-explicit-constructor): an array becomes shared
        : triangles_(std::make_shared<const std::vector<Triangle>>(std::move(triangles))) {}
    SharedTriangles(const SharedTriangles&) noexcept = default;
    SharedTriangles& operator=(const SharedTriangles&) noexcept = default;
    ~SharedTriangles() = default;

    const std::vector<Triangle>& get() const { return *triangles_; }

private:
    std::shared_ptr<const std::vector<Triangle>> triangles_;
};
}  // namespace detail

/// An indexed triangle mesh in double precision, checked: it has a triangle, every index is in range, and every vertex
/// in use is finite. Everything else (degenerate faces, holes, any orientation, unused vertices) is allowed and
/// reported by describe_topology().
class CLSDF_EXPORT Mesh {
public:
    /// Takes the arrays over. Throws Error(invalid_mesh) that names `name`, the element and the value;
    /// Error(unsupported) from 2^32 - 1 vertices or triangles on.
    Mesh(std::vector<Vec3> vertices, std::vector<Triangle> triangles, std::string name = "mesh");
    /// Copies the caller's arrays. Throws Error(invalid_mesh), and Error(unsupported) for memory of the device, which a
    /// DistanceTransform can read.
    explicit Mesh(const MeshView& view, std::string name = "mesh");

    /// New positions of the same vertices. Throws Error(invalid_argument) for another number of them, and
    /// Error(invalid_mesh) if a vertex in use is not finite; the mesh is as before then.
    void set_positions(std::vector<Vec3> positions);
    /// Copies the caller's array. Throws as above, and Error(unsupported) for memory of the device.
    void set_positions(const InputArray& positions);

    const std::vector<Vec3>& vertices() const { return vertices_; }
    const std::vector<Triangle>& triangles() const { return triangles_.get(); }
    const std::string& name() const { return name_; }

    /// The groups of the triangles; empty if the mesh has none. Copies and welded meshes have the same.
    const FaceGroups& groups() const;
    /// Sets them; empty ones remove them. Throws Error(invalid_argument) unless each triangle has a number, each number
    /// has a name, and all names are different; the mesh is as before then.
    void set_groups(FaceGroups groups);

    /// The box of the vertices in use.
    const Box& box() const { return box_; }

    /// A hash of all vertices and triangles, in their order, not of names: the same on every machine. Meshes that
    /// differ in one coordinate or one index never share it, other meshes with a chance of about 2^-64. The ranks of a
    /// parallel program compare it, so as to find out that one was given another mesh. -0.0 and 0.0 differ. No defence
    /// against meshes that are made to share it. Takes time in proportion to the mesh.
    std::uint64_t hash() const;

private:
    friend struct detail::MeshAccess;
    Mesh(std::vector<Vec3> vertices, detail::SharedTriangles triangles, std::string name, const Box& box)
        : vertices_(std::move(vertices)), triangles_(std::move(triangles)), name_(std::move(name)), box_(box) {}

    std::vector<Vec3> vertices_;
    detail::SharedTriangles triangles_;
    std::string name_;
    Box box_;
    std::shared_ptr<const FaceGroups> groups_;  // which copies share; null if there are none
};

/// The mesh in which vertices of equal coordinates are one vertex; triangles keep their order and number.
CLSDF_EXPORT Mesh weld(const Mesh& mesh);

/// The mesh in which vertices are one vertex, too, if they differ by at most `tolerance` on every axis, in the mesh's
/// units, or are connected by others that do. Their position is the least in (x, y, z). Clusters longer than four
/// tolerances on an axis are left apart. Faces that lose a vertex stay, so triangles keep their order and number. The
/// distance is that of the new mesh. Throws Error(invalid_argument) for one < 0 or not finite, and if no face is left.
CLSDF_EXPORT Mesh weld(const Mesh& mesh, double tolerance);

/// The names that make_shape() accepts, each with a description of one line. Both functions are in clsdf::meshes.
struct ShapeName {
    std::string name;
    std::string description;
};
CLSDF_EXPORT std::vector<ShapeName> shape_names();

/// Meshes made by code, by the names that shape_names() lists: sphere0 to sphere9 (sphere6 is the paper's, 16,386
/// vertices), torus, knot, stairs and others. Throws Error(invalid_argument) that names the nearest one.
CLSDF_EXPORT Mesh make_shape(const std::string& name);

}  // namespace clsdf
