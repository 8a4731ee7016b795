#include "io/meshes/mesh_files.hpp"
#include "io/meshes/ply_header.hpp"
#include "io/meshes/polygons.hpp"
#include "tools/text.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace clsdf {
namespace {

/// The rows of a text file: one on each line.
class TextRows {
public:
    TextRows(const FileContent& file, const PlyHeader& header)
        : scanner_(file.text().substr(header.bytes.front()), file.path(), {}, header.lines + 1) {}

    void begin_row(const PlyElement& element, std::size_t row) {
        if (!scanner_.next_line())
            scanner_.fail(
                fmt::format("the file ends after {} of {} rows of {}", row, element.count, quoted(element.name)));
    }
    void end_row() {
        if (!scanner_.at_end_of_line()) scanner_.fail("the line has more values than the header has properties");
    }
    /// The bytes after the last row: none.
    std::size_t end(const PlyElement& last) {
        if (scanner_.next_line())
            scanner_.fail(fmt::format("this line follows the {} rows of {} that the header counts", last.count,
                                      quoted(last.name)));
        return 0;
    }
    double real(PlyType) { return scanner_.real("a number"); }
    std::int64_t integer(PlyType) { return scanner_.integer("an integer"); }
    void skip(PlyType) {
        if (scanner_.word().empty()) scanner_.fail_word("a number", {});
    }
    [[noreturn]] void fail(ErrorCode code, const std::string& reason) const { scanner_.fail(code, reason); }
    std::string place() const { return fmt::format("line {}", scanner_.line()); }

private:
    TextScanner scanner_;
};

/// The rows of a binary file: numbers without anything between them.
class BinaryRows {
public:
    BinaryRows(const FileContent& file, const PlyHeader& header, std::size_t begin)
        : path_(&file.path()),
          bytes_(file.bytes().subspan(begin)),
          order_(header.format == PlyFormat::binary_big_endian ? std::endian::big : std::endian::little) {}

    void begin_row(const PlyElement& element, std::size_t row) {
        element_ = &element;
        row_ = row;
    }
    void end_row() {}
    /// The bytes after the last row, some programs write more; 0 if they are blank.
    std::size_t end(const PlyElement&) const {
        const auto is_blank = [](std::byte b) {
            return b == std::byte{' '} || (b >= std::byte{'\t'} && b <= std::byte{'\r'});
        };
        return std::ranges::all_of(bytes_, is_blank) ? 0 : bytes_.size();
    }
    double real(PlyType type) { return read<double>(type); }
    std::int64_t integer(PlyType type) {
        if (type == PlyType::uint64) {
            const auto number = read<std::uint64_t>(type);
            if (number > static_cast<std::uint64_t>(std::numeric_limits<std::int64_t>::max()))
                fail(ErrorCode::unreadable_input, fmt::format("the integer {} is out of range", number));
            return static_cast<std::int64_t>(number);
        }
        return read<std::int64_t>(type);
    }
    void skip(PlyType type) { take(size_of(type)); }
    [[noreturn]] void fail(ErrorCode code, const std::string& reason) const {
        throw Error(code, fmt::format("{}: {}: {}", *path_, place(), reason));
    }
    std::string place() const { return fmt::format("row {} of {}", row_, quoted(element_->name)); }

private:
    const std::byte* take(std::size_t count) {
        if (count > bytes_.size()) fail(ErrorCode::unreadable_input, "the file ends here");
        const std::byte* address = bytes_.data();
        bytes_ = bytes_.subspan(count);
        return address;
    }

    template <typename Result>
    Result read(PlyType type) {
        const std::byte* address = take(size_of(type));
        switch (type) {
            case PlyType::int8:
                return static_cast<Result>(load<std::int8_t>(address, order_));
            case PlyType::uint8:
                return static_cast<Result>(load<std::uint8_t>(address, order_));
            case PlyType::int16:
                return static_cast<Result>(load<std::int16_t>(address, order_));
            case PlyType::uint16:
                return static_cast<Result>(load<std::uint16_t>(address, order_));
            case PlyType::int32:
                return static_cast<Result>(load<std::int32_t>(address, order_));
            case PlyType::uint32:
                return static_cast<Result>(load<std::uint32_t>(address, order_));
            case PlyType::int64:
                return static_cast<Result>(load<std::int64_t>(address, order_));
            case PlyType::uint64:
                return static_cast<Result>(load<std::uint64_t>(address, order_));
            case PlyType::float32:
                return static_cast<Result>(load<float>(address, order_));
            case PlyType::float64:
                break;
        }
        return static_cast<Result>(load<double>(address, order_));
    }

    const std::string* path_;
    std::span<const std::byte> bytes_;
    std::endian order_;
    const PlyElement* element_ = nullptr;
    std::size_t row_ = 0;
};

[[noreturn]] void fail_header(const FileContent& file, const std::string& reason,
                              ErrorCode code = ErrorCode::unreadable_input) {
    throw Error(code, fmt::format("{}: {}", file.path(), reason));
}

/// Which properties of the file make the mesh.
struct Layout {
    std::size_t vertex_count = 0;
    std::array<std::size_t, 3> coordinates{};
    std::optional<std::size_t> corners;  ///< of the element 'face'
    std::optional<std::size_t> strips;   ///< of the element 'tristrips'
    std::optional<std::size_t> group;    ///< of the element 'face', if groups are asked for
};

Layout find_vertices(const FileContent& file, const PlyHeader& header) {
    Layout layout;
    const PlyElement* vertex = header.find("vertex");
    if (vertex == nullptr) fail_header(file, "there is no element 'vertex'");
    layout.vertex_count = vertex->count;
    for (std::size_t axis = 0; axis < 3; ++axis) {
        const std::string name(1, "xyz"[axis]);
        const std::optional<std::size_t> place = vertex->find(name);
        if (!place || vertex->properties[*place].count_type)
            fail_header(file, fmt::format("the element 'vertex' has no coordinate '{}'", name));
        layout.coordinates[axis] = *place;
    }
    return layout;
}

/// The list of vertices that an element of faces has.
std::size_t find_list(const FileContent& file, const PlyElement& element) {
    std::optional<std::size_t> found = element.find("vertex_indices");
    if (!found) found = element.find("vertex_index");
    if (!found) fail_header(file, fmt::format("the element {} has no list 'vertex_indices'", quoted(element.name)));
    const PlyProperty& list = element.properties[*found];
    if (!list.count_type || list.type == PlyType::float32 || list.type == PlyType::float64)
        fail_header(file, fmt::format("the property '{}' is no list of integers", list.name));
    return *found;
}

std::size_t find_group(const FileContent& file, const PlyElement& face, const std::string& group_by) {
    const std::optional<std::size_t> group = face.find(group_by);
    if (!group) {
        std::string names;
        for (const PlyProperty& property : face.properties) names += (names.empty() ? "" : ", ") + property.name;
        fail_header(file,
                    fmt::format("the element 'face' has no property {} for groups; its properties are {}",
                                quoted(group_by), names),
                    ErrorCode::invalid_argument);
    }
    const PlyProperty& property = face.properties[*group];
    if (property.count_type || property.type == PlyType::float32 || property.type == PlyType::float64)
        fail_header(file,
                    fmt::format("the property {} of faces is {}; groups need one integer a face", quoted(group_by),
                                property.count_type ? "a list" : "no integer"),
                    ErrorCode::invalid_argument);
    return *group;
}

Layout find_layout(const FileContent& file, const PlyHeader& header, const std::string& group_by) {
    Layout layout = find_vertices(file, header);
    const PlyElement* const face = header.find("face");
    const PlyElement* const strips = header.find("tristrips");
    if (face == nullptr && strips == nullptr)
        fail_header(file,
                    fmt::format("there is no element 'face'{}{}", layout.vertex_count > 0 ? "; " : "",
                                layout.vertex_count > 0 ? cloud_of(layout.vertex_count) : std::string()),
                    ErrorCode::invalid_mesh);
    if (face != nullptr) layout.corners = find_list(file, *face);
    if (strips != nullptr) layout.strips = find_list(file, *strips);
    if (group_by.empty()) return layout;
    if (face == nullptr)
        fail_header(
            file, "triangle strips have no groups; convert the file to one with single faces, or leave the groups out",
            ErrorCode::unsupported);
    layout.group = find_group(file, *face, group_by);
    return layout;
}

template <typename Rows>
std::size_t read_length(Rows& rows, const PlyProperty& list) {
    const std::int64_t length = rows.integer(*list.count_type);
    if (length < 0) rows.fail(ErrorCode::unreadable_input, fmt::format("a list has the length {}", length));
    return static_cast<std::size_t>(length);
}

template <typename Rows>
void skip_property(Rows& rows, const PlyProperty& property) {
    const std::size_t length = property.count_type ? read_length(rows, property) : 1;
    for (std::size_t k = 0; k < length; ++k) rows.skip(property.type);
}

template <typename Rows>
void read_vertices(Rows& rows, const PlyElement& element, const Layout& layout, std::vector<Vec3>& vertices) {
    vertices.reserve(element.count);
    for (std::size_t row = 0; row < element.count; ++row) {
        rows.begin_row(element, row);
        Vec3 vertex{};
        for (std::size_t p = 0; p < element.properties.size(); ++p) {
            const PlyProperty& property = element.properties[p];
            std::size_t axis = 0;
            while (axis < 3 && layout.coordinates[axis] != p) ++axis;
            if (axis < 3)
                vertex[axis] = rows.real(property.type);
            else
                skip_property(rows, property);
        }
        rows.end_row();
        vertices.push_back(vertex);
    }
}

template <typename Rows>
void skip_rows(Rows& rows, const PlyElement& element) {
    if (element.properties.empty()) return;
    for (std::size_t row = 0; row < element.count; ++row) {
        rows.begin_row(element, row);
        for (const PlyProperty& property : element.properties) skip_property(rows, property);
        rows.end_row();
    }
}

template <typename Rows>
std::vector<Vec3> read_points(Rows rows, const PlyHeader& header, const Layout& layout, ReadingNotes& notes) {
    std::vector<Vec3> points;
    for (const PlyElement& element : header.elements) {
        if (element.name == "vertex")
            read_vertices(rows, element, layout, points);
        else
            skip_rows(rows, element);
    }
    notes.bytes_after = rows.end(header.elements.back());
    return points;
}

/// The vertex of an index. Returns nothing, and the index in `missing`, if there is no such vertex and bad faces are
/// skipped.
template <typename Rows>
std::optional<std::uint32_t> vertex_of(Rows& rows, std::int64_t index, std::size_t vertex_count,
                                       const ReadingNotes& notes, std::optional<std::int64_t>& missing) {
    if (index >= 0 && static_cast<std::uint64_t>(index) < vertex_count) return static_cast<std::uint32_t>(index);
    if (!notes.skip_bad_facets)
        rows.fail(ErrorCode::invalid_mesh,
                  fmt::format("the vertex index {} is out of range: there are {} vertices, counted from 0{}", index,
                              vertex_count, bad_facets_remedy));
    if (!missing) missing = index;
    return {};
}

/// The faces of a file on their way into a mesh.
struct Faces {
    const Layout& layout;
    MeshArrays& mesh;
    Polygons& polygons;
    ReadingNotes& notes;
    std::span<const Vec3> vertices;  ///< all of the file, if bad faces are to be skipped

    /// Adds a polygon, or counts it if it is bad or small. missing: a vertex that it names and that does not exist.
    void add(std::span<const std::uint32_t> corners, std::optional<std::int64_t> missing, const auto& where) {
        if (missing)
            notes.skip_face(where(), *missing);
        else if (notes.skip_bad_facets && notes.skips_face_at(corners, vertices, where))
            return;
        else if (corners.size() < 3)
            notes.small_faces.add(where);
        else
            polygons.add(mesh, corners);
    }
};

template <typename Rows>
void read_corners(Rows& rows, const PlyProperty& list, Faces& faces, std::vector<std::uint32_t>& corners) {
    const std::size_t length = read_length(rows, list);
    if (length < 1)
        rows.fail(ErrorCode::unreadable_input, fmt::format("a face needs three corners or more, not {}", length));
    corners.clear();
    std::optional<std::int64_t> missing;
    for (std::size_t k = 0; k < length; ++k)
        if (const auto corner =
                vertex_of(rows, rows.integer(list.type), faces.layout.vertex_count, faces.notes, missing))
            corners.push_back(*corner);
    faces.add(corners, missing, [&] { return rows.place(); });
}

/// The strip a, b, c, d, ... stands for the triangles abc, cbd, ...: every other one is turned. -1 ends a strip. A
/// triangle with a repeated corner joins two parts of a strip, and is no face.
template <typename Rows>
void read_strips(Rows& rows, const PlyProperty& list, Faces& faces) {
    const std::size_t length = read_length(rows, list);
    std::array<std::optional<std::uint32_t>, 3> last;
    std::size_t corners = 0;  // of this strip
    std::array<std::optional<std::int64_t>, 3> missing;
    const auto where = [&] { return rows.place(); };
    for (std::size_t k = 0; k < length; ++k) {
        const std::int64_t index = rows.integer(list.type);
        if (index == -1) {
            corners = 0;
            continue;
        }
        last = {last[1], last[2], std::nullopt};
        missing = {missing[1], missing[2], std::nullopt};
        last[2] = vertex_of(rows, index, faces.layout.vertex_count, faces.notes, missing[2]);
        if (++corners < 3) continue;
        const auto first_missing = std::ranges::find_if(missing, [](const auto& m) { return m.has_value(); });
        if (first_missing != missing.end()) {
            faces.add({}, *first_missing, where);
            continue;
        }
        Triangle triangle{*last[0], *last[1], *last[2]};
        if (corners % 2 == 0) std::swap(triangle[0], triangle[1]);
        if (triangle[0] != triangle[1] && triangle[1] != triangle[2] && triangle[2] != triangle[0])
            faces.add(triangle, {}, where);
    }
}

/// read(property): reads the property with the index `list`. group: the index of one whose values name the groups. The
/// others are skipped.
template <typename Rows, typename Read>
void read_faces(Rows& rows, const PlyElement& element, std::size_t list, std::optional<std::size_t> group,
                MeshArrays& mesh, const Read& read) {
    std::optional<std::int64_t> group_of_run;
    for (std::size_t row = 0; row < element.count; ++row) {
        rows.begin_row(element, row);
        const std::size_t first_triangle = mesh.triangles.size();
        std::int64_t group_of_row = 0;
        for (std::size_t p = 0; p < element.properties.size(); ++p)
            if (p == list)
                read(element.properties[p]);
            else if (p == group)
                group_of_row = rows.integer(element.properties[p].type);
            else
                skip_property(rows, element.properties[p]);
        rows.end_row();
        if (group && group_of_run != group_of_row && mesh.triangles.size() > first_triangle) {
            mesh.runs.push_back({first_triangle, fmt::format("{}", group_of_row)});
            group_of_run = group_of_row;
        }
    }
}

template <typename Rows>
MeshArrays read_body(Rows rows, const PlyHeader& header, const Layout& layout, ReadingNotes& notes) {
    MeshArrays mesh;
    Polygons polygons;
    std::vector<std::uint32_t> corners;
    std::vector<Vec3> all;
    // The faces may come before the vertices.
    if (notes.skip_bad_facets) {
        ReadingNotes ignored;
        all = read_points(rows, header, layout, ignored);
    }
    Faces faces{layout, mesh, polygons, notes, all};
    for (const PlyElement& element : header.elements) {
        if (element.name == "vertex") {
            read_vertices(rows, element, layout, mesh.vertices);
        } else if (element.name == "face") {
            mesh.triangles.reserve(element.count);
            read_faces(rows, element, *layout.corners, layout.group, mesh,
                       [&](const PlyProperty& list) { read_corners(rows, list, faces, corners); });
        } else if (element.name == "tristrips") {
            if (layout.group) mesh.runs.push_back({mesh.triangles.size(), ""});
            read_faces(rows, element, *layout.strips, std::nullopt, mesh,
                       [&](const PlyProperty& list) { read_strips(rows, list, faces); });
        } else {
            skip_rows(rows, element);
        }
    }
    notes.bytes_after = rows.end(header.elements.back());
    notes.uncut = polygons.triangulate(mesh);
    return mesh;
}

/// Reads the rows from where they begin. read(begin, notes): reads them from there. If two places fit the header, it is
/// the one from which the rows end with the file, or else the first that can be read.
template <typename Read>
auto read_from_begin(const PlyHeader& header, ReadingNotes& notes, const Read& read) {
    if (header.bytes.size() == 1) return read(header.bytes[0], notes);
    std::optional<Error> error;
    std::optional<std::size_t> fitting;
    for (const std::size_t begin : header.bytes) {
        try {
            ReadingNotes found = notes;
            auto result = read(begin, found);
            if (found.bytes_after == 0) {
                notes = std::move(found);
                return result;
            }
            if (!fitting) fitting = begin;
        } catch (const Error& failure) {
            if (!error) error = failure;
        }
    }
    if (!fitting) throw *error;
    return read(*fitting, notes);
}

}  // namespace

MeshArrays read_ply(const FileContent& file, ReadingNotes& notes) {
    const PlyHeader header = read_ply_header(file, notes);
    const Layout layout = find_layout(file, header, notes.group_by);
    if (header.format == PlyFormat::ascii) return read_body(TextRows(file, header), header, layout, notes);
    return read_from_begin(header, notes, [&](std::size_t begin, ReadingNotes& found) {
        return read_body(BinaryRows(file, header, begin), header, layout, found);
    });
}

std::vector<Vec3> read_ply_points(const FileContent& file, ReadingNotes& notes) {
    const PlyHeader header = read_ply_header(file, notes);
    const Layout layout = find_vertices(file, header);
    if (header.format == PlyFormat::ascii) return read_points(TextRows(file, header), header, layout, notes);
    return read_from_begin(header, notes, [&](std::size_t begin, ReadingNotes& found) {
        return read_points(BinaryRows(file, header, begin), header, layout, found);
    });
}

}  // namespace clsdf
