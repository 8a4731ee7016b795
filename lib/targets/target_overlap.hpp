#pragma once

#include <clsdf/mesh.hpp>
#include <clsdf/outputs.hpp>

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

namespace clsdf::targets {

/// Bytes of the caller's memory that nothing else of the call may lie on: an array to which a call writes, or one that
/// it reads while it writes.
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
    const char* name = nullptr;  ///< for messages, of an array that is not that of an output
};

/// Two arrays that have a byte in common.
struct Overlap {
    const WrittenArray* one = nullptr;
    const WrittenArray* other = nullptr;
    bool is_certain = true;
};

/// An overlap, if there is one. Arrays of which each value lies between values of the other are told exactly if they
/// have the same strides, as boxes and components of one large array have. For others with interleaved values the
/// search has a limit; an overlap beyond it is not certain.
std::optional<Overlap> find_overlap(const std::vector<WrittenArray>& arrays);

/// Throws Error(invalid_argument) that names both arrays.
[[noreturn]] void throw_overlap(const Overlap& overlap);

/// Refuses a certain overlap.
void refuse_overlap(const std::vector<WrittenArray>& arrays);

}  // namespace clsdf::targets
