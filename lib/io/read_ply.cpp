#include "io/mesh_files.hpp"
#include "io/polygons.hpp"
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

enum class PlyFormat { ascii, binary_little_endian, binary_big_endian };

enum class PlyType { int8, uint8, int16, uint16, int32, uint32, int64, uint64, float32, float64 };

struct PlyProperty {
    std::string name;
    PlyType type = PlyType::int8;
    std::optional<PlyType> count_type;  ///< of a list: the type of its length; always an integer
};

struct PlyElement {
    std::string name;
    std::size_t count = 0;
    std::vector<PlyProperty> properties;

    /// The property's index, if the element has it.
    std::optional<std::size_t> find(const std::string& property) const;
};

struct PlyHeader {
    PlyFormat format = PlyFormat::ascii;
    std::vector<PlyElement> elements;
    /// With the end of its last line. Two if the first byte of the rows may belong to that end; the likely one is
    /// first.
    std::vector<std::size_t> bytes;
    std::size_t lines = 0;

    const PlyElement* find(const std::string& element) const;
};

struct TypeName {
    const char* name;
    PlyType type;
};

// The format has no integers of 64 bits; programs write them under these names.
constexpr std::array<TypeName, 24> type_names{
    {{"char", PlyType::int8},       {"int8", PlyType::int8},        {"uchar", PlyType::uint8},
     {"uint8", PlyType::uint8},     {"short", PlyType::int16},      {"int16", PlyType::int16},
     {"ushort", PlyType::uint16},   {"uint16", PlyType::uint16},    {"int", PlyType::int32},
     {"int32", PlyType::int32},     {"uint", PlyType::uint32},      {"uint32", PlyType::uint32},
     {"int64", PlyType::int64},     {"uint64", PlyType::uint64},    {"int64_t", PlyType::int64},
     {"uint64_t", PlyType::uint64}, {"long", PlyType::int64},       {"ulong", PlyType::uint64},
     {"longlong", PlyType::int64},  {"ulonglong", PlyType::uint64}, {"float", PlyType::float32},
     {"float32", PlyType::float32}, {"double", PlyType::float64},   {"float64", PlyType::float64}}};

bool is_integer(PlyType type) {
    return type != PlyType::float32 && type != PlyType::float64;
}

PlyType read_type(TextScanner& scanner) {
    const std::string_view word = scanner.word();
    for (const auto& [name, type] : type_names)
        if (word == name) return type;
    scanner.fail_word("a type such as float or int", word);
}

std::string read_name(TextScanner& scanner, const char* what) {
    const std::string_view word = scanner.word();
    if (word.empty()) scanner.fail_word(what, word);
    return std::string(word);
}

PlyFormat read_format(TextScanner& scanner) {
    const std::string_view word = scanner.word();
    if (word == "ascii") return PlyFormat::ascii;
    if (word == "binary_little_endian") return PlyFormat::binary_little_endian;
    if (word == "binary_big_endian") return PlyFormat::binary_big_endian;
    scanner.fail_word("ascii, binary_little_endian or binary_big_endian", word);
}

PlyElement read_element(TextScanner& scanner, const PlyHeader& header) {
    PlyElement element;
    element.name = read_name(scanner, "an element's name");
    if (header.find(element.name) != nullptr)
        scanner.fail(fmt::format("there is a second element {}", quoted(element.name)));
    const std::int64_t count = scanner.integer("an element's count");
    if (count < 0) scanner.fail(fmt::format("the count of {} is negative: {}", quoted(element.name), count));
    element.count = static_cast<std::size_t>(count);
    return element;
}

PlyProperty read_property(TextScanner& scanner) {
    PlyProperty property;
    TextScanner after_list = scanner;
    if (after_list.word() == "list") {
        scanner = after_list;
        property.count_type = read_type(scanner);
        if (!is_integer(*property.count_type)) scanner.fail("a list's length must have an integer type");
    }
    property.type = read_type(scanner);
    property.name = read_name(scanner, "a property's name");
    return property;
}

std::size_t size_of(PlyType type) {
    switch (type) {
        case PlyType::int8:
        case PlyType::uint8:
            return 1;
        case PlyType::int16:
        case PlyType::uint16:
            return 2;
        case PlyType::int32:
        case PlyType::uint32:
        case PlyType::float32:
            return 4;
        case PlyType::int64:
        case PlyType::uint64:
        case PlyType::float64:
            break;
    }
    return 8;
}

/// The least number of bytes one row of the element takes.
std::size_t least_row_bytes(const PlyElement& element, PlyFormat format) {
    std::size_t bytes = 0;
    for (const PlyProperty& property : element.properties)
        // A digit and a separator.
        bytes += format == PlyFormat::ascii ? 2 : size_of(property.count_type.value_or(property.type));
    return bytes;
}

void check_counts(const TextScanner& scanner, const PlyHeader& header, std::size_t body_bytes) {
    // The last line of a text may lack its end.
    std::size_t left = body_bytes + (header.format == PlyFormat::ascii ? 1 : 0);
    for (const PlyElement& element : header.elements) {
        const std::size_t row_bytes = least_row_bytes(element, header.format);
        if (row_bytes == 0) continue;
        if (element.count > left / row_bytes)
            scanner.fail(fmt::format("the header claims {} rows of {}, more than the {} bytes after it can hold",
                                     element.count, quoted(element.name), body_bytes));
        left -= element.count * row_bytes;
    }
}

std::optional<std::size_t> PlyElement::find(const std::string& property) const {
    const auto found = std::find_if(properties.begin(), properties.end(),
                                    [&](const PlyProperty& candidate) { return candidate.name == property; });
    if (found == properties.end()) return {};
    return static_cast<std::size_t>(found - properties.begin());
}

const PlyElement* PlyHeader::find(const std::string& element) const {
    const auto found = std::find_if(elements.begin(), elements.end(),
                                    [&](const PlyElement& candidate) { return candidate.name == element; });
    return found == elements.end() ? nullptr : &*found;
}

/// Whether a header's line that begins with this word may be skipped: a comment without its keyword, and no keyword or
/// type in another spelling, which would change the meaning of the rows.
bool is_free_text(TextScanner rest, std::string_view word) {
    const bool is_letter = (word[0] >= 'a' && word[0] <= 'z') || (word[0] >= 'A' && word[0] <= 'Z');
    if (!is_letter || word == "list") return false;
    for (const auto& [name, type] : type_names)
        if (word == name) return false;
    std::string lower(word);
    for (char& c : lower)
        if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
    constexpr std::size_t most_slips = 2;
    for (const char* keyword : {"format", "element", "property", "end_header"})
        if (edit_distance(lower, keyword) <= most_slips) return false;
    const auto is_printable = [](char c) { return static_cast<unsigned char>(c) >= ' ' && c != '\x7F'; };
    while (std::ranges::all_of(word, is_printable)) {
        if (rest.at_end_of_line()) return true;
        word = rest.word();
    }
    return false;
}

/// Where the rows may begin, if the last line of the header ends at `end`: LF, CR LF, LF CR or CR, as its other lines.
/// If the first byte of binary rows is that of a line end, two places fit.
std::vector<std::size_t> begins_of_rows(std::string_view text, std::size_t end) {
    const std::string_view rest = text.substr(end), header = text.substr(0, end);
    if (!rest.starts_with("\r\n") && !rest.starts_with("\n\r")) return {end + 1};
    const std::string_view pair = rest.substr(0, 2);
    bool has_pair = false, has_single = false;
    for (std::size_t at = header.find(pair[0]); at != std::string_view::npos; at = header.find(pair[0], at + 1)) {
        const std::string_view here = header.substr(at);
        // CR LF after LF is an empty line; LF after CR LF is none of LF CR.
        const bool is_pair = here.starts_with(pair) && (pair == "\r\n" || !here.starts_with("\n\r\n"));
        const bool is_end_of_pair = at > 0 && header[at - 1] == pair[1] && pair == "\n\r";
        if (is_pair)
            has_pair = true;
        else if (!is_end_of_pair)
            has_single = true;
    }
    const bool is_pair_likely = has_pair || (pair == "\r\n" && !has_single);
    return is_pair_likely ? std::vector<std::size_t>{end + 2, end + 1} : std::vector<std::size_t>{end + 1, end + 2};
}

/// Throws Error(unreadable_input) with the line, also if the elements could not fit into the file.
PlyHeader read_ply_header(const FileContent& file, ReadingNotes& notes) {
    TextScanner scanner(file.text(), file.path(), {});
    scanner.first_line();
    if (const std::string_view word = scanner.word(); !equals_ignoring_case(word, "ply"))
        scanner.fail_word("the keyword ply", word);
    PlyHeader header;
    bool has_format = false;
    for (;;) {
        if (!scanner.next_line()) scanner.fail("the file ends within its header");
        const std::string_view keyword = scanner.word();
        if (keyword == "end_header") break;
        if (equals_ignoring_case(keyword, "comment") || keyword == "obj_info") continue;
        if (keyword == "format") {
            header.format = read_format(scanner);
            has_format = true;
        } else if (keyword == "element") {
            header.elements.push_back(read_element(scanner, header));
        } else if (keyword == "property") {
            if (header.elements.empty()) scanner.fail("a property comes before the first element");
            header.elements.back().properties.push_back(read_property(scanner));
        } else if (is_free_text(scanner, keyword)) {
            notes.header_lines.add([&] { return fmt::format("line {}, {}", scanner.line(), quoted(keyword)); });
        } else {
            scanner.fail_word("format, element, property, comment or end_header", keyword);
        }
    }
    if (!has_format) scanner.fail("the header names no format");
    if (!scanner.at_end_of_line() || scanner.remaining() == 0)
        scanner.fail("expected the end of the line after end_header");
    header.bytes = begins_of_rows(file.text(), file.size() - scanner.remaining());
    header.lines = scanner.line();
    check_counts(scanner, header, scanner.remaining() - 1);
    return header;
}

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
    std::size_t corners = 0;
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

Layout find_layout(const FileContent& file, const PlyHeader& header) {
    Layout layout = find_vertices(file, header);
    const PlyElement* face = header.find("face");
    if (face == nullptr && header.find("tristrips") != nullptr)
        fail_header(file, "the faces are triangle strips; convert the file to one with single faces",
                    ErrorCode::unsupported);
    if (face == nullptr) fail_header(file, "there is no element 'face'", ErrorCode::invalid_mesh);
    std::optional<std::size_t> corners = face->find("vertex_indices");
    if (!corners) corners = face->find("vertex_index");
    if (!corners) fail_header(file, "the element 'face' has no list 'vertex_indices'");
    const PlyProperty& list = face->properties[*corners];
    if (!list.count_type || list.type == PlyType::float32 || list.type == PlyType::float64)
        fail_header(file, fmt::format("the property '{}' is no list of integers", list.name));
    layout.corners = *corners;
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

template <typename Rows>
void read_corners(Rows& rows, const PlyProperty& list, std::size_t vertex_count, std::vector<std::uint32_t>& corners) {
    const std::size_t length = read_length(rows, list);
    if (length < 1)
        rows.fail(ErrorCode::unreadable_input, fmt::format("a face needs three corners or more, not {}", length));
    corners.clear();
    for (std::size_t k = 0; k < length; ++k) {
        const std::int64_t index = rows.integer(list.type);
        if (index < 0 || static_cast<std::uint64_t>(index) >= vertex_count)
            rows.fail(ErrorCode::invalid_mesh,
                      fmt::format("the vertex index {} is out of range: there are {} vertices, counted from 0", index,
                                  vertex_count));
        corners.push_back(static_cast<std::uint32_t>(index));
    }
}

template <typename Rows>
void read_faces(Rows& rows, const PlyElement& element, const Layout& layout, MeshArrays& mesh, Polygons& polygons,
                ReadingNotes& notes) {
    mesh.triangles.reserve(element.count);
    std::vector<std::uint32_t> corners;
    for (std::size_t row = 0; row < element.count; ++row) {
        rows.begin_row(element, row);
        for (std::size_t p = 0; p < element.properties.size(); ++p)
            if (p == layout.corners)
                read_corners(rows, element.properties[p], layout.vertex_count, corners);
            else
                skip_property(rows, element.properties[p]);
        rows.end_row();
        if (corners.size() < 3)
            notes.small_faces.add([&] { return rows.place(); });
        else
            polygons.add(mesh, corners);
    }
}

template <typename Rows>
MeshArrays read_body(Rows rows, const PlyHeader& header, const Layout& layout, ReadingNotes& notes) {
    MeshArrays mesh;
    Polygons polygons;
    for (const PlyElement& element : header.elements) {
        if (element.name == "vertex") {
            read_vertices(rows, element, layout, mesh.vertices);
        } else if (element.name == "face") {
            read_faces(rows, element, layout, mesh, polygons, notes);
        } else {
            skip_rows(rows, element);
        }
    }
    notes.bytes_after = rows.end(header.elements.back());
    polygons.triangulate(mesh);
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
    const Layout layout = find_layout(file, header);
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
