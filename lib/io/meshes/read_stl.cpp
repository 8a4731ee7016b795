#include "core/large_memory.hpp"
#include "core/parallel.hpp"
#include "io/meshes/face_groups.hpp"
#include "io/meshes/mesh_files.hpp"
#include "io/meshes/polygons.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstdint>
#include <numeric>
#include <optional>
#include <utility>
#include <vector>

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

void expect(TextScanner& scanner, std::string_view keyword) {
    const std::string_view word = scanner.word_of_text();
    if (!equals_ignoring_case(word, keyword)) scanner.fail_word(fmt::format("'{}'", keyword).c_str(), word);
}

/// Takes the second word of "end loop", "end facet" or "end solid", if the first is "end". Returns "endloop" etc. in
/// this and the usual spelling, and any other word as it is.
std::string_view joined_end(TextScanner& scanner, std::string_view word) {
    if (!equals_ignoring_case(word, "end")) return word;
    TextScanner ahead = scanner;
    const std::string_view second = ahead.word_of_text();
    for (const std::string_view keyword : {"endloop", "endfacet", "endsolid"})
        if (equals_ignoring_case(second, keyword.substr(3))) {
            scanner = ahead;
            return keyword;
        }
    return word;
}

/// Reads the text between "facet" and "endfacet". notes: to skip bad facets, if that is asked for; else null.
void read_facet(TextScanner& scanner, MeshArrays& mesh, UncutPolygons& uncut, ReadingNotes* notes) {
    const std::size_t facet_line = scanner.line();
    expect(scanner, "normal");
    // The normal follows from the vertices, and is written as NaN for faces without area.
    for (int k = 0; k < 3; ++k)
        if (scanner.word_of_text().empty()) scanner.fail_word("a normal", {});
    expect(scanner, "outer");
    expect(scanner, "loop");
    const std::size_t first = mesh.vertices.size();
    std::optional<Vec3> bad;
    for (;;) {
        const std::string_view word = joined_end(scanner, scanner.word_of_text());
        if (equals_ignoring_case(word, "endloop")) break;
        if (!equals_ignoring_case(word, "vertex")) scanner.fail_word("'vertex' or 'endloop'", word);
        Vec3 vertex;
        for (double& coordinate : vertex) {
            coordinate = scanner.real("a coordinate");
            if (!std::isfinite(coordinate) && notes == nullptr)
                scanner.fail(ErrorCode::invalid_mesh,
                             fmt::format("a coordinate is not finite: {}{}", coordinate, bad_facets_remedy));
        }
        mesh.vertices.push_back(vertex);
        if (!bad && !is_finite(vertex)) bad = vertex;
    }
    const std::size_t corners = mesh.vertices.size() - first;
    if (corners < 3) scanner.fail(fmt::format("a facet needs three vertices or more, not {}", corners));
    const auto begin = static_cast<std::uint32_t>(first);
    if (notes != nullptr && bad) {
        mesh.vertices.resize(first);
        notes->skip_face(fmt::format("line {}", facet_line), *bad);
    } else if (corners == 3) {
        mesh.triangles.push_back({begin, begin + 1, begin + 2});
    } else {
        std::vector<std::uint32_t> polygon(corners);
        std::iota(polygon.begin(), polygon.end(), begin);
        Polygons polygons;
        polygons.add(mesh, polygon);
        uncut.add(polygons.triangulate(mesh));
    }
    const std::string_view end = joined_end(scanner, scanner.word_of_text());
    if (!equals_ignoring_case(end, "endfacet")) scanner.fail_word("'endfacet'", end);
}

/// Facets until no more than `rest` bytes of the text are left, or else until all solids have ended. Whether the
/// scanner stands in a solid, between facets, is given and returned. notes: as of read_facet().
bool read_solids(TextScanner& scanner, bool in_solid, std::optional<std::size_t> rest, MeshArrays& mesh,
                 UncutPolygons& uncut, ReadingNotes* notes = nullptr) {
    // A file may hold several solids; the rest of the lines "solid" and "endsolid" is a name.
    while (in_solid || scanner.next_line()) {
        if (!in_solid) {
            expect(scanner, "solid");
            mesh.runs.push_back({mesh.triangles.size(), name_in(scanner)});
            scanner.next_line();
            in_solid = true;
        }
        if (rest && scanner.remaining() <= *rest) return true;
        const std::string_view word = joined_end(scanner, scanner.word_of_text());
        if (equals_ignoring_case(word, "endsolid"))
            in_solid = false;
        else if (equals_ignoring_case(word, "facet"))
            read_facet(scanner, mesh, uncut, notes);
        else
            scanner.fail_word("'facet' or 'endsolid'", word);
    }
    return false;
}

/// The offsets of parts of a text that can be read in parallel. A part begins after what looks like the end of a facet.
std::vector<std::size_t> begins_of_parts(std::string_view text) {
    constexpr std::size_t part_bytes = std::size_t{1} << 20;
    constexpr std::string_view end_of_facet = "endfacet";
    std::vector<std::size_t> begins{0};
    while (text.size() - begins.back() > part_bytes) {
        const std::size_t end = text.find(end_of_facet, begins.back() + part_bytes);
        if (end == std::string_view::npos) break;
        begins.push_back(end + end_of_facet.size());
    }
    return begins;
}

/// Resizes an empty vector, on huge pages if it is large.
template <class Value>
void resize_on_huge_pages(std::vector<Value>& values, std::size_t size) {
    values.reserve(size);
    advise_huge_pages(values.data(), size * sizeof(Value));
    values.resize(size);
}

MeshArrays joined(std::span<const MeshArrays> parts) {
    std::vector<std::size_t> first_vertex{0}, first_triangle{0};
    for (const MeshArrays& part : parts) {
        first_vertex.push_back(first_vertex.back() + part.vertices.size());
        first_triangle.push_back(first_triangle.back() + part.triangles.size());
    }
    MeshArrays mesh;
    resize_on_huge_pages(mesh.vertices, first_vertex.back());
    resize_on_huge_pages(mesh.triangles, first_triangle.back());
    for_each_index(
        parts.size(),
        [&](std::size_t i) {
            std::ranges::copy(parts[i].vertices, mesh.vertices.data() + first_vertex[i]);
            const auto first = static_cast<std::uint32_t>(first_vertex[i]);
            std::ranges::transform(parts[i].triangles, mesh.triangles.data() + first_triangle[i],
                                   [first](const Triangle& triangle) -> Triangle {
                                       return {first + triangle[0], first + triangle[1], first + triangle[2]};
                                   });
        },
        1);
    // A part that begins in a solid goes on with the run before it.
    for (std::size_t i = 0; i < parts.size(); ++i)
        for (const GroupRun& run : parts[i].runs)
            mesh.runs.push_back({first_triangle[i] + run.first_triangle, run.name});
    return mesh;
}

/// Reads the parts of a text on all cores. Nothing if one of them has an error, or does not end where the next one
/// begins, in a solid and between facets: if all do, this is what reading them one after the other gives.
std::optional<MeshArrays> read_parts(const FileContent& file, UncutPolygons& uncut) {
    const std::vector<std::size_t> begins = begins_of_parts(file.text());
    if (begins.size() == 1) return {};
    std::vector<MeshArrays> parts(begins.size());
    std::vector<UncutPolygons> uncut_of_parts(begins.size());
    std::atomic<bool> all_fit = true;
    for_each_index(
        parts.size(),
        [&](std::size_t i) {
            if (!all_fit) return;
            TextScanner scanner(file.text().substr(begins[i]), file.path(), {});
            const bool is_last = i + 1 == parts.size();
            const std::size_t rest = is_last ? 0 : file.size() - begins[i + 1];
            try {
                const bool in_solid = read_solids(scanner, i > 0, is_last ? std::nullopt : std::optional(rest),
                                                  parts[i], uncut_of_parts[i]);
                if (!is_last && (!in_solid || scanner.remaining() != rest)) all_fit = false;
            } catch (const Error&) {
                all_fit = false;
            }
        },
        1);
    if (!all_fit) return {};
    std::size_t triangles = 0;
    for (std::size_t i = 0; i < parts.size(); ++i) {
        uncut_of_parts[i].first_triangle += triangles;
        uncut.add(uncut_of_parts[i]);
        triangles += parts[i].triangles.size();
    }
    return joined(parts);
}

MeshArrays read_ascii(const FileContent& file, ReadingNotes& notes) {
    if (std::optional<MeshArrays> mesh = read_parts(file, notes.uncut)) return std::move(*mesh);
    // As a whole: errors and bad facets have their line here.
    TextScanner scanner(file.text(), file.path(), {});
    MeshArrays mesh;
    read_solids(scanner, false, {}, mesh, notes.uncut, notes.skip_bad_facets ? &notes : nullptr);
    return mesh;
}

}  // namespace

bool has_size_of_binary_stl(const FileContent& file) {
    const std::optional<std::size_t> count = binary_triangle_count(file);
    return count && file.size() == header_bytes + *count * triangle_bytes;
}

MeshArrays read_stl(const FileContent& file, ReadingNotes& notes) {
    // The size tells, because the header of a binary file may begin with "solid" as well.
    const std::optional<std::size_t> count = binary_triangle_count(file);
    if (has_size_of_binary_stl(file)) return read_binary(file, *count, notes);
    const bool has_zero_byte = file.text().substr(0, 4096).find('\0') != std::string_view::npos;
    if (starts_with_solid(file) && !has_zero_byte) return read_ascii(file, notes);
    // Some programs write bytes after the last triangle. With room for another triangle the count may be wrong.
    if (const std::size_t size = header_bytes + count.value_or(0) * triangle_bytes;
        count && file.size() > size && file.size() - size < triangle_bytes)
        return read_binary(file, *count, notes);
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
    throw Error(
        ErrorCode::unreadable_input,
        fmt::format("{}: the header claims {} triangle{}, so the file should have {} bytes, but it has {}", file.path(),
                    *count, *count == 1 ? "" : "s", header_bytes + *count * triangle_bytes, file.size()));
}

}  // namespace clsdf
