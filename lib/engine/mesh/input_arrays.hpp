#pragma once

#include <clsdf/error.hpp>
#include <clsdf/mesh.hpp>

#include <cstddef>
#include <cstdint>
#include <initializer_list>
#include <span>
#include <string>
#include <utility>
#include <vector>

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
