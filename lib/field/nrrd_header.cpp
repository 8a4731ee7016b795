#include "field/nrrd_header.hpp"

#include "core/quoted.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <optional>

namespace clsdf {
namespace {

constexpr std::size_t largest_header = std::size_t{1} << 20;
constexpr std::string_view blanks = " \t";

std::string_view trimmed(std::string_view text) {
    const std::size_t begin = text.find_first_not_of(blanks);
    if (begin == std::string_view::npos) return {};
    return text.substr(begin, text.find_last_not_of(blanks) - begin + 1);
}

std::string lower_case(std::string_view text) {
    std::string result(text);
    std::transform(result.begin(), result.end(), result.begin(), [](char letter) {
        return letter >= 'A' && letter <= 'Z' ? static_cast<char>(letter + 32) : letter;
    });
    return result;
}

// "Space Origin" -> "spaceorigin"; two names of one field become the same.
std::string normalised(std::string_view name) {
    std::string result = lower_case(name);
    std::erase_if(result, [](char letter) { return blanks.find(letter) != std::string_view::npos; });
    return result == "centerings" ? "centers" : result;
}

std::optional<ValueType> parse_type(const std::string& text) {
    static const std::map<std::string, ValueType> types{
        {"float", ValueType::float32},       {"double", ValueType::float64}, {"uint", ValueType::uint32},
        {"unsigned int", ValueType::uint32}, {"uint32", ValueType::uint32},  {"uint32_t", ValueType::uint32}};
    const auto found = types.find(text);
    return found == types.end() ? std::nullopt : std::optional(found->second);
}

}  // namespace

NrrdHeader::NrrdHeader(InputFile& file) : file_(file) {
    const std::string text = file.beginning(largest_header);
    if (!text.starts_with("NRRD000")) file.fail("not an NRRD file: it does not begin with \"NRRD000\" and a version");

    std::size_t begin = 0;
    for (std::size_t number = 1;; ++number) {
        const std::size_t end = text.find('\n', begin);
        if (end == std::string::npos)
            file.fail(
                "the header has no end: an empty line must stand between it and the values; the file is "
                "truncated, or its values lie in another file (save it attached)");
        std::string_view line(text.data() + begin, end - begin);
        begin = end + 1;
        if (line.ends_with('\r')) line.remove_suffix(1);
        if (line.empty()) break;
        if (number > 1) parse_line(line, number);
    }
    data_offset_ = begin;
}

void NrrdHeader::parse_line(std::string_view line, std::size_t number) {
    if (line.starts_with('#')) return;
    const std::size_t colon = line.find(':');
    const std::size_t assignment = line.find(":=");
    if (colon == std::string_view::npos)
        file_.fail(
            fmt::format(R"(header line {}: {} is neither "field: value" nor "key:=value")", number, quoted(line, 80)));
    const bool is_pair = assignment != std::string_view::npos && line.find(": ") > assignment;
    const std::string name = is_pair ? std::string(line.substr(0, assignment)) : normalised(line.substr(0, colon));
    const std::string value =
        is_pair ? unescaped(line.substr(assignment + 2)) : std::string(trimmed(line.substr(colon + 1)));
    if (!(is_pair ? pairs_ : fields_).emplace(name, value).second)
        file_.fail(fmt::format("header line {}: {} is stated a second time", number, quoted(name, 80)));
}

const std::string* NrrdHeader::find(const std::string& field) const {
    const auto found = fields_.find(normalised(field));
    return found == fields_.end() ? nullptr : &found->second;
}

const std::string& NrrdHeader::require(const std::string& field, const std::string& remedy) const {
    const std::string* text = find(field);
    if (text == nullptr) file_.fail(fmt::format("field '{}' is missing; {}", field, remedy));
    return *text;
}

const std::string* NrrdHeader::find_pair(const std::string& key) const {
    const auto found = pairs_.find(key);
    return found == pairs_.end() ? nullptr : &found->second;
}

std::vector<std::int64_t> NrrdHeader::sizes(std::size_t dimensions) const {
    const std::string expected = fmt::format("the field has dimension {}", dimensions);
    const std::string& dimension = require("dimension", expected);
    if (dimension != fmt::format("{}", dimensions)) fail("dimension", dimension, expected);
    const std::string& text = require("sizes", "state the samples along x, y and z");
    std::vector<std::int64_t> sizes(dimensions);
    if (!parse_numbers(text, std::span<std::int64_t>(sizes)))
        fail("sizes", text, fmt::format("expected {} whole numbers", dimensions));
    return sizes;
}

RawValues NrrdHeader::values() const {
    for (const char* field : {"data file", "line skip", "byte skip"})
        if (const std::string* text = find(field); text != nullptr && *text != "0")
            fail(field, *text, "values must follow the header; save it attached (unu save -f nrrd -e raw)");
    const std::string encoding = lower_case(require("encoding", "only raw is read"));
    if (encoding != "raw")
        fail("encoding", encoding, "only raw is read; save it uncompressed (unu save -f nrrd -e raw)");

    const std::string& type_text = require("type", "a distance field is of float or double");
    const std::optional<ValueType> type = parse_type(lower_case(type_text));
    if (!type) fail("type", type_text, "a distance field is of float or double");
    const std::string endian = lower_case(require("endian", "state little or big"));
    if (endian != "little" && endian != "big") fail("endian", endian, "expected little or big");
    return values_to_the_end(file_, *type, endian == "little" ? std::endian::little : std::endian::big, data_offset_);
}

void NrrdHeader::fail(const std::string& field, const std::string& text, const std::string& what) const {
    file_.fail(fmt::format("field '{}': {}: {}", field, quoted(text, 80), what));
}

std::string escaped(std::string_view text) {
    std::string result;
    for (const char letter : text) {
        if (letter == '\\')
            result += "\\\\";
        else if (letter == '\n')
            result += "\\n";
        else
            result += letter;
    }
    return result;
}

std::string unescaped(std::string_view text) {
    std::string result;
    for (std::size_t i = 0; i < text.size(); ++i) {
        const bool is_escape = text[i] == '\\' && i + 1 < text.size() && (text[i + 1] == '\\' || text[i + 1] == 'n');
        if (is_escape) ++i;
        result += is_escape && text[i] == 'n' ? '\n' : text[i];
    }
    return result;
}

}  // namespace clsdf
