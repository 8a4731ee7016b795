#pragma once

#include <clsdf/export.hpp>
#include <clsdf/mesh.hpp>

#include <array>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <ranges>
#include <type_traits>

typedef struct _cl_mem* cl_mem;

namespace clsdf {

/// Beyond the band.
inline constexpr std::uint32_t no_triangle = 0xFFFFFFFFU;
inline constexpr std::uint8_t no_site = 255;

/// Outputs beside the distance. All outputs of a sample belong to one nearest triangle and one of its sites;
/// docs/library.md defines each.
struct Outputs {
    bool triangle = false;     ///< the nearest triangle; if an edge or a vertex is nearest, the lowest that shares it
    bool site = false;         ///< its nearest part: 0 to 2 its vertices, 3 to 5 its edges, 6 its face
    bool closest = false;      ///< the closest point
    bool gradient = false;     ///< of the signed distance: a unit vector
    bool barycentric = false;  ///< coordinates of the closest point on the triangle

    bool operator==(const Outputs&) const = default;
};

/// One member for each output: Of<Element>, Element being the type of the output's elements. The components of a vector
/// lie side by side. Beyond the band, the triangle is no_triangle, the site no_site, and vectors are NaN.
template <template <typename Element> class Of>
struct PerOutput {
    Of<float> distance{};          ///< signed, in the mesh's units
    Of<std::uint32_t> triangle{};  ///< in the caller's order
    Of<std::uint8_t> site{};
    Of<double> closest{};     ///< three coordinates, in the mesh's units
    Of<float> gradient{};     ///< three components
    Of<float> barycentric{};  ///< two: the weights of the triangle's vertices 1 and 2
};

namespace detail {
template <typename Element>
using CountOf = std::size_t;
}

/// Bytes of a sample in fields and in files.
inline constexpr PerOutput<detail::CountOf> output_bytes{sizeof(float),        sizeof(std::uint32_t),
                                                         sizeof(std::uint8_t), 3 * sizeof(double),
                                                         3 * sizeof(float),    2 * sizeof(float)};

/// Calls visit(name, a.triangle, b.triangle, ...), and so on for each output but the distance.
template <typename Visit, typename... Sets>
void visit_extras(const Visit& visit, Sets&&... sets) {
    visit("triangle", sets.triangle...);
    visit("site", sets.site...);
    visit("closest", sets.closest...);
    visit("gradient", sets.gradient...);
    visit("barycentric", sets.barycentric...);
}

/// The same for the distance, first, and the others.
template <typename Visit, typename... Sets>
void visit_outputs(const Visit& visit, Sets&&... sets) {
    visit("distance", sets.distance...);
    visit_extras(visit, sets...);
}

/// The destination of an output: memory of the caller, on the host or on the device.
///
/// The elements are those of PerOutput. The distance may also be stored as doubles: they have the values of the floats,
/// and cost a copy. Gradients and barycentric coordinates may also be stored as doubles, which are evaluated in double.
/// The closest point may also be stored as floats: then it is the offset from the sample, whose accuracy does not
/// depend on the size of the coordinates. Other elements are Error(unsupported).
///
/// Samples are packed with x fastest unless strides are given. No two values may overlap: each stride must be at least
/// the span of all shorter strides. Strides cost a copy of the field. Memory between the samples is not changed.
struct OutputTarget {
    enum class Element : std::uint8_t { automatic, float32, float64, uint32, uint8, other };

    void* host = nullptr;
    cl_mem device = nullptr;
    std::size_t bytes = 0;  ///< of host memory: exactly the output's, or with offset or strides at least all addressed
    Element element = Element::automatic;
    /// Bytes before the first sample, a multiple of the element's. In memory of the device, an offset that is no
    /// multiple of what buffers are aligned to (CL_DEVICE_MEM_BASE_ADDR_ALIGN / 8) costs a copy of the field.
    std::size_t offset = 0;
    /// Bytes from a sample to the next one along x, y and z; zeros: packed.
    std::array<std::ptrdiff_t, 3> strides{};
    /// Bytes from a component to the next one; 0: side by side. If it is set and `strides` are not, the samples' first
    /// components lie side by side.
    std::ptrdiff_t component_stride = 0;

    OutputTarget() = default;
    /// An array of the caller's. A temporary container does not compile.
    template <std::ranges::contiguous_range Array>
    requires(!detail::DyingArray<Array> &&
             !std::is_const_v<std::remove_reference_t<std::ranges::range_reference_t<Array>>>)
        // NOLINTNEXTLINE(google-explicit-constructor,bugprone-forwarding-reference-overload): any array is a target
        OutputTarget(Array&& array)
        : host(std::ranges::data(array)),
          bytes(std::ranges::size(array) * sizeof(std::ranges::range_value_t<Array>)),
          element(element_of<std::ranges::range_value_t<Array>>()) {}
    template <detail::DyingArray Array>
    // NOLINTNEXTLINE(google-explicit-constructor,bugprone-forwarding-reference-overload): as above
    OutputTarget(Array&& array) = delete;
    /// Memory of the device, a buffer.
    // NOLINTNEXTLINE(google-explicit-constructor): a buffer is a target
    OutputTarget(cl_mem memory, Element element_in = Element::automatic) : device(memory), element(element_in) {}

    bool is_given() const { return host != nullptr || device != nullptr; }

private:
    template <typename Value>
    static constexpr Element element_of() {
        if constexpr (std::same_as<Value, float>) return Element::float32;
        if constexpr (std::same_as<Value, double>) return Element::float64;
        if constexpr (std::same_as<Value, std::uint32_t>) return Element::uint32;
        if constexpr (std::same_as<Value, std::uint8_t>) return Element::uint8;
        return Element::other;
    }
};

namespace detail {
template <typename Element>
using TargetOf = OutputTarget;
}

/// The destinations of a computation's outputs. The distance needs one; another output without one is not computed.
using OutputTargets = PerOutput<detail::TargetOf>;

}  // namespace clsdf
