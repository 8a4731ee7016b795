#include "io/meshes/ply_header.hpp"

#include "tools/text.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <string_view>

namespace clsdf {

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

namespace {

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

}  // namespace

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

}  // namespace clsdf
