#pragma once

#include "core/large_memory.hpp"
#include "io/meshes/polygons.hpp"
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

/// What texts of STL have that differs from the format; each is read nevertheless.
enum class StlIrregularity {
    name_joined,           ///< "endsolidpart"
    end_missing,           ///< the text ends within a solid
    end_missing_between,   ///< "solid" within a solid
    end_without_solid,     ///< "endsolid" outside of solids
    facet_behind_name,     ///< on the line of "solid"
    normal_missing,        ///< "facet" alone, "facet normal" without numbers, or numbers without "normal"
    loop_without_facet,    ///< "outer loop" between facets
    end_of_facet_missing,  ///< the next facet, or the end of the solid, after "endloop"
    colour,                ///< "color 1 0 0"
    comment,               ///< from a word that begins with # to the end of the line
};
inline constexpr std::size_t stl_irregularities = 10;

/// Counts of the lines, faces and numbers that a reader skipped or changed.
struct ReadingNotes {
    bool skip_bad_facets = false;  ///< ReadOptions::skip_bad_facets: what the reader is asked to do

    struct Count {
        std::size_t count = 0;
        std::string first;  ///< the first place, "line 12"

        /// where: returns the place.
        template <typename Where>
        void add(const Where& where) {
            if (count++ == 0) first = where();
        }
    };

    Count bad_faces;      ///< with a vertex that does not exist or is not finite: skipped if asked for
    Count small_faces;    ///< faces of one or two corners: skipped
    Count weights;        ///< vertices of .obj with a fourth number other than 1: divided by it
    Count unknown_lines;  ///< lines of .obj whose keyword OBJ does not have: skipped
    Count header_lines;   ///< lines of a .ply header without a keyword: skipped
    std::array<Count, stl_irregularities> stl{};  ///< by StlIrregularity
    std::size_t padding = 0;                      ///< zeros and Ctrl-Z after the text of an .stl file: skipped
    UncutPolygons uncut;                          ///< divided as fans
    std::size_t bytes_after = 0;                  ///< the last row, or triangle, of a binary file: skipped
    const char* last = "row";                     ///< what bytes_after are after

    /// Counts a bad face that names a vertex that does not exist, by its number in the file.
    void skip_face(const std::string& place, std::int64_t missing_vertex);
    /// The same of one that has a vertex that is not finite.
    void skip_face(const std::string& place, const Vec3& vertex);

    /// Counts a bad face if one of these vertices is not finite, and returns whether. where: returns the place.
    template <typename Where>
    bool skips_face_at(std::span<const std::uint32_t> corners, std::span<const Vec3> vertices, const Where& where) {
        for (const std::uint32_t corner : corners)
            if (!is_finite(vertices[corner])) {
                skip_face(where(), vertices[corner]);
                return true;
            }
        return false;
    }
    std::string group_by;  ///< what the reader is asked for: as in ReadOptions

    /// A sentence for each kind that occurred, without the file's name.
    std::vector<std::string> texts() const;
};

/// The end of the message about a bad face.
inline constexpr const char* bad_facets_remedy =
    "; --skip-bad-facets (skip_bad_facets of the library's reading functions) leaves such faces out";

/// Throws Error(unreadable_input) that says what the file is and what to do if it is clearly not of this format: a
/// pointer of Git LFS, a web page, text in UTF-16, a compressed file, or a mesh of another format.
void refuse_other_content(const FileContent& file, MeshFormat format);

/// The same for files that hold no mesh, without other meshes. The first bytes are enough.
void refuse_other_content(const FileContent& file);
inline constexpr std::size_t telling_bytes = 4096;

/// "its 8 vertices are a cloud of points, ...", with what to do.
std::string cloud_of(std::size_t points);

/// Whether no byte is a control character other than blanks and line ends.
bool is_text(std::string_view bytes);

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
MeshArrays read_stl(const FileContent& file, ReadingNotes& notes);
/// The same of a text.
MeshArrays read_stl_text(std::string_view text, const std::string& path, ReadingNotes& notes);
/// Whether the text begins with "solid", after comments.
bool begins_as_text_of_stl(std::string_view text, const std::string& path);

}  // namespace clsdf
