#include "mesh/byte_order.hpp"
#include "mesh/mesh_readers.hpp"
#include "mesh/text_scanner.hpp"

#include <fmt/format.h>

#include <cmath>
#include <cstdint>
#include <optional>

namespace clsdf {

namespace {

// Binary: 80 bytes of anything, the number of triangles, and for each a normal, three vertices and two more bytes.
constexpr std::size_t header_bytes = 84;
constexpr std::size_t count_offset = 80;
constexpr std::size_t triangle_bytes = 50;
constexpr std::size_t normal_bytes = 12;

std::optional<std::size_t> binary_triangle_count(const FileContent& file) {
    if (file.size() < header_bytes) return {};
    return load<std::uint32_t>(file.bytes().data() + count_offset, std::endian::little);
}

bool starts_with_solid(const FileContent& file) {
    TextScanner scanner(file.text(), file.path(), {});
    return equals_ignoring_case(scanner.word_of_text(), "solid");
}

MeshArrays read_binary(const FileContent& file, std::size_t triangle_count) {
    MeshArrays mesh;
    mesh.vertices.reserve(3 * triangle_count);
    mesh.triangles.reserve(triangle_count);
    const std::byte* address = file.bytes().data() + header_bytes + normal_bytes;
    for (std::size_t t = 0; t < triangle_count; ++t, address += triangle_bytes) {
        for (std::size_t k = 0; k < 3; ++k) {
            Vec3 vertex;
            for (std::size_t axis = 0; axis < 3; ++axis)
                vertex[axis] = double{load<float>(address + 4 * (3 * k + axis), std::endian::little)};
            mesh.vertices.push_back(vertex);
        }
        const auto first = static_cast<std::uint32_t>(3 * t);
        mesh.triangles.push_back({first, first + 1, first + 2});
    }
    return mesh;
}

void expect(TextScanner& scanner, std::string_view keyword) {
    const std::string_view word = scanner.word_of_text();
    if (!equals_ignoring_case(word, keyword)) scanner.fail_word(fmt::format("'{}'", keyword).c_str(), word);
}

/// What lies between "facet" and "endfacet".
void read_facet(TextScanner& scanner, MeshArrays& mesh) {
    expect(scanner, "normal");
    // The normal follows from the vertices, and is written as NaN for faces without area.
    for (int k = 0; k < 3; ++k)
        if (scanner.word_of_text().empty()) scanner.fail_word("a normal", {});
    expect(scanner, "outer");
    expect(scanner, "loop");
    const std::size_t first = mesh.vertices.size();
    for (;;) {
        const std::string_view word = scanner.word_of_text();
        if (equals_ignoring_case(word, "endloop")) break;
        if (!equals_ignoring_case(word, "vertex")) scanner.fail_word("'vertex' or 'endloop'", word);
        Vec3 vertex;
        for (double& coordinate : vertex) {
            coordinate = scanner.real("a coordinate");
            if (!std::isfinite(coordinate))
                scanner.fail(ErrorCode::invalid_mesh, fmt::format("a coordinate is not finite: {}", coordinate));
        }
        mesh.vertices.push_back(vertex);
    }
    const std::size_t corners = mesh.vertices.size() - first;
    if (corners < 3) scanner.fail(fmt::format("a facet needs three vertices or more, not {}", corners));
    for (std::size_t k = 2; k < corners; ++k)
        mesh.triangles.push_back({static_cast<std::uint32_t>(first), static_cast<std::uint32_t>(first + k - 1),
                                  static_cast<std::uint32_t>(first + k)});
    expect(scanner, "endfacet");
}

MeshArrays read_ascii(const FileContent& file) {
    TextScanner scanner(file.text(), file.path(), {});
    MeshArrays mesh;
    // A file may hold several solids; the rest of the lines "solid" and "endsolid" is a name.
    while (scanner.next_line()) {
        expect(scanner, "solid");
        scanner.next_line();
        for (;;) {
            const std::string_view word = scanner.word_of_text();
            if (equals_ignoring_case(word, "endsolid")) break;
            if (!equals_ignoring_case(word, "facet")) scanner.fail_word("'facet' or 'endsolid'", word);
            read_facet(scanner, mesh);
        }
    }
    return mesh;
}

}  // namespace

MeshArrays read_stl(const FileContent& file) {
    // The size tells, because the header of a binary file may begin with "solid" as well.
    const std::optional<std::size_t> count = binary_triangle_count(file);
    if (count && file.size() == header_bytes + *count * triangle_bytes) return read_binary(file, *count);
    const bool has_zero_byte = file.text().substr(0, 4096).find('\0') != std::string_view::npos;
    if (starts_with_solid(file) && !has_zero_byte) return read_ascii(file);
    if (file.size() == 0) throw Error(ErrorCode::unreadable_input, fmt::format("{}: the file is empty", file.path()));
    if (!count)
        throw Error(
            ErrorCode::unreadable_input,
            fmt::format("{}: neither text that begins with 'solid' nor a binary STL file, whose header alone has "
                        "{} bytes; this file has {}",
                        file.path(), header_bytes, file.size()));
    throw Error(ErrorCode::unreadable_input,
                fmt::format("{}: the header claims {} triangles, so the file should have {} bytes, but it has {}",
                            file.path(), *count, header_bytes + *count * triangle_bytes, file.size()));
}

}  // namespace clsdf
