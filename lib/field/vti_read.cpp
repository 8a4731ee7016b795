#include "field/base64.hpp"
#include "field/description.hpp"
#include "field/formats.hpp"
#include "field/numbers.hpp"
#include "field/vti_document.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <optional>

namespace clsdf {
namespace {

constexpr std::uint64_t largest_description = std::uint64_t{1} << 20;

std::optional<ValueType> parse_type(const std::string& type) {
    if (type == "Float32") return ValueType::float32;
    if (type == "Float64") return ValueType::float64;
    if (type == "UInt32") return ValueType::uint32;
    return std::nullopt;
}

/// The values of the arrays of a document.
class VtiValues {
public:
    VtiValues(InputFile& file, const VtiDocument& document) : file_(file), document_(document) {}

    [[noreturn]] void fail(const VtiArray& array, const std::string& what) const {
        file_.fail(fmt::format("array '{}': {}", array.name.substr(0, 80), what));
    }

    void read(const VtiArray& array, const OutputKind& kind, Field& field) {
        const std::optional<ValueType> type = parse_type(array.type);
        if (!type || !reads_as(*type, kind.type))
            fail(array, fmt::format("type=\"{}\" is not that of {}", array.type.substr(0, 80), kind.content));
        if (array.components != fmt::format("{}", kind.components))
            fail(array, fmt::format("NumberOfComponents=\"{}\": {} has {}", array.components.substr(0, 80),
                                    kind.content, kind.components));
        std::vector<std::int64_t> sizes(field.grid.size.begin(), field.grid.size.end());
        sizes.push_back(kind.components);
        if (array.format == "binary") {
            std::vector<std::byte> bytes = decoded(array);
            const RawValues values{*type, document_.order, 0, bytes.size()};
            checked_count(file_, values, sizes);  // base64 is longer than what it stands for, and lies in the file
            convert_values(bytes, values, kind.type, kind.allocate(field, field.grid.sample_count()));
        } else {
            const RawValues values = appended(array, *type);
            checked_count(file_, values, sizes);
            read_output(file_, values, kind, field);
        }
    }

    /// The letters of a text that lies somewhere in the file.
    std::string text(const VtiArray& array) {
        std::string letters;
        if (array.format == "ascii") {
            letters = letters_of(array);
        } else if (array.format == "binary") {
            for (const std::byte letter : decoded(array)) letters += static_cast<char>(letter);
        } else {
            const RawValues values = appended(array, ValueType::uint32);
            if (values.bytes > largest_description) fail(array, "it is too long for the description of a field");
            letters.resize(static_cast<std::size_t>(values.bytes));
            file_.read(values.offset, std::as_writable_bytes(std::span(letters)));
        }
        return letters.substr(0, letters.find('\0'));
    }

private:
    RawValues appended(const VtiArray& array, ValueType type) {
        if (array.format != "appended")
            fail(array,
                 fmt::format("format=\"{}\" is not read; save it as raw appended data", array.format.substr(0, 80)));
        if (document_.appended_encoding != "raw")
            fail(array, fmt::format("appended data encoded as \"{}\" are not read; save them raw",
                                    document_.appended_encoding.substr(0, 80)));
        const std::uint64_t room = file_.size() - document_.appended_begin;
        if (room < document_.header_width || array.offset > room - document_.header_width)
            fail(array, fmt::format("offset=\"{}\" lies behind the end of the file; it is truncated", array.offset));
        const std::uint64_t begin = document_.appended_begin + array.offset;
        std::array<std::byte, 8> header{};
        const auto bytes = std::span(header).first(document_.header_width);
        file_.read(begin, bytes);
        return {type, document_.order, begin + document_.header_width, number(bytes)};
    }

    // Without the header.
    std::vector<std::byte> decoded(const VtiArray& array) {
        std::optional<std::vector<std::byte>> bytes = decode_base64(array.text);
        if (!bytes || bytes->size() < document_.header_width ||
            number(*bytes) != bytes->size() - document_.header_width)
            fail(array, "its values are not base64, or not as many as they begin with");
        bytes->erase(bytes->begin(), bytes->begin() + static_cast<std::ptrdiff_t>(document_.header_width));
        return std::move(*bytes);
    }

    std::string letters_of(const VtiArray& array) const {
        std::string letters;
        std::string_view rest = array.text;
        while (true) {
            rest.remove_prefix(std::min(rest.find_first_not_of(" \t\r\n"), rest.size()));
            if (rest.empty()) return letters;
            const std::string_view code = rest.substr(0, rest.find_first_of(" \t\r\n"));
            rest.remove_prefix(code.size());
            std::int64_t letter = 0;
            if (!parse_numbers(code, std::span(&letter, 1)) || letter < 0 || letter > 255)
                fail(array, fmt::format("'{}' is not the number of a letter", code.substr(0, 80)));
            letters += static_cast<char>(letter);
        }
    }

    // The number of bytes that stands before values.
    std::uint64_t number(std::span<const std::byte> bytes) const {
        std::uint64_t value = 0;
        for (std::size_t i = 0; i < document_.header_width; ++i) {
            const std::size_t at = document_.order == std::endian::little ? document_.header_width - 1 - i : i;
            value = value << 8 | std::to_integer<std::uint64_t>(bytes[at]);
        }
        return value;
    }

    InputFile& file_;
    const VtiDocument& document_;
};

Grid grid_of(const InputFile& file, const VtiDocument& document) {
    Grid grid;
    grid.origin = document.origin;
    grid.spacing = document.spacing;
    for (std::size_t axis = 0; axis < 3; ++axis) {
        const std::int64_t first = document.extent[2 * axis], last = document.extent[2 * axis + 1];
        constexpr std::int64_t most = std::int64_t{1} << 53;
        if (first < -most || last > most || last < first)
            file.fail(fmt::format("WholeExtent: {} to {} is no range of samples", first, last));
        grid.first[axis] = first;
        grid.size[axis] = last - first + 1;
    }
    grid.validate();
    return grid;
}

const VtiArray* find(const std::vector<VtiArray>& arrays, const std::string& name) {
    const auto found = std::ranges::find(arrays, name, &VtiArray::name);
    return found == arrays.end() ? nullptr : &*found;
}

const VtiArray& find_distance(const InputFile& file, const VtiDocument& document) {
    const auto& arrays = document.point_arrays;
    for (const std::string& name : {std::string(distance_kind().name), document.scalars})
        if (const VtiArray* array = find(arrays, name)) return *array;
    if (arrays.size() == 1) return arrays.front();
    file.fail(
        fmt::format("none of its {} point arrays is called \"distance\", and none is the Scalars", arrays.size()));
}

}  // namespace

Field read_vti(const std::string& path) {
    InputFile file(path);
    const VtiDocument document = parse_vti(file);
    VtiValues values(file, document);

    Field field;
    field.grid = grid_of(file, document);
    field.band = Band::full();
    field.sign = SignRule::automatic;
    if (const VtiArray* description = find(document.field_arrays, "clsdf"))
        field = parse_description(path + ": array 'clsdf'", values.text(*description), field.grid).field;
    values.read(find_distance(file, document), distance_kind(), field);
    for (const OutputKind& kind : extra_kinds())
        if (const VtiArray* array = find(document.point_arrays, kind.name)) values.read(*array, kind, field);
    return field;
}

}  // namespace clsdf
