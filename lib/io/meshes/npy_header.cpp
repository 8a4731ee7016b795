#include "io/meshes/npy_header.hpp"

#include "tools/text.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <charconv>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace clsdf {
namespace {

constexpr std::string_view magic = "\x93NUMPY";
constexpr std::size_t largest_header = std::size_t{1} << 20;

struct NamedType {
    std::string name, type;
    std::size_t components;
};

// Reads the literal {'descr': '<f4', 'fortran_order': False, 'shape': (3, 2, 1), } of numpy's headers.
class DictionaryReader {
public:
    explicit DictionaryReader(std::string_view text) : rest_(text) {}

    bool take(char symbol) {
        skip_blanks();
        if (!rest_.starts_with(symbol)) return false;
        rest_.remove_prefix(1);
        return true;
    }

    std::optional<std::string> take_string() {
        skip_blanks();
        if (rest_.empty() || (rest_.front() != '\'' && rest_.front() != '"')) return std::nullopt;
        const std::size_t end = rest_.find(rest_.front(), 1);
        if (end == std::string_view::npos) return std::nullopt;
        std::string result(rest_.substr(1, end - 1));
        rest_.remove_prefix(end + 1);
        return result;
    }

    std::optional<bool> take_bool() {
        skip_blanks();
        for (const bool value : {false, true}) {
            const std::string_view name = value ? "True" : "False";
            if (rest_.starts_with(name)) {
                rest_.remove_prefix(name.size());
                return value;
            }
        }
        return std::nullopt;
    }

    std::optional<std::vector<std::int64_t>> take_tuple() {
        if (!take('(')) return std::nullopt;
        std::vector<std::int64_t> result;
        while (!take(')')) {
            std::int64_t number = 0;
            skip_blanks();
            const auto [stop, error] = std::from_chars(rest_.data(), rest_.data() + rest_.size(), number);
            if (error != std::errc()) return std::nullopt;
            rest_.remove_prefix(static_cast<std::size_t>(stop - rest_.data()));
            result.push_back(number);
            if (!take(',') && !rest_.starts_with(')')) return std::nullopt;
        }
        return result;
    }

    /// [('distance', '<f4'), ('closest', '<f8', (3,))]
    std::optional<std::vector<NamedType>> take_members() {
        if (!take('[')) return std::nullopt;
        std::vector<NamedType> members;
        while (!take(']')) {
            if (!take('(')) return std::nullopt;
            const std::optional<std::string> name = take_string();
            if (!name || !take(',')) return std::nullopt;
            const std::optional<std::string> type = take_string();
            if (!type) return std::nullopt;
            NamedType member{*name, *type, 1};
            if (take(',') && !rest_.starts_with(')')) {
                const std::optional<std::vector<std::int64_t>> shape = take_tuple();
                if (!shape || shape->size() != 1 || shape->front() < 1 || shape->front() > 4096) return std::nullopt;
                member.components = static_cast<std::size_t>(shape->front());
                take(',');
            }
            if (!take(')')) return std::nullopt;
            members.push_back(std::move(member));
            take(',');
        }
        return members;
    }

    bool at_end() {
        skip_blanks();
        return rest_.empty();
    }

private:
    void skip_blanks() { rest_.remove_prefix(std::min(rest_.find_first_not_of(" \t\n"), rest_.size())); }

    std::string_view rest_;
};

struct Dictionary {
    std::optional<std::string> type;   // of numbers
    std::vector<NamedType> members{};  // of structures
    std::optional<bool> fortran_order;
    std::optional<std::vector<std::int64_t>> shape;
};

// Absent if the text is no such dictionary; members may be absent.
std::optional<Dictionary> parse_dictionary(std::string_view text) {
    DictionaryReader reader(text);
    Dictionary result;
    if (!reader.take('{')) return std::nullopt;
    while (!reader.take('}')) {
        const std::optional<std::string> key = reader.take_string();
        if (!key || !reader.take(':')) return std::nullopt;
        bool understood = false;
        if (*key == "descr") {
            result.type = reader.take_string();
            if (!result.type) result.members = reader.take_members().value_or(std::vector<NamedType>());
            understood = result.type || !result.members.empty();
        } else if (*key == "fortran_order")
            understood = (result.fortran_order = reader.take_bool()).has_value();
        else if (*key == "shape")
            understood = (result.shape = reader.take_tuple()).has_value();
        if (!understood) return std::nullopt;
        reader.take(',');
    }
    return reader.at_end() ? std::optional(result) : std::nullopt;
}

std::uint64_t little_endian(std::string_view bytes) {
    std::uint64_t value = 0;
    for (std::size_t i = bytes.size(); i-- > 0;) value = value << 8 | static_cast<unsigned char>(bytes[i]);
    return value;
}

std::pair<ElementType, std::endian> type_of(const InputFile& file, const std::string& type) {
    static const std::map<std::string, ElementType> types{{"f4", ElementType::float32},
                                                          {"f8", ElementType::float64},
                                                          {"u4", ElementType::uint32},
                                                          {"i8", ElementType::int64},
                                                          {"u1", ElementType::uint8}};
    const auto found = type.empty() ? types.end() : types.find(type.substr(1));
    if (found == types.end() || (type[0] != '<' && type[0] != '>' && type[0] != '|'))
        file.fail(
            fmt::format("header field 'descr': {} is not read; save the array as float64 ('<f8') or float32 ('<f4')",
                        quoted(type, 80)));
    return {found->second, type[0] == '>' ? std::endian::big : std::endian::little};
}

void set_members(NpyHeader& header, const InputFile& file, const std::vector<NamedType>& members) {
    for (const NamedType& member : members) {
        const auto [type, order] = type_of(file, member.type);
        header.members.push_back({member.name, type, order, member.components, header.structure_bytes});
        header.structure_bytes += member.components * bytes_of(type);
    }
}

}  // namespace

NpyHeader read_npy_header(InputFile& file, bool takes_structures) {
    const std::string text = file.beginning(largest_header);
    if (!text.starts_with(magic)) file.fail(R"(not an .npy file: it does not begin with "\x93NUMPY")");
    const int major = text.size() > 6 ? static_cast<unsigned char>(text[6]) : 0;
    const std::size_t length_bytes = major == 1 ? 2 : 4;
    const std::size_t begin = 8 + length_bytes;
    if (text.size() < begin) file.fail("the file is truncated in its header");
    if (major < 1 || major > 3)
        file.fail(fmt::format("version {} of the .npy format is not known; save it with version 1", major));
    const std::uint64_t length = little_endian(std::string_view(text).substr(8, length_bytes));
    if (length > text.size() - begin)
        file.fail(fmt::format("the header claims {} bytes, but only {} follow; the file is truncated", length,
                              text.size() - begin));

    const auto dictionary_text = std::string_view(text).substr(begin, static_cast<std::size_t>(length));
    const std::optional<Dictionary> dictionary = parse_dictionary(dictionary_text);
    const bool has_structures = dictionary && !dictionary->members.empty();
    if (!dictionary || (has_structures ? !takes_structures : !dictionary->type) || !dictionary->fortran_order ||
        !dictionary->shape)
        file.fail(fmt::format("header {} does not state one 'descr', 'fortran_order' and 'shape' of a plain array",
                              quoted(dictionary_text, 80)));
    NpyHeader header;
    if (has_structures) set_members(header, file, dictionary->members);
    const auto [type, order] =
        has_structures ? std::pair(ElementType::uint8, std::endian::little) : type_of(file, *dictionary->type);
    header.values = values_to_the_end(file, type, order, begin + length);
    header.shape = *dictionary->shape;
    header.fortran_order = *dictionary->fortran_order;
    return header;
}

std::string npy_header(std::string_view type, const std::vector<std::int64_t>& shape) {
    std::string dictionary = fmt::format("{{'descr': {}, 'fortran_order': False, 'shape': ({}{}), }}", type,
                                         fmt::join(shape, ", "), shape.size() == 1 ? "," : "");
    // The format requires that values are aligned to 64 bytes and follow a line end.
    constexpr std::size_t prefix = 10;
    const std::size_t padding = 63 - (prefix + dictionary.size()) % 64;
    dictionary.append(padding, ' ');
    dictionary += '\n';
    std::string text(magic);
    text += '\x01';
    text += '\x00';
    text += static_cast<char>(dictionary.size() & 0xFFU);
    text += static_cast<char>(dictionary.size() >> 8U);
    return text + dictionary;
}

const char* npy_name_of(ElementType type) {
    switch (type) {
        case ElementType::float64:
            return "<f8";
        case ElementType::int32:
            return "<i4";
        case ElementType::uint32:
            return "<u4";
        case ElementType::int64:
            return "<i8";
        case ElementType::uint8:
            return "|u1";
        default:
            return "<f4";
    }
}

}  // namespace clsdf
