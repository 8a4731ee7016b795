#pragma once

#include "core/large_memory.hpp"
#include "io/meshes/text_scanner.hpp"
#include "mesh/mesh_arrays.hpp"

#include <clsdf/error.hpp>

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <limits>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

namespace clsdf {

/// The content of a regular file, in memory.
class FileContent {
public:
    /// most_bytes: of the begin of the file. Throws Error(unreadable_input) if the file cannot be read or is a folder,
    /// a pipe or a device.
    explicit FileContent(std::string path, std::size_t most_bytes = std::numeric_limits<std::size_t>::max());

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

/// ".off", ".obj", ".stl" or ".ply".
const char* ending_of(MeshFormat format);

/// Counts of the lines, faces and numbers that a reader skipped or changed.
struct ReadingNotes {
    struct Count {
        std::size_t count = 0;
        std::string first;  ///< the first place, "line 12"

        /// where: returns the place.
        template <typename Where>
        void add(const Where& where) {
            if (count++ == 0) first = where();
        }
    };

    Count small_faces;            ///< faces of one or two corners: skipped
    Count weights;                ///< vertices of .obj with a fourth number other than 1: divided by it
    Count unknown_lines;          ///< lines of .obj whose keyword OBJ does not have: skipped
    Count header_lines;           ///< lines of a .ply header without a keyword: skipped
    std::size_t bytes_after = 0;  ///< the last row of a binary .ply file: skipped

    std::string group_by;  ///< what the reader is asked for: as in ReadOptions

    /// A sentence for each kind that occurred, without the file's name.
    std::vector<std::string> texts() const;
};

/// Throws Error(unreadable_input) that says what the file is and what to do if it is clearly not of this format: a
/// pointer of Git LFS, a web page, text in UTF-16, a compressed file, or a mesh of another format.
void refuse_other_content(const FileContent& file, MeshFormat format);

/// The same for files that hold no mesh, without other meshes. The first bytes are enough.
void refuse_other_content(const FileContent& file);
inline constexpr std::size_t telling_bytes = 4096;

/// The first line of a text for a message, in quotes. Empty if the file does not begin with text.
std::string quoted_begin(const FileContent& file);

/// Whether the size of the file is that of a binary STL file with the number of triangles that its header claims.
bool has_size_of_binary_stl(const FileContent& file);

/// The format that the file's ending stands for, in upper or lower case. Throws Error(unsupported) that lists the
/// endings there are.
MeshFormat format_of_ending(const std::string& path);

/// One reader per format. Each throws Error(unreadable_input) if the file is truncated or malformed, with the line or
/// the element and what was found there, and Error(invalid_mesh) if an index is out of range. Counts in a header are
/// compared with the file's size before memory is allocated.
MeshArrays read_off(const FileContent& file, ReadingNotes& notes);
MeshArrays read_obj(const FileContent& file, ReadingNotes& notes);
MeshArrays read_ply(const FileContent& file, ReadingNotes& notes);

/// The vertices alone; the file need not have faces.
std::vector<Vec3> read_ply_points(const FileContent& file, ReadingNotes& notes);

/// Adds a triangle with three vertices of its own.
MeshArrays read_stl(const FileContent& file);

}  // namespace clsdf
