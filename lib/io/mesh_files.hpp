#pragma once

#include "core/uninitialized_vector.hpp"
#include "mesh/mesh_arrays.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstring>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

namespace clsdf {

/// The content of a regular file, in memory.
class FileContent {
public:
    /// Throws Error(unreadable_input) if the file cannot be read or is a folder, a pipe or a device.
    explicit FileContent(std::string path);

    const std::string& path() const { return path_; }
    std::size_t size() const { return bytes_.size(); }
    std::string_view text() const { return {bytes_.data(), bytes_.size()}; }
    std::span<const std::byte> bytes() const { return std::as_bytes(std::span(bytes_)); }

private:
    std::string path_;
    UninitializedVector<char> bytes_;
};

/// Reads a number at this address in the given byte order.
template <typename Number>
Number load(const std::byte* address, std::endian order) {
    static_assert(std::is_arithmetic_v<Number>);
    std::array<std::byte, sizeof(Number)> bytes{};
    std::memcpy(bytes.data(), address, sizeof(Number));
    if (order != std::endian::native) std::reverse(bytes.begin(), bytes.end());
    return std::bit_cast<Number>(bytes);
}

/// The inverse of load() with the order little endian; returns the address after the number.
template <typename Number>
std::byte* store_little_endian(std::byte* address, Number number) {
    auto bytes = std::bit_cast<std::array<std::byte, sizeof(Number)>>(number);
    if (std::endian::native != std::endian::little) std::reverse(bytes.begin(), bytes.end());
    std::memcpy(address, bytes.data(), sizeof(Number));
    return address + sizeof(Number);
}

enum class MeshFormat { off, obj, stl, ply };

/// The format that the file's ending stands for, in upper or lower case. Throws Error(unsupported) that lists the
/// endings there are.
MeshFormat format_of_ending(const std::string& path);

/// One reader per format. Each throws Error(unreadable_input) if the file is truncated or malformed, with the line or
/// the element and what was found there, and Error(invalid_mesh) if an index is out of range. Counts in a header are
/// compared with the file's size before memory is allocated.
MeshArrays read_off(const FileContent& file);
MeshArrays read_obj(const FileContent& file);
MeshArrays read_ply(const FileContent& file);

/// The vertices alone; the file need not have faces.
std::vector<Vec3> read_ply_points(const FileContent& file);

/// Adds a triangle with three vertices of its own.
MeshArrays read_stl(const FileContent& file);

}  // namespace clsdf
