#pragma once

#include <clsdf/arrays.hpp>
#include <clsdf/error.hpp>
#include <clsdf/mesh.hpp>

#include "core/parallel.hpp"
#include "core/refuse.hpp"

#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <initializer_list>
#include <span>
#include <string>
#include <utility>
#include <vector>

/// The caller's arrays of positions and triangles. An item has three numbers, at any distance from each other.
namespace clsdf {

enum class ArrayKind { positions, indices };

/// Bytes [begin, end) of memory.
struct ByteRange {
    std::size_t begin = 0;
    std::size_t end = 0;

    bool is_empty() const { return begin == end; }
};

/// Throws Error(code) if numbers have another type than the kind, strides are no multiples of a number's bytes, or host
/// memory is missing or too small. what: the name in messages, a plural.
void check_array(const InputArray& triples, ArrayKind kind, const char* what, ErrorCode code);

/// Values on an axis of an array.
struct ArrayAxis {
    std::ptrdiff_t stride;
    double count;
};
/// Where the values of an array begin and end, in bytes of its memory. In double, which no sum of such products
/// overflows.
std::pair<double, double> extent_of(const ArrayLayout& array, std::initializer_list<ArrayAxis> axes);

/// The bytes that triples take of `bytes` bytes of memory. Throws as check_array() does.
ByteRange range_of(const InputArray& triples, std::size_t bytes, const char* what, ErrorCode code);

/// Strides in bytes; 0 is replaced by the packed stride.
struct Steps {
    std::ptrdiff_t triple = 0;
    std::ptrdiff_t number = 0;
    std::ptrdiff_t width = 0;  ///< of a number
};

inline Steps steps_of(const InputArray& triples) {
    const auto width = static_cast<std::ptrdiff_t>(bytes_of(triples.type));
    const std::ptrdiff_t number = triples.component_stride != 0 ? triples.component_stride : width;
    // Components that lie elsewhere leave no room between the items.
    return {triples.strides[0] != 0 ? triples.strides[0] : number == width ? 3 * width : width, number, width};
}

/// Throws Error(unsupported) for memory of the device.
inline const std::byte* first_of(const InputArray& triples) {
    if (triples.device != nullptr)
        refuse_unsupported(
            "these arrays of a mesh are memory of the device, which this call cannot read; make a transform of "
            "them, or give arrays of the host");
    return static_cast<const std::byte*>(triples.host) + triples.offset;
}

/// The three numbers of the item at an address.
template <typename Number>
std::array<Number, 3> read_triple(const std::byte* at, const Steps& steps) {
    std::array<Number, 3> numbers;
    for (std::size_t k = 0; k < 3; ++k)
        std::memcpy(&numbers[k], at + static_cast<std::ptrdiff_t>(k) * steps.number, sizeof(Number));
    return numbers;
}

template <typename Number>
std::array<Number, 3> triple_of(const InputArray& triples, std::size_t i) {
    const Steps steps = steps_of(triples);
    return read_triple<Number>(first_of(triples) + static_cast<std::ptrdiff_t>(i) * steps.triple, steps);
}

/// Calls f(index, numbers) for each triple, on all cores.
template <typename Number, typename Function>
void for_each_triple(const InputArray& triples, const Function& f) {
    if (triples.count == 0) return;
    const std::byte* const first = first_of(triples);
    const Steps steps = steps_of(triples);
    for_each_index(triples.count, [&](std::size_t i) {
        f(i, read_triple<Number>(first + static_cast<std::ptrdiff_t>(i) * steps.triple, steps));
    });
}

/// Copies of what host memory has. Throw Error(unsupported) for memory of the device, and Error(invalid_mesh) that
/// names the triangle of an index that 32 bits cannot hold.
std::vector<Vec3> read_positions(const InputArray& positions);
std::vector<Triangle> read_triangles(const InputArray& triangles, const std::string& mesh_name);

/// Positions in host memory, in the caller's array if it is one of Vec3, else in a copy.
class PositionArray {
public:
    explicit PositionArray(const InputArray& positions);
    PositionArray(const PositionArray&) = delete;
    PositionArray& operator=(const PositionArray&) = delete;

    std::span<const Vec3> get() const { return array_; }

private:
    std::vector<Vec3> copy_;
    std::span<const Vec3> array_;
};

}  // namespace clsdf
