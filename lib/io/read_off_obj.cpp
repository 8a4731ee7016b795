#include "io/mesh_files.hpp"
#include "io/polygons.hpp"
#include "tools/text.hpp"

#include <fmt/format.h>

#include <charconv>
#include <limits>
#include <optional>
#include <utility>

namespace clsdf {
namespace {

struct Counts {
    std::size_t vertices;
    std::size_t faces;
};

/// "OFF", or with letters for the values after each vertex's coordinates: "STOFF", "COFF", "NOFF", "CNOFF" ... ...
void check_keyword(const TextScanner& scanner, std::string_view keyword) {
    std::string_view prefix = keyword.substr(0, keyword.size() - 3);
    if (prefix.starts_with("ST")) prefix.remove_prefix(2);
    if (prefix.find_first_not_of("CN") == std::string_view::npos) return;
    if (prefix.find_first_not_of("CN4n") == std::string_view::npos)
        scanner.fail(ErrorCode::unsupported,
                     fmt::format("{} has vertices of other than three dimensions", quoted(keyword)));
    scanner.fail(fmt::format("expected the keyword OFF, found {}", quoted(keyword)));
}

/// A count of the header, on this line or the next one.
std::size_t read_count(TextScanner& scanner, const char* what) {
    if (scanner.at_end_of_line()) scanner.next_line();
    const std::int64_t count = scanner.integer(what);
    if (count < 0) scanner.fail(fmt::format("{} is negative: {}", what, count));
    return static_cast<std::size_t>(count);
}

/// The number of edges, which is not used. It may be on a line of its own if the other counts are.
void skip_edge_count(TextScanner& scanner, bool counts_on_own_lines) {
    if (!counts_on_own_lines || !scanner.at_end_of_line()) return;
    TextScanner ahead = scanner;
    if (!ahead.next_line()) return;
    const std::string_view word = ahead.word();
    if (ahead.at_end_of_line() && word.find_first_not_of("0123456789") == std::string_view::npos) scanner = ahead;
}

Counts read_header(TextScanner& scanner) {
    scanner.first_line();
    TextScanner start = scanner;
    const std::string_view keyword = scanner.word();
    if (keyword.ends_with("OFF")) {
        check_keyword(scanner, keyword);
        TextScanner after_keyword = scanner;
        if (scanner.word() == "BINARY")
            scanner.fail(ErrorCode::unsupported, "this is a binary OFF file; convert it to text");
        scanner = after_keyword;
    } else if (keyword.starts_with("OFF") && keyword.find_first_not_of("0123456789", 3) == std::string_view::npos) {
        // Files of ModelNet40 lack the space after the keyword.
        scanner = start;
        scanner.skip(3);
    } else {
        // The keyword may be missing; then the file begins with the counts.
        if (keyword.find_first_not_of("0123456789") != std::string_view::npos)
            scanner.fail(fmt::format("expected the keyword OFF, found {}", quoted(keyword)));
        scanner = start;
    }
    Counts counts{};
    counts.vertices = read_count(scanner, "the number of vertices");
    const bool on_own_lines = scanner.at_end_of_line();
    counts.faces = read_count(scanner, "the number of faces");
    skip_edge_count(scanner, on_own_lines);

    // "0 0 0" and "3 0 1 2" with the line's end; the last line may lack it.
    constexpr std::size_t vertex_bytes = 6;
    constexpr std::size_t face_bytes = 8;
    const std::size_t bytes = scanner.remaining() + 1;
    if (counts.vertices > bytes / vertex_bytes || counts.faces > bytes / face_bytes ||
        counts.vertices * vertex_bytes + counts.faces * face_bytes > bytes)
        scanner.fail(fmt::format("the header claims {} vertices and {} faces, more than the {} bytes after it can hold",
                                 counts.vertices, counts.faces, scanner.remaining()));
    return counts;
}

void read_face(TextScanner& scanner, std::size_t vertex_count, std::vector<std::uint32_t>& corners) {
    const std::int64_t count = scanner.integer("a face's number of corners");
    if (count < 3) scanner.fail(fmt::format("a face needs three corners or more, not {}", count));
    corners.clear();
    for (std::int64_t k = 0; k < count; ++k) {
        const std::int64_t index = scanner.integer("a vertex index");
        if (index < 0 || static_cast<std::uint64_t>(index) >= vertex_count)
            scanner.fail(ErrorCode::invalid_mesh,
                         fmt::format("the vertex index {} is out of range: there are {} vertices, counted from 0",
                                     index, vertex_count));
        corners.push_back(static_cast<std::uint32_t>(index));
    }
}

}  // namespace

MeshArrays read_off(const FileContent& file) {
    TextScanner scanner(file.text(), file.path(), {.hash_comments = true});
    const Counts counts = read_header(scanner);
    MeshArrays mesh;
    mesh.vertices.reserve(counts.vertices);
    mesh.triangles.reserve(counts.faces);
    for (std::size_t i = 0; i < counts.vertices; ++i) {
        if (!scanner.next_line())
            scanner.fail(fmt::format("the file ends after {} of {} vertices", i, counts.vertices));
        // Normals, colours and texture coordinates may follow on the line.
        const double x = scanner.real("a coordinate");
        const double y = scanner.real("a coordinate");
        const double z = scanner.real("a coordinate");
        mesh.vertices.push_back({x, y, z});
    }
    Polygons polygons;
    std::vector<std::uint32_t> corners;
    for (std::size_t i = 0; i < counts.faces; ++i) {
        if (!scanner.next_line()) scanner.fail(fmt::format("the file ends after {} of {} faces", i, counts.faces));
        // A colour may follow on the line.
        read_face(scanner, counts.vertices, corners);
        polygons.add(mesh, corners);
    }
    if (scanner.next_line())
        scanner.fail(fmt::format("this line follows the {} vertices and {} faces that the header counts",
                                 counts.vertices, counts.faces));
    polygons.triangulate(mesh);
    return mesh;
}

namespace {

/// Reads the corners of faces. A face may come before its vertices, so the upper limit of indices is known only at the
/// end of the file. The greatest index and its line are kept until then.
class ObjFaces {
public:
    /// The vertex index of "v", "v/vt", "v//vn" or "v/vt/vn", counted from 0.
    std::uint32_t read_corner(const TextScanner& scanner, std::string_view word, std::size_t vertex_count) {
        const std::string_view number = word.substr(0, word.find('/'));
        std::int64_t index = 0;
        const auto [end, error] = std::from_chars(number.data(), number.data() + number.size(), index);
        if (error != std::errc() || end != number.data() + number.size()) scanner.fail_word("a vertex index", word);
        const auto count = static_cast<std::int64_t>(vertex_count);
        if (index == 0 || index < -count || index >= std::numeric_limits<std::uint32_t>::max())
            fail(scanner, index, vertex_count);
        const auto corner = static_cast<std::uint32_t>(index > 0 ? index - 1 : count + index);
        if (corner > greatest_) {
            greatest_ = corner;
            where_greatest_ = scanner;
        }
        return corner;
    }

    void check(std::size_t vertex_count) const {
        if (greatest_ >= vertex_count && where_greatest_)
            fail(*where_greatest_, std::int64_t{greatest_} + 1, vertex_count);
    }

private:
    [[noreturn]] static void fail(const TextScanner& scanner, std::int64_t index, std::size_t vertex_count) {
        scanner.fail(ErrorCode::invalid_mesh,
                     fmt::format("the vertex index {} is out of range: there are {} vertices, counted from 1 or back "
                                 "from -1",
                                 index, vertex_count));
    }

    std::uint32_t greatest_ = 0;
    std::optional<TextScanner> where_greatest_;
};

}  // namespace

MeshArrays read_obj(const FileContent& file) {
    TextScanner scanner(file.text(), file.path(), {.hash_comments = true, .line_continuation = true});
    MeshArrays mesh;
    ObjFaces faces;
    Polygons polygons;
    std::vector<std::uint32_t> corners;
    while (scanner.next_line()) {
        const std::string_view keyword = scanner.word();
        if (keyword == "v") {
            // A weight or a colour may follow on the line.
            const double x = scanner.real("a coordinate");
            const double y = scanner.real("a coordinate");
            const double z = scanner.real("a coordinate");
            mesh.vertices.push_back({x, y, z});
        } else if (keyword == "f") {
            corners.clear();
            while (!scanner.at_end_of_line())
                corners.push_back(faces.read_corner(scanner, scanner.word(), mesh.vertices.size()));
            if (corners.size() < 3)
                scanner.fail(fmt::format("a face needs three corners or more, not {}", corners.size()));
            polygons.add(mesh, corners);
        }
    }
    faces.check(mesh.vertices.size());
    polygons.triangulate(mesh);
    return mesh;
}

}  // namespace clsdf
