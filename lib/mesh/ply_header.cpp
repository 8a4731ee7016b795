#include "mesh/ply_header.hpp"

#include "core/quoted.hpp"
#include "mesh/text_scanner.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <utility>

namespace clsdf {

namespace {

struct TypeName {
    const char* name;
    PlyType type;
};

constexpr std::array<TypeName, 16> type_names{{{"char", PlyType::int8},
                                               {"int8", PlyType::int8},
                                               {"uchar", PlyType::uint8},
                                               {"uint8", PlyType::uint8},
                                               {"short", PlyType::int16},
                                               {"int16", PlyType::int16},
                                               {"ushort", PlyType::uint16},
                                               {"uint16", PlyType::uint16},
                                               {"int", PlyType::int32},
                                               {"int32", PlyType::int32},
                                               {"uint", PlyType::uint32},
                                               {"uint32", PlyType::uint32},
                                               {"float", PlyType::float32},
                                               {"float32", PlyType::float32},
                                               {"double", PlyType::float64},
                                               {"float64", PlyType::float64}}};

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
        // A digit and what separates it from the next one.
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

}  // namespace

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

PlyHeader read_ply_header(const FileContent& file) {
    TextScanner scanner(file.text(), file.path(), {});
    if (!scanner.next_line()) scanner.fail("the file is empty");
    if (const std::string_view word = scanner.word(); word != "ply") scanner.fail_word("the keyword ply", word);
    PlyHeader header;
    bool has_format = false;
    for (;;) {
        if (!scanner.next_line()) scanner.fail("the file ends within its header");
        const std::string_view keyword = scanner.word();
        if (keyword == "end_header") break;
        if (keyword == "comment" || keyword == "obj_info") continue;
        if (keyword == "format") {
            header.format = read_format(scanner);
            has_format = true;
        } else if (keyword == "element") {
            header.elements.push_back(read_element(scanner, header));
        } else if (keyword == "property") {
            if (header.elements.empty()) scanner.fail("a property comes before the first element");
            header.elements.back().properties.push_back(read_property(scanner));
        } else {
            scanner.fail_word("format, element, property, comment or end_header", keyword);
        }
    }
    if (!has_format) scanner.fail("the header names no format");
    if (!scanner.end_line()) scanner.fail("expected the end of the line after end_header");
    header.bytes = file.size() - scanner.remaining();
    header.lines = scanner.line() - 1;
    check_counts(scanner, header, scanner.remaining());
    return header;
}

}  // namespace clsdf
