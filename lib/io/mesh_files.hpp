#pragma once

#include "core/large_memory.hpp"
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

/// Reads a text in memory word by word, and counts lines. Lines end with LF, CR LF, LF CR or CR.
class TextScanner {
public:
    struct Syntax {
        bool hash_comments = false;      ///< from # to the end of the line
        bool line_continuation = false;  ///< a backslash at the end of a line joins it to the next one
    };

    /// Neither the text nor the path is copied.
    TextScanner(std::string_view text, const std::string& path, Syntax syntax, std::size_t first_line = 1);

    /// Skips the rest of this line and any empty ones; false if no line is left. Before the first call the scanner
    /// stands before the first line.
    bool next_line();

    /// next_line() before the first line. Throws Error(unreadable_input) if no line has text.
    void first_line();

    /// The next word of this line; empty at its end.
    std::string_view word();

    /// Skips letters with which the next word of this line begins.
    void skip(std::size_t letters);

    /// The next word of the text, on this line or a later one; empty at the end of the text.
    std::string_view word_of_text();

    /// The next word of this line as a number; `what` describes it in messages. Infinity and NaN are numbers; a number
    /// too large for a double is infinite.
    double real(const char* what);
    /// The same of a word that has been taken.
    double real_in(std::string_view word, const char* what) const;
    std::int64_t integer(const char* what);

    bool at_end_of_line();

    /// Skips the end of the line if it comes next, and nothing after it. Returns false if another character comes next.
    bool end_line();

    /// The number of the line that the last word came from.
    std::size_t line() const { return line_; }

    /// The bytes after the last word.
    std::size_t remaining() const { return static_cast<std::size_t>(end_ - position_); }

    /// Throws Error(unreadable_input) with the file and the line.
    [[noreturn]] void fail(const std::string& reason) const;
    [[noreturn]] void fail(ErrorCode code, const std::string& reason) const;
    [[noreturn]] void fail_word(const char* what, std::string_view word) const;

private:
    void skip_blanks();
    void skip_line_end();
    std::size_t line_end_length() const;

    const char* position_;
    const char* end_;
    const std::string* path_;
    Syntax syntax_;
    std::size_t line_;
    bool before_first_line_ = true;
};

/// Whether the words agree but for upper and lower case; `lower` is in lower case.
bool equals_ignoring_case(std::string_view word, std::string_view lower);

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

/// What a reader skipped or changed.
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
