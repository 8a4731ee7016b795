#pragma once

#include <clsdf/box.hpp>

#include <Eigen/Core>

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <type_traits>
#include <vector>

namespace clsdf {

/// Three vertex indices, counter-clockwise seen from outside.
using Triangle = std::array<std::uint32_t, 3>;

/// A triangle mesh in the caller's arrays; nothing is copied, and the arrays must outlive the view.
class MeshView {
public:
    /// `vertices`: x0 y0 z0 x1 y1 z1 ..., `triangles`: three indices a triangle. Throws Error(invalid_mesh) where a
    /// length is no multiple of three.
    MeshView(std::span<const double> vertices, std::span<const std::uint32_t> triangles);
    MeshView(std::span<const float> vertices, std::span<const std::uint32_t> triangles);
    MeshView(std::span<const Vec3> vertices, std::span<const Triangle> triangles);

    /// Eigen's matrices, maps and references: n x 3 and row-major, or 3 x n and column-major; vertices in double or
    /// float, indices in 32 bits. Another layout does not compile, because a view of its converted copy would dangle.
    /// Throws Error(invalid_argument) where the triples do not follow one another in memory.
    template <typename Vertices, typename Triangles>
    MeshView(const Eigen::MatrixBase<Vertices>& vertices, const Eigen::MatrixBase<Triangles>& triangles)
        : MeshView(numbers_of(vertices.derived()), indices_of(triangles.derived())) {}

    std::size_t vertex_count() const { return vertex_count_; }
    std::size_t triangle_count() const { return triangle_count_; }
    Vec3 vertex(std::size_t index) const;
    Triangle triangle(std::size_t index) const;

private:
    template <typename Matrix>
    static auto numbers_of(const Matrix& matrix) {
        static_assert((Matrix::IsRowMajor ? Matrix::ColsAtCompileTime : Matrix::RowsAtCompileTime) == 3,
                      "MeshView takes n x 3 row-major or 3 x n column-major matrices");
        using Scalar = typename Matrix::Scalar;
        if (matrix.size() > 0 && (matrix.innerStride() != 1 || matrix.outerStride() != 3)) throw_not_contiguous();
        return std::span<const Scalar>(matrix.data(), static_cast<std::size_t>(matrix.size()));
    }
    template <typename Matrix>
    static auto indices_of(const Matrix& matrix) {
        static_assert(std::is_integral_v<typename Matrix::Scalar> && sizeof(typename Matrix::Scalar) == 4,
                      "MeshView takes indices of 32 bits");
        const auto numbers = numbers_of(matrix);
        // A negative index becomes one that is out of range, which Mesh reports.
        return std::span(reinterpret_cast<const std::uint32_t*>(numbers.data()), numbers.size());
    }
    [[noreturn]] static void throw_not_contiguous();

    const double* double_vertices_ = nullptr;
    const float* float_vertices_ = nullptr;
    const std::uint32_t* triangles_ = nullptr;
    std::size_t vertex_count_ = 0;
    std::size_t triangle_count_ = 0;
};

/// An indexed triangle mesh in double precision, checked: it has a triangle, every index is in range, and every vertex
/// in use is finite. Everything else (degenerate faces, holes, any orientation, unused vertices) is allowed and
/// reported by describe_topology().
class Mesh {
public:
    /// Takes the arrays over. Throws Error(invalid_mesh) that names `name`, the element and the value.
    Mesh(std::vector<Vec3> vertices, std::vector<Triangle> triangles, std::string name = "mesh");
    /// Copies the caller's arrays.
    explicit Mesh(const MeshView& view, std::string name = "mesh");

    const std::vector<Vec3>& vertices() const { return vertices_; }
    const std::vector<Triangle>& triangles() const { return triangles_; }
    const std::string& name() const { return name_; }

    /// The box of the vertices in use.
    const Box& box() const { return box_; }

private:
    std::vector<Vec3> vertices_;
    std::vector<Triangle> triangles_;
    std::string name_;
    Box box_;
};

/// Reads .off, .obj, .stl (ASCII and binary) or .ply (ASCII and binary, both byte orders); polygons are triangulated as
/// fans, and a soup (STL) is welded by equal coordinates. Throws Error(unreadable_input or invalid_mesh) that names the
/// file, the line or element and the value.
Mesh read_mesh(const std::string& path);

/// Red, green and blue, sRGB.
using FaceColour = std::array<std::uint8_t, 3>;

/// Writes .off, .obj, .stl (binary) or .ply (binary, little endian) by the file's ending; complete or not at all.
/// `colours`: of each triangle, or none; .ply keeps them, the others have no place for them. Throws
/// Error(invalid_argument) for another number of them.
void write_mesh(const Mesh& mesh, const std::string& path, std::span<const FaceColour> colours = {});

/// The mesh with vertices of equal coordinates made one; triangles keep their order and number.
Mesh weld(const Mesh& mesh);

}  // namespace clsdf
