#include "io/meshes/face_groups.hpp"
#include "io/meshes/mesh_files.hpp"
#include "io/meshes/polygons.hpp"
#include "tools/text.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <limits>
#include <optional>
#include <string>
#include <string_view>
#include <utility>

namespace clsdf {
namespace {

using namespace std::string_view_literals;

/// The values of a vertex after its coordinates: "STOFF", "COFF", "NOFF", "CNOFF" ...
struct VertexKind {
    bool has_normal = false;
    bool has_colour = false;
    bool has_texture = false;
};

std::string upper_case(std::string_view word) {
    std::string upper(word);
    for (char& c : upper)
        if (c >= 'a' && c <= 'z') c = static_cast<char>(c - 'a' + 'A');
    return upper;
}

/// A count of the header, on this line or the next one.
std::size_t read_count(TextScanner& scanner, const char* what) {
    if (scanner.at_end_of_line()) scanner.next_line();
    const std::int64_t count = scanner.integer(what);
    if (count < 0) scanner.fail(fmt::format("{} is negative: {}", what, count));
    return static_cast<std::size_t>(count);
}

VertexKind read_keyword(TextScanner& scanner, std::string_view keyword) {
    // Capital letters, or all small ones: "nOFF" has other dimensions than "NOFF".
    const std::string word = keyword.ends_with("OFF") ? std::string(keyword) : upper_case(keyword);
    std::string_view prefix = std::string_view(word).substr(0, word.size() - 3);
    VertexKind kind;
    if (prefix.starts_with("ST")) {
        kind.has_texture = true;
        prefix.remove_prefix(2);
    }
    // "nOFF" states the dimension before the counts.
    const bool states_dimension = prefix.ends_with('n') && prefix.find('4') == std::string_view::npos;
    if (states_dimension) prefix.remove_suffix(1);
    if (prefix.find_first_not_of("CN") == std::string_view::npos &&
        (!states_dimension || read_count(scanner, "the number of dimensions") == 3)) {
        kind.has_colour = prefix.find('C') != std::string_view::npos;
        kind.has_normal = prefix.find('N') != std::string_view::npos;
        return kind;
    }
    if (prefix.find_first_not_of("CN4n") == std::string_view::npos)
        scanner.fail(ErrorCode::unsupported,
                     fmt::format("{} has vertices of other than three dimensions", quoted(keyword)));
    scanner.fail(fmt::format("expected the keyword OFF, found {}", quoted(keyword)));
}

/// The number of edges, which is not used. It may be on a line of its own if the other counts are.
void skip_edge_count(TextScanner& scanner, bool counts_on_own_lines) {
    if (!counts_on_own_lines || !scanner.at_end_of_line()) return;
    TextScanner ahead = scanner;
    if (!ahead.next_line()) return;
    const std::string_view word = ahead.word();
    if (ahead.at_end_of_line() && word.find_first_not_of("0123456789") == std::string_view::npos) scanner = ahead;
}

struct Header {
    VertexKind kind;
    std::size_t vertices = 0;
    std::size_t faces = 0;
};

/// The keyword, if there is one, up to the counts.
VertexKind skip_keyword(TextScanner& scanner) {
    const TextScanner start = scanner;
    const std::string_view keyword = scanner.word();
    const std::string upper = upper_case(keyword);
    if (upper.ends_with("OFF")) {
        const VertexKind kind = read_keyword(scanner, keyword);
        TextScanner after = scanner;
        if (equals_ignoring_case(after.word(), "binary"))
            scanner.fail(ErrorCode::unsupported, "this is a binary OFF file; convert it to text");
        return kind;
    }
    scanner = start;
    if (upper.starts_with("OFF") && upper.find_first_not_of("0123456789", 3) == std::string_view::npos)
        scanner.skip(3);  // files of ModelNet40 lack the space after the keyword
    else if (keyword.find_first_not_of("0123456789") != std::string_view::npos)
        scanner.fail(fmt::format("expected the keyword OFF, found {}", quoted(keyword)));
    return {};  // the keyword may be missing; then the file begins with the counts
}

void check_counts(const TextScanner& scanner, const Header& header) {
    // "0 0 0" and "1 0" with the line's end; the last line may lack it.
    constexpr std::size_t vertex_bytes = 6;
    constexpr std::size_t face_bytes = 4;
    const std::size_t bytes = scanner.remaining() + 1;
    if (header.vertices > bytes / vertex_bytes || header.faces > bytes / face_bytes ||
        header.vertices * vertex_bytes + header.faces * face_bytes > bytes)
        scanner.fail(fmt::format("the header claims {} vertices and {} faces, more than the {} bytes after it can hold",
                                 header.vertices, header.faces, scanner.remaining()));
}

Header read_header(TextScanner& scanner) {
    scanner.first_line();
    Header header;
    header.kind = skip_keyword(scanner);
    header.vertices = read_count(scanner, "the number of vertices");
    const bool on_own_lines = scanner.at_end_of_line();
    header.faces = read_count(scanner, "the number of faces");
    skip_edge_count(scanner, on_own_lines);
    check_counts(scanner, header);
    return header;
}

/// Adds a face, or counts it if it has fewer than three corners or is bad. next: returns the next integer.
template <typename Next>
void read_face(const TextScanner& scanner, const Next& next, std::vector<std::uint32_t>& corners, ReadingNotes& notes,
               Polygons& polygons, MeshArrays& mesh) {
    const auto where = [&] { return fmt::format("line {}", scanner.line()); };
    const std::size_t vertex_count = mesh.vertices.size();
    const std::int64_t count = next("a face's number of corners");
    if (count < 1) scanner.fail(fmt::format("a face needs three corners or more, not {}", count));
    corners.clear();
    std::optional<std::int64_t> missing;
    for (std::int64_t k = 0; k < count; ++k) {
        const std::int64_t index = next("a vertex index");
        if (index >= 0 && static_cast<std::uint64_t>(index) < vertex_count)
            corners.push_back(static_cast<std::uint32_t>(index));
        else if (!notes.skip_bad_facets)
            scanner.fail(ErrorCode::invalid_mesh,
                         fmt::format("the vertex index {} is out of range: there are {} vertices, counted from 0{}",
                                     index, vertex_count, bad_facets_remedy));
        else if (!missing)
            missing = index;
    }
    if (missing)
        notes.skip_face(where(), *missing);
    else if (notes.skip_bad_facets && notes.skips_face_at(corners, mesh.vertices, where))
        return;
    else if (count < 3)
        notes.small_faces.add(where);
    else
        polygons.add(mesh, corners);
}

/// A vertex and a face on each line, which may have more values: normals, colours and texture coordinates.
MeshArrays read_off_lines(TextScanner scanner, const Header& header, ReadingNotes& notes) {
    MeshArrays mesh;
    mesh.vertices.reserve(header.vertices);
    mesh.triangles.reserve(header.faces);
    for (std::size_t i = 0; i < header.vertices; ++i) {
        if (!scanner.next_line())
            scanner.fail(fmt::format("the file ends after {} of {} vertices", i, header.vertices));
        const double x = scanner.real("a coordinate");
        const double y = scanner.real("a coordinate");
        const double z = scanner.real("a coordinate");
        mesh.vertices.push_back({x, y, z});
    }
    Polygons polygons;
    std::vector<std::uint32_t> corners;
    const auto next = [&](const char* what) { return scanner.integer(what); };
    for (std::size_t i = 0; i < header.faces; ++i) {
        if (!scanner.next_line()) scanner.fail(fmt::format("the file ends after {} of {} faces", i, header.faces));
        read_face(scanner, next, corners, notes, polygons, mesh);
    }
    if (scanner.next_line())
        scanner.fail(fmt::format("this line follows the {} vertices and {} faces that the header counts",
                                 header.vertices, header.faces));
    notes.uncut = polygons.triangulate(mesh);
    return mesh;
}

/// Goes to the next word of the text.
bool next_word(TextScanner& scanner) {
    return !scanner.at_end_of_line() || scanner.next_line();
}

/// Line ends are blanks: the values of vertices follow from the keyword, and faces have no colours.
/// colour_values: of a vertex.
MeshArrays read_free_off(TextScanner scanner, std::size_t colour_values, ReadingNotes& notes) {
    scanner.first_line();
    Header header;
    header.kind = skip_keyword(scanner);
    const auto integer = [&](const char* what) {
        next_word(scanner);
        return scanner.integer(what);
    };
    const auto real = [&] {
        next_word(scanner);
        return scanner.real("a coordinate");
    };
    const auto count = [&](const char* what) {
        const std::int64_t number = integer(what);
        if (number < 0) scanner.fail(fmt::format("{} is negative: {}", what, number));
        return static_cast<std::size_t>(number);
    };
    header.vertices = count("the number of vertices");
    header.faces = count("the number of faces");
    count("the number of edges");
    check_counts(scanner, header);
    const std::size_t more = (header.kind.has_normal ? 3 : 0) + (header.kind.has_colour ? colour_values : 0) +
                             (header.kind.has_texture ? 2 : 0);
    MeshArrays mesh;
    mesh.vertices.reserve(header.vertices);
    mesh.triangles.reserve(header.faces);
    for (std::size_t i = 0; i < header.vertices; ++i) {
        if (!next_word(scanner)) scanner.fail(fmt::format("the file ends after {} of {} vertices", i, header.vertices));
        const double x = real();
        const double y = real();
        const double z = real();
        for (std::size_t k = 0; k < more; ++k) real();
        mesh.vertices.push_back({x, y, z});
    }
    Polygons polygons;
    std::vector<std::uint32_t> corners;
    for (std::size_t i = 0; i < header.faces; ++i) {
        if (!next_word(scanner)) scanner.fail(fmt::format("the file ends after {} of {} faces", i, header.faces));
        read_face(scanner, integer, corners, notes, polygons, mesh);
    }
    if (next_word(scanner))
        scanner.fail(fmt::format("more follows the {} vertices and {} faces that the header counts", header.vertices,
                                 header.faces));
    notes.uncut = polygons.triangulate(mesh);
    return mesh;
}

/// The lines with text of a file, up to a limit.
std::size_t count_lines(TextScanner scanner, std::size_t limit) {
    std::size_t lines = 0;
    while (lines < limit && scanner.next_line()) ++lines;
    return lines;
}

}  // namespace

MeshArrays read_off(const FileContent& file, ReadingNotes& notes) {
    const TextScanner start(file.text(), file.path(), {.hash_comments = true});
    TextScanner scanner = start;
    const Header header = read_header(scanner);
    try {
        ReadingNotes found = notes;
        MeshArrays mesh = read_off_lines(scanner, header, found);
        notes = std::move(found);
        return mesh;
    } catch (const Error&) {
        // White space is free in OFF. What is not a line for each vertex and face may be free text.
        if (count_lines(scanner, header.vertices + header.faces + 1) == header.vertices + header.faces) throw;
        const bool is_free =
            count_lines(start, header.vertices / 2 + header.faces / 2 + 1) <= header.vertices / 2 + header.faces / 2;
        for (const std::size_t colour_values : {4U, 3U}) {
            try {
                ReadingNotes found = notes;
                MeshArrays mesh = read_free_off(start, colour_values, found);
                notes = std::move(found);
                return mesh;
            } catch (const Error&) {
                if (is_free && (!header.kind.has_colour || colour_values == 3)) throw;
            }
            if (!header.kind.has_colour) break;
        }
        throw;
    }
}

namespace {

/// Reads the corners of faces. A face may come before its vertices, so the upper limit of indices is known only at the
/// end of the file. The greatest index and its line are kept until then.
class ObjFaces {
public:
    /// The index of "v", "v/vt", "v//vn" or "v/vt/vn": from 1, or back from -1.
    static std::int64_t read_index(const TextScanner& scanner, std::string_view word) {
        const std::string_view number = word.substr(0, word.find('/'));
        std::int64_t index = 0;
        const auto [end, error] = std::from_chars(number.data(), number.data() + number.size(), index);
        if (error != std::errc() || end != number.data() + number.size()) scanner.fail_word("a vertex index", word);
        return index;
    }

    /// The vertex, counted from 0, if the file may have it. vertex_count: of those before the face.
    static std::optional<std::uint32_t> corner_of(std::int64_t index, std::size_t vertex_count) {
        const auto count = static_cast<std::int64_t>(vertex_count);
        if (index == 0 || index < -count || index >= std::numeric_limits<std::uint32_t>::max()) return {};
        return static_cast<std::uint32_t>(index > 0 ? index - 1 : count + index);
    }

    std::uint32_t read_corner(const TextScanner& scanner, std::string_view word, std::size_t vertex_count) {
        const std::int64_t index = read_index(scanner, word);
        const std::optional<std::uint32_t> found = corner_of(index, vertex_count);
        if (!found) fail(scanner, index, vertex_count);
        const std::uint32_t corner = *found;
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
                                 "from -1{}",
                                 index, vertex_count, bad_facets_remedy));
    }

    std::uint32_t greatest_ = 0;
    std::optional<TextScanner> where_greatest_;
};

}  // namespace

namespace {

/// Whether OBJ has the keyword: those of Wavefront's specification, and common extensions.
bool is_obj_keyword(std::string_view word) {
    static constexpr std::array keywords{
        "v"sv,      "f"sv,        "vt"sv,       "vn"sv,   "g"sv,      "o"sv,          "s"sv,        "usemtl"sv,
        "mtllib"sv, "l"sv,        "p"sv,        "vp"sv,   "vc"sv,     "fo"sv,         "mg"sv,       "usemap"sv,
        "maplib"sv, "cstype"sv,   "deg"sv,      "bmat"sv, "step"sv,   "curv"sv,       "curv2"sv,    "surf"sv,
        "parm"sv,   "trim"sv,     "hole"sv,     "scrv"sv, "sp"sv,     "end"sv,        "con"sv,      "bevel"sv,
        "lod"sv,    "c_interp"sv, "d_interp"sv, "res"sv,  "call"sv,   "csh"sv,        "stech"sv,    "ctech"sv,
        "bsp"sv,    "bzp"sv,      "cdc"sv,      "cdp"sv,  "newmtl"sv, "shadow_obj"sv, "trace_obj"sv};
    return std::ranges::find(keywords, word) != keywords.end();
}

/// Divides the vertex by its fourth number w, if it has exactly four: more of them are a colour.
void divide_by_weight(TextScanner& scanner, Vec3& vertex, ReadingNotes& notes) {
    if (scanner.at_end_of_line()) return;
    const std::string_view word = scanner.word();
    if (!scanner.at_end_of_line()) return;
    const double weight = scanner.real_in(word, "the weight w of a vertex");
    if (weight == 1) return;
    if (weight == 0 || !std::isfinite(weight))
        scanner.fail(ErrorCode::invalid_mesh,
                     fmt::format("the vertex has the weight w {}, by which it cannot be divided", weight));
    for (double& coordinate : vertex) coordinate /= weight;
    notes.weights.add([&] { return fmt::format("line {} (w is {})", scanner.line(), weight); });
}

Vec3 read_obj_vertex(TextScanner& scanner, ReadingNotes& notes) {
    const double x = scanner.real("a coordinate");
    const double y = scanner.real("a coordinate");
    const double z = scanner.real("a coordinate");
    Vec3 vertex{x, y, z};
    divide_by_weight(scanner, vertex, notes);
    return vertex;
}

std::vector<Vec3> read_obj_vertices(TextScanner scanner) {
    std::vector<Vec3> vertices;
    ReadingNotes ignored;
    while (scanner.next_line())
        if (scanner.word() == "v") vertices.push_back(read_obj_vertex(scanner, ignored));
    return vertices;
}

/// Reads the corners of a face. Returns false if it is bad, which is counted. all: the file's vertices.
bool read_sound_corners(TextScanner& scanner, std::size_t vertex_count, std::span<const Vec3> all,
                        std::vector<std::uint32_t>& corners, ReadingNotes& notes) {
    const auto where = [&] { return fmt::format("line {}", scanner.line()); };
    std::optional<std::int64_t> missing;
    while (!scanner.at_end_of_line()) {
        const std::int64_t index = ObjFaces::read_index(scanner, scanner.word());
        const std::optional<std::uint32_t> corner = ObjFaces::corner_of(index, vertex_count);
        if (corner && *corner < all.size())
            corners.push_back(*corner);
        else if (!missing)
            missing = index;
    }
    if (missing) notes.skip_face(where(), *missing);
    return !missing && !notes.skips_face_at(corners, all, where);
}

}  // namespace

MeshArrays read_obj(const FileContent& file, ReadingNotes& notes) {
    TextScanner scanner(file.text(), file.path(), {.hash_comments = true, .line_continuation = true});
    // A face may come before its vertices.
    std::vector<Vec3> all;
    if (notes.skip_bad_facets) all = read_obj_vertices(scanner);
    MeshArrays mesh;
    ObjFaces faces;
    Polygons polygons;
    std::vector<std::uint32_t> corners;
    std::string object, group;
    while (scanner.next_line()) {
        const std::string_view keyword = scanner.word();
        if (keyword == "v") {
            mesh.vertices.push_back(read_obj_vertex(scanner, notes));
        } else if (keyword == "f") {
            corners.clear();
            if (notes.skip_bad_facets && !read_sound_corners(scanner, mesh.vertices.size(), all, corners, notes))
                continue;
            while (!scanner.at_end_of_line())
                corners.push_back(faces.read_corner(scanner, scanner.word(), mesh.vertices.size()));
            if (corners.empty()) scanner.fail("a face needs three corners or more, not 0");
            if (corners.size() < 3)
                notes.small_faces.add([&] { return fmt::format("line {}", scanner.line()); });
            else
                polygons.add(mesh, corners);
        } else if (keyword == "o" || keyword == "g") {
            (keyword == "o" ? object : group) = name_in(scanner);
            const bool has_one = object.empty() || group.empty() || object == group;
            mesh.runs.push_back({mesh.triangles.size(),
                                 has_one ? (object.empty() ? group : object) : fmt::format("{}/{}", object, group)});
        } else if (!is_obj_keyword(keyword)) {
            notes.unknown_lines.add([&] { return fmt::format("line {}, {}", scanner.line(), quoted(keyword)); });
        }
    }
    faces.check(mesh.vertices.size());
    notes.uncut = polygons.triangulate(mesh);
    return mesh;
}

}  // namespace clsdf
