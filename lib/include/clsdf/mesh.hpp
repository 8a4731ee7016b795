#pragma once

#include <clsdf/export.hpp>

#include <array>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <initializer_list>
#include <optional>
#include <ranges>
#include <string>
#include <tuple>
#include <type_traits>
#include <vector>

typedef struct _cl_mem* cl_mem;

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

/// The type of numbers in the caller's memory. Signed integers count as unsigned ones: a negative index is out of
/// range.
enum class NumberType : std::uint8_t { float32, float64, uint32, uint64 };

namespace detail {
/// The type of the numbers of an array's elements, which are numbers or triples of numbers.
template <typename Value>
constexpr std::optional<NumberType> number_type() {
    if constexpr (std::is_same_v<Value, float>) return NumberType::float32;
    if constexpr (std::is_same_v<Value, double>) return NumberType::float64;
    if constexpr (std::is_integral_v<Value>) {
        if constexpr (sizeof(Value) == 4) return NumberType::uint32;
        if constexpr (sizeof(Value) == 8) return NumberType::uint64;
    }
    if constexpr (requires {
                      typename Value::value_type;
                      std::tuple_size<Value>::value;
                  })
        if constexpr (std::tuple_size_v<Value> == 3) return number_type<typename Value::value_type>();
    return std::nullopt;
}

/// Arrays of numbers, or of triples of numbers.
template <typename Array>
concept NumberArray = std::ranges::contiguous_range<Array> && number_type<std::ranges::range_value_t<Array>>()
.has_value();

/// A temporary that owns its elements: a view of it would dangle. Views such as std::span own none. The elements of an
/// initializer list live until the end of the calling expression.
template <typename Array>
concept DyingArray =
    std::ranges::contiguous_range<Array> && !std::ranges::borrowed_range<Array> &&
    !std::same_as<std::remove_cvref_t<Array>, std::initializer_list<std::ranges::range_value_t<Array>>>;
}  // namespace detail

/// Triples of numbers in the caller's memory, on the host or on the device: positions (x, y, z), or the vertex indices
/// of triangles. Nothing is copied; the memory must outlive the use.
struct Triples {
    const void* host = nullptr;
    cl_mem device = nullptr;  ///< a buffer that the host may read (not CL_MEM_HOST_NO_ACCESS, CL_MEM_HOST_WRITE_ONLY)
    std::size_t count = 0;    ///< of triples
    NumberType type = NumberType::float64;
    /// Bytes before the first triple. Like the strides a multiple of a number's bytes.
    std::size_t offset = 0;
    std::ptrdiff_t stride = 0;         ///< bytes from a triple to the next one, also negative; 0: side by side
    std::ptrdiff_t number_stride = 0;  ///< bytes from a number of a triple to its next; 0: side by side
    std::size_t bytes = unknown_size;  ///< that host memory holds; if unknown, it must hold all that is addressed

    static constexpr std::size_t unknown_size = static_cast<std::size_t>(-1);

    Triples() = default;
    /// An array of triples (Vec3, Triangle, any std::array of three numbers), or of three numbers a triple. A temporary
    /// container does not compile: give it a name that lives as long as this.
    template <detail::NumberArray Array>
    // NOLINTNEXTLINE(google-explicit-constructor,bugprone-forwarding-reference-overload): any array of numbers
    Triples(Array&& array)
        : host(std::ranges::data(array)),
          type(*detail::number_type<std::ranges::range_value_t<Array>>()),
          bytes(std::ranges::size(array) * sizeof(std::ranges::range_value_t<Array>)) {
        count = bytes / (3 * number_bytes());
    }
    template <detail::NumberArray Array>
    requires detail::DyingArray<Array>
    // NOLINTNEXTLINE(google-explicit-constructor,bugprone-forwarding-reference-overload): as above
    Triples(Array&& array)
    = delete;
    /// Numbers at any distance from each other, for instance four floats a triple, or all x before all y.
    template <typename Value>
    requires(detail::number_type<Value>().has_value())
        Triples(const Value* first, std::size_t count_in, std::ptrdiff_t stride_in = 0,
                std::ptrdiff_t number_stride_in = 0)
        : host(first),
          count(count_in),
          type(*detail::number_type<Value>()),
          stride(stride_in),
          number_stride(number_stride_in) {}
    /// Memory of the device, a buffer.
    Triples(cl_mem memory, NumberType type_in, std::size_t count_in) : device(memory), count(count_in), type(type_in) {}

    std::size_t number_bytes() const { return type == NumberType::float64 || type == NumberType::uint64 ? 8 : 4; }
};

/// A triangle mesh in the caller's arrays; nothing is copied, and the arrays must outlive the view. mesh_view() of
/// clsdf/eigen.hpp makes one of Eigen's matrices.
class CLSDF_EXPORT MeshView {
public:
    /// Vertices are floats or doubles, triangles are indices of 32 or 64 bits. Throws Error(invalid_mesh) for other
    /// types, if an array of numbers has a length that is no multiple of three, or if host memory of known size is too
    /// small.
    MeshView(const Triples& vertices, const Triples& triangles);

    const Triples& vertices() const { return vertices_; }
    const Triples& triangles() const { return triangles_; }

private:
    Triples vertices_;
    Triples triangles_;
};

namespace polyhedra {
struct PartMaker;
}

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
    void move(std::vector<Vec3> vertices);

    const std::vector<Vec3>& vertices() const { return vertices_; }
    const std::vector<Triangle>& triangles() const { return triangles_; }
    const std::string& name() const { return name_; }

    /// The box of the vertices in use.
    const Box& box() const { return box_; }

private:
    friend struct polyhedra::PartMaker;
    std::vector<Vec3> vertices_;
    std::vector<Triangle> triangles_;
    std::string name_;
    Box box_;
};

/// The mesh in which vertices of equal coordinates are one vertex; triangles keep their order and number.
CLSDF_EXPORT Mesh weld(const Mesh& mesh);

/// The names that make_shape() accepts, each with a description of one line.
struct ShapeName {
    std::string name;
    std::string description;
};
CLSDF_EXPORT std::vector<ShapeName> shape_names();

/// Meshes made by code, by the names that shape_names() lists: sphere0 to sphere9 (sphere6 is the paper's, 16,386
/// vertices), torus, knot, stairs and others. Throws Error(invalid_argument) that names the nearest one.
CLSDF_EXPORT Mesh make_shape(const std::string& name);

}  // namespace clsdf
