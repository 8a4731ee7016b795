#include "io/meshes/mesh_files.hpp"
#include "mesh/mesh_arrays.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace clsdf {

namespace {

using namespace std::string_view_literals;

// Binary: 80 bytes of anything, the number of triangles, and for each a normal, three vertices, and the number of bytes
// of its attributes. That is 0, or a colour; STL has no place for attributes.
constexpr std::size_t header_bytes = 84;
constexpr std::size_t count_offset = 80;
constexpr std::size_t triangle_bytes = 50;
constexpr std::size_t normal_bytes = 12;
constexpr std::size_t attribute_offset = 48;

std::optional<std::size_t> binary_triangle_count(const FileContent& file) {
    if (file.size() < header_bytes) return {};
    return load<std::uint32_t>(file.bytes().data() + count_offset, std::endian::little);
}

std::size_t binary_size(std::size_t triangle_count) {
    return header_bytes + triangle_count * triangle_bytes;
}

MeshArrays read_binary(const FileContent& file, std::size_t triangle_count, ReadingNotes& notes) {
    MeshArrays mesh;
    mesh.vertices.reserve(3 * triangle_count);
    mesh.triangles.reserve(triangle_count);
    const std::byte* address = file.bytes().data() + header_bytes + normal_bytes;
    for (std::size_t t = 0; t < triangle_count; ++t, address += triangle_bytes) {
        const auto first = static_cast<std::uint32_t>(mesh.vertices.size());
        for (std::size_t k = 0; k < 3; ++k) {
            Vec3 vertex;
            for (std::size_t axis = 0; axis < 3; ++axis)
                vertex[axis] = static_cast<double>(load<float>(address + 4 * (3 * k + axis), std::endian::little));
            mesh.vertices.push_back(vertex);
        }
        const Triangle triangle{first, first + 1, first + 2};
        if (notes.skip_bad_facets &&
            notes.skips_face_at(triangle, mesh.vertices, [&] { return fmt::format("triangle {}, counted from 0", t); }))
            mesh.vertices.resize(first);
        else
            mesh.triangles.push_back(triangle);
    }
    return mesh;
}

/// "the header claims 12 triangles, so the file should have 684 bytes, but it has 685"
std::string sizes_in_words(const FileContent& file, std::size_t triangle_count) {
    return fmt::format("the header claims {} triangle{}, so the file should have {} bytes, but it has {}",
                       triangle_count, triangle_count == 1 ? "" : "s", binary_size(triangle_count), file.size());
}

/// Whether the file is larger by just the bytes of attributes that its triangles claim: each triangle's behind it, or
/// all at the end.
bool has_attributes(const FileContent& file, std::size_t triangle_count) {
    for (const bool behind_each : {true, false}) {
        std::size_t offset = header_bytes, attributes = 0, t = 0;
        for (; t < triangle_count && offset + triangle_bytes <= file.size(); ++t) {
            const std::size_t bytes =
                load<std::uint16_t>(file.bytes().data() + offset + attribute_offset, std::endian::little);
            attributes += bytes;
            offset += triangle_bytes + (behind_each ? bytes : 0);
        }
        if (t == triangle_count && attributes > 0 && binary_size(triangle_count) + attributes == file.size())
            return true;
    }
    return false;
}

/// Why the corners cannot be those of a mesh, as if bytes had been lost or added among the triangles; empty if they
/// can.
std::string damage_in(const MeshArrays& mesh, const ReadingNotes& notes) {
    constexpr double most_edges = 1e6;
    std::vector<double> edges;
    edges.reserve(3 * mesh.triangles.size());
    Extent extent;
    for (const Triangle& triangle : mesh.triangles)
        for (std::size_t k = 0; k < 3; ++k) {
            const Vec3 &from = mesh.vertices[triangle[k]], &to = mesh.vertices[triangle[(k + 1) % 3]];
            extent.add(from);
            edges.push_back(std::hypot(to[0] - from[0], to[1] - from[1], to[2] - from[2]));
        }
    if (notes.bad_faces.count > 0 || !extent.is_finite()) return "corners are not finite";
    if (edges.empty()) return {};
    const auto middle = edges.begin() + static_cast<std::ptrdiff_t>(edges.size() / 2);
    std::ranges::nth_element(edges, middle);
    double side = 0;
    for (std::size_t axis = 0; axis < 3; ++axis) side = std::max(side, extent.box.upper[axis] - extent.box.lower[axis]);
    if (side <= most_edges * *middle) return {};
    return fmt::format("corners are up to {:.3g} apart, while the median edge has the length {:.3g}", side, *middle);
}

/// Some programs write bytes after the last triangle. Fewer than a triangle has: with room for another triangle the
/// count may be wrong.
MeshArrays read_binary_with_bytes_after(const FileContent& file, std::size_t triangle_count, ReadingNotes& notes) {
    MeshArrays mesh = read_binary(file, triangle_count, notes);
    if (const std::string damage = damage_in(mesh, notes); !damage.empty())
        throw Error(
            ErrorCode::unreadable_input,
            fmt::format("{}: {}, and {}: bytes were added or lost, as when a file is sent as text; get the file "
                        "again, as it was written",
                        file.path(), sizes_in_words(file, triangle_count), damage));
    notes.bytes_after = file.size() - binary_size(triangle_count);
    notes.last = "triangle";
    return mesh;
}

/// A text without what follows it: zeros and Ctrl-Z, which end texts of some systems or fill files up, and blanks.
struct Text {
    std::string_view text;
    std::size_t padding;  ///< zeros and Ctrl-Z

    explicit Text(std::string_view bytes) {
        constexpr std::string_view blanks_and_padding = "\0\x1A \t\v\f\r\n"sv;
        const std::size_t end = bytes.find_last_not_of(blanks_and_padding) + 1;
        padding = static_cast<std::size_t>(
            std::ranges::count_if(bytes.substr(end), [](char c) { return c == '\0' || c == '\x1A'; }));
        text = bytes.substr(0, end);
    }
};

/// Whether the bytes cannot be text: the header of a binary file may begin with "solid" as well, and the number of
/// triangles behind it has control characters.
bool is_binary(std::string_view bytes) {
    return !is_text(bytes.substr(0, header_bytes)) &&
           bytes.substr(0, telling_bytes).find('\0') != std::string_view::npos;
}

}  // namespace

bool has_size_of_binary_stl(const FileContent& file) {
    const std::optional<std::size_t> count = binary_triangle_count(file);
    return count && file.size() == binary_size(*count);
}

MeshArrays read_stl(const FileContent& file, ReadingNotes& notes) {
    const std::optional<std::size_t> count = binary_triangle_count(file);
    if (has_size_of_binary_stl(file)) return read_binary(file, *count, notes);
    const Text text(file.text());
    if (begins_as_text_of_stl(text.text, file.path()) && !is_binary(file.text())) {
        notes.padding = text.padding;
        return read_stl_text(text.text, file.path(), notes);
    }
    if (count && has_attributes(file, *count))
        throw Error(
            ErrorCode::unreadable_input,
            fmt::format("{}: {}: its triangles claim attributes of {} bytes in all, which STL has no place for; "
                        "export it without attributes, or as .ply",
                        file.path(), sizes_in_words(file, *count), file.size() - binary_size(*count)));
    if (count && file.size() > binary_size(*count) && file.size() - binary_size(*count) < triangle_bytes)
        return read_binary_with_bytes_after(file, *count, notes);
    if (file.size() == 0) throw Error(ErrorCode::unreadable_input, fmt::format("{}: the file is empty", file.path()));
    if (const std::string begin = quoted_begin(file); !begin.empty())
        throw Error(ErrorCode::unreadable_input,
                    fmt::format("{}: the file begins with {}; an STL file of text begins with 'solid', and the size of "
                                "this one, {} byte{}, is not that of a binary STL file",
                                file.path(), begin, file.size(), file.size() == 1 ? "" : "s"));
    if (!count)
        throw Error(
            ErrorCode::unreadable_input,
            fmt::format("{}: neither text that begins with 'solid' nor a binary STL file, whose header alone has "
                        "{} bytes; this file has {}",
                        file.path(), header_bytes, file.size()));
    throw Error(ErrorCode::unreadable_input, fmt::format("{}: {}", file.path(), sizes_in_words(file, *count)));
}

}  // namespace clsdf
