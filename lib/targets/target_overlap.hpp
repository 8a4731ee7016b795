#pragma once

#include <clsdf/mesh.hpp>
#include <clsdf/outputs.hpp>

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace clsdf::targets {

/// The bytes to which a call writes one output of one request.
struct WrittenArray {
    const void* memory = nullptr;  ///< a buffer of the device; null: the host's memory
    std::uint64_t first = 0;       ///< byte of the first value: in the buffer, or its address
    std::size_t width = 0;         ///< bytes of a value
    Index3 size{1, 1, 1};
    std::array<std::ptrdiff_t, 3> strides{};
    std::size_t components = 1;
    std::ptrdiff_t component_stride = 0;
    Output output = Output::distance;
    std::size_t request = 0;
};

/// Throws Error(invalid_argument) that names two arrays if they have a byte in common. Arrays of which each value lies
/// between values of the other are told exactly if they have the same strides, as boxes and components of one large
/// array have. For others with interleaved values the search has a limit; beyond it they count as disjoint.
void refuse_overlap(const std::vector<WrittenArray>& arrays);

}  // namespace clsdf::targets
